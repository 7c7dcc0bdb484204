"""The command line as a user calls it: in a process of its own, or, where imports would take most of the time, in this one."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

import lamella as package
from lamella.cli.main import run_app

SMALL = """\
lamella: 1
title: Small strip
system:
  strip:
    type: plate
    size: [1 m, 100 mm]
    mesh: [2, 1]
    laminate: {ply: {type: isotropic, E: 70 GPa, nu: 0.3, rho: 2700}, thickness: 2 mm}
    markers: {tip: [1 m, 50 mm]}
  root: {type: clamp, on: strip.x-}
  load: {type: point_force, on: strip.tip, force: [0, 0, -0.1 N]}
analysis:
  swing: {type: motion, t_end: 20 ms, integrator: {dt: 1 ms, rho_inf: 0.9}}
output: {frames: 5}
"""
SECONDS = 600  # a first compilation of all kernels on a loaded machine

Command = Callable[..., subprocess.CompletedProcess[str]]


@pytest.fixture(scope="session", autouse=True)
def _interrupts() -> None:
    """Ctrl-C reaches commands even where the tests run in the background, for which shells have it ignored."""
    if signal.getsignal(signal.SIGINT) == signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.fixture
def environment() -> dict[str, str]:
    source = str(Path(package.__file__).parents[1])
    return os.environ | {"MPLBACKEND": "agg", "LAMELLA_RENDERER": "matplotlib", "COLUMNS": "100", "PYTHONPATH": source}


@pytest.fixture
def lamella(tmp_path: Path, environment: dict[str, str]) -> Command:
    """Call ``lamella`` with some words in an empty folder."""

    def call(*words: str | Path, folder: Path = tmp_path) -> subprocess.CompletedProcess[str]:
        command = [sys.executable, "-m", "lamella", *map(str, words)]
        return subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, timeout=SECONDS, check=False)

    return call


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Command:
    """Call ``lamella`` with some words in an empty folder, in this process."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("LAMELLA_RENDERER", "matplotlib")
    monkeypatch.setenv("COLUMNS", "100")

    def call(*words: str | Path) -> subprocess.CompletedProcess[str]:
        capsys.readouterr()
        code = run_app([str(word) for word in words])
        output = capsys.readouterr()
        return subprocess.CompletedProcess(list(map(str, words)), code, output.out, output.err)

    return call


@pytest.fixture
def model(tmp_path: Path) -> Path:
    """A model file that runs in a second."""
    path = tmp_path / "strip.yaml"
    path.write_text(SMALL)
    return path

"""Files are written whole or not at all, and a disk that fills up is told in one message."""

from __future__ import annotations

import os
import subprocess
import sys
from contextlib import AbstractContextManager
from pathlib import Path

import numpy as np
import pytest

import lamella as lm
from lamella.dofs import Signal
from lamella.errors import ResultFileError
from lamella.io.modes import write_modes
from lamella.io.results import ResultWriter
from lamella.io.vtk import write_vtkhdf
from lamella.modal import Modes
from lamella.result import Cause, Outcome, Recorder, Result, Statistics
from lamella.state import State
from lamella.study.outputs import write_signals
from lamella.viz.compose import save_gif
from lamella.viz.page import write_page
from lamella.viz.plots import plot_signals
from lamella.viz.style import save_figure
from lamella.whole import replaced, replaced_hdf5, write_text

FILES = ("a.vtkhdf", "modes.h5", "run.h5", "saved.h5", "a.png", "a.svg", "a.pdf", "a.gif", "a.csv", "a.html")


def write(name: str) -> None:
    """Write one of the files, as runs do."""
    system = lm.System()
    sheet = lm.Laminate(lm.Isotropic("70 GPa", 0.3, 2700), thickness="1 mm")
    system.add(lm.Plate("plate", (1, 1), (4, 4), sheet))
    model = system.compile()
    at, random = np.linspace(0.0, 1.0, 400), np.random.default_rng(1)
    frames = list(model.q0 + 1e-3 * random.random((20, model.n_q)))
    height = Signal("height", "m", (), lambda state: 0.0, "height")
    recorder = Recorder(
        [height], "time", 0.0, 1.0, at=list(at), values=list(random.random((400, 1))),
        frame_at=list(at[:20]), frame_q=frames, frame_v=frames,
    )  # fmt: skip
    none = np.empty(0)
    last = State(1.0, frames[-1], frames[-1], frames[-1], none, none)
    result = Result(model, recorder, last, Outcome(Cause.COMPLETED, 1.0, 1.0), Statistics())
    path = Path(name)
    if path.suffix == ".vtkhdf":
        write_vtkhdf(result, path)
    elif name == "modes.h5":
        write_modes(Modes(model, np.ones(3), random.random((model.n_q, 3)), model.q0), path)
    elif name == "run.h5":
        ResultWriter(path, [height], "time", model.n_q)
    elif name == "saved.h5":
        result.save(path)
    elif path.suffix == ".gif":
        save_gif(random.integers(0, 255, (3, 90, 90, 3), np.uint8), path, 0.1)
    elif path.suffix == ".csv":
        write_signals(result, path)
    elif path.suffix == ".html":
        write_page(path, "word " * 10000)
    else:
        save_figure(plot_signals(result), path)


def write_all(limit: int) -> None:
    """Try to write every file where none may be longer than a limit, and print what is said."""
    import resource  # POSIX alone has it

    resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))
    for name in FILES:
        try:
            write(name)
        except ResultFileError as error:
            print(error)


def run_in(folder: Path, code: str) -> subprocess.CompletedProcess[str]:
    """Run code in a process of its own, in a new folder. It stores no bytecode, of which a limit would leave halves to others."""
    folder.mkdir()
    paths = os.pathsep.join([str(Path(__file__).parent), *(p for p in sys.path if p)])
    environment = os.environ | {"PYTHONPATH": paths, "PYTHONDONTWRITEBYTECODE": "1"}
    command = [sys.executable, "-c", f"import test_whole\n{code}"]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, env=environment, check=False)


@pytest.mark.skipif(sys.platform == "win32", reason="file size limits are a POSIX feature")
def test_full_disk_is_told_and_leaves_nothing(tmp_path: Path) -> None:
    """A limit on the size of files stands for the full disk. In a process of its own: HDF5 would end it."""
    free, full = tmp_path / "free", tmp_path / "full"
    run_in(free, "for name in test_whole.FILES: test_whole.write(name)").check_returncode()  # kernels are stored by this
    assert sorted(path.name for path in free.iterdir()) == sorted(FILES)
    done = run_in(full, "test_whole.write_all(3000)")
    assert done.returncode == 0, done.stderr
    assert not done.stderr
    said = done.stdout.splitlines()
    assert len(said) == len(FILES), said
    for name, line in zip(FILES, said, strict=True):
        assert f"'{name}' cannot be written: " in line
        assert "File too large" in line
    assert not list(full.iterdir())


def spoil(writing: AbstractContextManager[object]) -> None:
    """Fail in the middle of writing."""
    with writing as half:
        if isinstance(half, Path):
            half.write_text("half of the n", "utf-8")
        raise ZeroDivisionError


def test_what_stood_there_stays_until_the_new_file_is_whole(tmp_path: Path) -> None:
    path = tmp_path / "a.txt"
    path.write_text("old", "utf-8")
    with pytest.raises(ZeroDivisionError):
        spoil(replaced(path))
    with pytest.raises(ZeroDivisionError):
        spoil(replaced_hdf5(path))
    assert path.read_text("utf-8") == "old"
    write_text(path, "new")
    assert path.read_text("utf-8") == "new"
    assert [place.name for place in tmp_path.iterdir()] == ["a.txt"]


def test_links_and_devices_stay_what_they_are(tmp_path: Path) -> None:
    target, link = tmp_path / "target.txt", tmp_path / "link.txt"
    target.write_text("old", "utf-8")
    link.symlink_to(target)
    write_text(link, "new")
    assert link.is_symlink()
    assert target.read_text("utf-8") == "new"
    write_text(Path(os.devnull), "nothing")
    assert not Path(os.devnull).is_file()
    with pytest.raises(ResultFileError, match="cannot be written: Is a directory"):
        write_text(tmp_path, "text")

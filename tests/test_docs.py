"""What the pages say is true: their Python runs, their commands and links exist."""

from __future__ import annotations

import importlib.util
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
PAGES = sorted([*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md")])
FENCE = re.compile(r"^```(\w+)\n(.*?)^```", re.MULTILINE | re.DOTALL)
LINK = re.compile(r"\]\(([^)\s]+)\)")
SECONDS = 300  # the slowest page takes some ten seconds, and the first compilation of the kernels on a loaded machine much longer


def blocks(text: str, language: str) -> list[str]:
    """The fenced blocks of one language, in order."""
    return [body for found, body in FENCE.findall(text) if found == language]


def script(text: str) -> str:
    """All Python of a page, as one script; later blocks go on where earlier ones end."""
    return "\n".join(blocks(text, "python"))


def models(text: str) -> list[str]:
    """The whole model files of a page."""
    return [body for body in blocks(text, "yaml") if body.startswith("lamella: 1")]


def studies(text: str) -> list[str]:
    """The study files of a page."""
    return [body for body in blocks(text, "yaml") if body.startswith("study: 1")]


def optimisations(text: str) -> list[str]:
    """The optimisation files of a page."""
    return [body for body in blocks(text, "yaml") if body.startswith("optimize: 1")]


def commands(text: str) -> set[str]:
    """The subcommands of ``lamella`` that a page's shell blocks call."""
    return set(re.findall(r"^(?:\.venv/bin/)?lamella (\w+)", "\n".join(blocks(text, "sh")), re.MULTILINE))


def targets(text: str) -> set[str]:
    """The targets of ``make`` that a page names."""
    return set(re.findall(r"^make (\w+)", "\n".join(blocks(text, "sh")), re.MULTILINE)) | set(re.findall(r"`make (\w+)`", text))


def run(code: str, folder: Path) -> subprocess.CompletedProcess[str]:
    environment = os.environ | {"MPLBACKEND": "agg"}
    command = [sys.executable, "-W", "error::DeprecationWarning:__main__", "-c", code]
    return subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, timeout=SECONDS, check=False)


def name(page: Path) -> str:
    return page.relative_to(ROOT).as_posix()


@pytest.mark.parametrize("page", [page for page in PAGES if script(page.read_text("utf-8"))], ids=name)
def test_python_of_a_page_runs(page: Path, tmp_path: Path) -> None:
    done = run(script(page.read_text("utf-8")), tmp_path)
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize("page", [page for page in PAGES if models(page.read_text("utf-8"))], ids=name)
def test_model_files_of_a_page_are_models(page: Path) -> None:
    from lamella.io.model_file import loads

    for text in models(page.read_text("utf-8")):
        loads(text, name=name(page)).system.compile()


@pytest.mark.parametrize("page", [page for page in PAGES if studies(page.read_text("utf-8"))], ids=name)
def test_study_files_of_a_page_are_studies(page: Path, tmp_path: Path) -> None:
    from lamella.sweep.study import read_study

    for text in studies(page.read_text("utf-8")):
        (tmp_path / "study.yaml").write_text(text, encoding="utf-8")
        assert read_study(tmp_path / "study.yaml").checked().units


@pytest.mark.parametrize("page", [page for page in PAGES if optimisations(page.read_text("utf-8"))], ids=name)
def test_optimisation_files_of_a_page_find_a_best_design(page: Path, tmp_path: Path) -> None:
    from lamella.optimisation.problem import read_optimisation
    from lamella.optimisation.run import run_optimisation

    for text in optimisations(page.read_text("utf-8")):
        (tmp_path / "optimize.yaml").write_text(text, encoding="utf-8")
        found = run_optimisation(read_optimisation(tmp_path / "optimize.yaml"), tmp_path / "out", overwrite=True, pictures=False)
        assert found.converged
        assert found.best.meets


@pytest.mark.parametrize("page", PAGES, ids=name)
def test_links_lead_somewhere(page: Path) -> None:
    for link in LINK.findall(page.read_text("utf-8")):
        if not link.startswith(("http://", "https://", "#", "mailto:")):
            assert (page.parent / link.split("#")[0]).exists(), f"{name(page)} links to {link}"


@pytest.mark.parametrize("page", PAGES, ids=name)
def test_commands_exist(page: Path) -> None:
    text = page.read_text("utf-8")
    makefile = set(re.findall(r"^(\w+):", (ROOT / "Makefile").read_text("utf-8"), re.MULTILINE))
    assert targets(text) <= makefile
    if called := commands(text):
        from typer.main import get_command

        from lamella.cli.main import app

        known = set(getattr(get_command(app), "commands", {}))
        assert called <= known, f"{name(page)}; known are {sorted(known)}"


def test_readme_opens_with_the_two_commands() -> None:
    first = blocks((ROOT / "README.md").read_text("utf-8"), "sh")[0]
    assert [line.split("#")[0].strip() for line in first.splitlines()] == ["make demo", "make test"]


def test_every_decision_is_listed() -> None:
    folder = ROOT / "docs" / "decisions"
    listed = set(LINK.findall((folder / "index.md").read_text("utf-8")))
    assert listed == {page.name for page in folder.glob("0*.md")}


def test_a_page_with_wrong_python_is_found(tmp_path: Path) -> None:
    page = "```python\nx = 1\n```\nThen\n```sh\nlamella run a\n```\n```python\nassert x == 2, 'wrong'\n```\n"
    assert script(page) == "x = 1\n\nassert x == 2, 'wrong'\n"
    assert "wrong" in run(script(page), tmp_path).stderr


def test_commands_and_targets_are_read_from_a_page() -> None:
    page = "```sh\nmake demo  # x\nlamella run a\n.venv/bin/lamella verify\n```\nsee `make bench`"
    assert (targets(page), commands(page)) == ({"demo", "bench"}, {"run", "verify"})


def test_this_is_the_installed_package() -> None:
    found = importlib.util.find_spec("lamella")
    assert found is not None
    assert Path(str(found.origin)).is_relative_to(ROOT / "src")

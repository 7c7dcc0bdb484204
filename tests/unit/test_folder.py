"""The folder of a run's results, made and cleared before anything is computed."""

from __future__ import annotations

from pathlib import Path

import pytest

from lamella.errors import ResultFileError
from lamella.study.folder import open_folder


def put(path: Path, text: str = "") -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text)
    return path


@pytest.mark.parametrize(
    "place", ["run.h5", "variant/run.h5", "still/modes.h5", "variant/still/run.h5", "variant/modes/modes.h5"]
)
def test_results_are_seen_and_replaced_only_when_asked(tmp_path: Path, place: str) -> None:
    """A study has variants, a run several analyses, and a study's variant both."""
    old = put(tmp_path / "out" / place)
    mine = put(old.with_name("notes.txt"), "mine")
    with pytest.raises(ResultFileError, match="holds results already; give --overwrite"):
        open_folder(tmp_path / "out", overwrite=False)
    assert old.exists()
    open_folder(tmp_path / "out", overwrite=True)
    assert not old.exists()
    assert mine.read_text() == "mine"


@pytest.mark.parametrize("name", ["x" * 300, "a\0b"])
@pytest.mark.parametrize("overwrite", [False, True])
def test_names_that_no_folder_can_have_are_refused(tmp_path: Path, name: str, overwrite: bool) -> None:
    with pytest.raises(ResultFileError, match=r"the folder '.*' cannot be written: .*; choose another one with --out"):
        open_folder(tmp_path / name, overwrite)


def test_files_beside_are_no_results(tmp_path: Path) -> None:
    mine = [put(tmp_path / "out" / name, "mine") for name in ("notes.txt", "variant/notes.txt", "variant/still/signals.csv")]
    open_folder(tmp_path / "out", overwrite=False)
    open_folder(tmp_path / "out", overwrite=True)
    assert [path.read_text() for path in mine] == ["mine"] * 3

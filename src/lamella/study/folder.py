"""The folder of a run's results: made, checked and cleared before anything is computed."""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from lamella.errors import ResultFileError

RESULT = "run.h5"
MODES = "modes.h5"
MODEL = "model.yaml"
PICTURES = "pictures"
WRITTEN = (
    *(RESULT, MODES, MODEL, "signals.csv", "modes.csv", "linear.npz", "linear.mat", "surface.vtkhdf", "modes.vtkhdf"),
    *("animation.*", "report.html", "findings.json", PICTURES),
)
"""Everything a run may leave in its folder."""


def open_folder(folder: Path, overwrite: bool) -> Path:
    """Make the folder of a run, or clear what an earlier run left in it.

    Args:
        folder: where to write.
        overwrite: replace the results of an earlier run; other files stay.

    Raises:
        ResultFileError: it holds results and ``overwrite`` is False, it is a file, or it cannot be written to.
    """
    check_folder(folder, overwrite)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            pass
        _clear(folder)
    except (OSError, ValueError) as error:  # of a name with a zero byte
        raise _unwritable(folder, error) from error
    return folder


def _unwritable(folder: Path, error: OSError | ValueError) -> ResultFileError:
    reason = getattr(error, "strerror", None) or error
    return ResultFileError(f"the folder '{folder}' cannot be written: {reason}; choose another one with --out")


def check_folder(folder: Path, overwrite: bool) -> None:
    """Refuse a folder that holds results, unless they may be replaced, or that can be none; nothing is changed yet."""
    try:
        file = folder.exists() and not folder.is_dir()
        held = holds_results(folder)
    except OSError as error:  # a name that is too long
        raise _unwritable(folder, error) from error
    if file:
        raise ResultFileError(f"'{folder}' is a file; accepted is a folder for the results (--out)")
    if held and not overwrite:
        raise ResultFileError(f"'{folder}' holds results already; give --overwrite to replace them, or another folder with --out")


@contextmanager
def swept(folder: Path) -> Iterator[None]:
    """Remove a folder that is made in here, and those above it, if nothing is written into it."""
    made = [place for place in (folder, *folder.parents) if not place.exists()]
    try:
        yield
    finally:
        for place in made:
            if place.is_dir() and not any(place.iterdir()):
                place.rmdir()


def holds_results(folder: Path) -> bool:
    """Whether a run has left something in the folder or in one of its variants or analyses below it."""
    return any(_held(place) for place in _places(folder))


def _places(folder: Path) -> tuple[Path, ...]:
    """A folder, those of a study's variants or of a run's analyses, and those of the analyses of variants."""
    return folder, *folder.glob("*/"), *folder.glob("*/*/")


def _held(place: Path) -> bool:
    return any((place / name).exists() for name in (RESULT, MODES, MODEL, "report.html"))


def _clear(folder: Path) -> None:
    """Remove what earlier runs wrote, in the folder and in those below it that hold a run."""
    for place in (folder, *(inner for inner in _places(folder)[1:] if _held(inner))):
        for pattern in WRITTEN:
            for path in place.glob(pattern):
                shutil.rmtree(path) if path.is_dir() else path.unlink()


def result_path(path: Path) -> Path:
    """The result file meant by a path: itself, or ``run.h5`` in a folder.

    Raises:
        ResultFileError: the folder has no result file, or more than one below it.
    """
    if not path.is_dir():
        return path
    if (path / RESULT).is_file():
        return path / RESULT
    inner = sorted(path.glob(f"*/{RESULT}"))
    if len(inner) == 1:
        return inner[0]
    names = ", ".join(str(file) for file in inner)
    raise ResultFileError(
        f"'{path}' holds {f'several results: {names}' if inner else 'no result file (run.h5)'}; accepted is a result file"
    )

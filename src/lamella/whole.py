"""Files that are written whole or not at all: what stood in their place stays until the new one is complete."""

from __future__ import annotations

import os
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from lamella.errors import ResultFileError


def unwritable(path: Path, error: OSError, what: str = "") -> ResultFileError:
    """The error for a file that cannot be written.

    Args:
        path: the file.
        error: why.
        what: kind of file, with which the message begins.
    """
    item = f"{what} '{path}'".lstrip()
    return ResultFileError(f"{item} cannot be written: {error.strerror or error}; accepted is a file in a writable folder")


PART = ".part."
"""How the names of files begin that are not whole yet."""
ABANDONED = 10.0
"""Seconds after which a small file that is not whole was left by a process that has been killed."""


def remove_abandoned(folder: Path) -> None:
    """Remove what killed processes have left of small files in a folder.

    Raises:
        OSError: it cannot be removed.
    """
    for path in folder.glob(f"{PART}*"):
        if time.time() - path.stat().st_mtime > ABANDONED:
            path.unlink(missing_ok=True)


@contextmanager
def replaced(path: Path, what: str = "") -> Iterator[Path]:
    """A file beside ``path`` to write to; it takes the place of ``path`` at the end, and is removed when writing fails.

    Where ``path`` is a link, what it leads to is replaced; where it is a device such as ``/dev/stdout``, it is written to itself.

    Args:
        path: file to write.
        what: kind of file, for messages.

    Raises:
        ResultFileError: the file cannot be written or moved to its place.
    """
    try:
        if path.exists() and not path.is_file():
            yield path
            return
        place = Path(os.path.realpath(path))
        partial = place.with_name(f"{PART}{os.getpid()}.{place.name}")  # writers that go by the suffix find it
        try:
            yield partial
            os.replace(partial, place)
        finally:
            partial.unlink(missing_ok=True)
    except OSError as error:
        raise unwritable(path, error, what) from error


@contextmanager
def replaced_hdf5(path: Path, **options: Any) -> Iterator[Any]:
    """A new HDF5 file that is made in memory and takes the place of ``path`` at the end.

    HDF5 does not survive a disk that fills up while it writes: it ends the whole process. So it writes to memory alone.

    Args:
        path: file to write.
        options: of ``h5py.File``.

    Raises:
        ResultFileError: the file cannot be written.
    """
    import h5py

    with replaced(path) as partial:
        with h5py.File(path.name, "w", driver="core", backing_store=False, **options) as file:
            yield file
            file.flush()
            content = file.id.get_file_image()
        partial.write_bytes(content)


def write_text(path: Path, text: str, what: str = "") -> None:
    """Write a text file in UTF-8, whole or not at all.

    Args:
        path: file to write.
        text: its content.
        what: kind of file, for messages.

    Raises:
        ResultFileError: it cannot be written.
    """
    with replaced(path, what) as partial:
        partial.write_text(text, encoding="utf-8")

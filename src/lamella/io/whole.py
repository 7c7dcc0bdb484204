"""Files that are written whole or not at all: what stood in their place stays until the new one is complete."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from lamella.errors import ResultFileError

if TYPE_CHECKING:
    from lamella.io.result_layout import Node


@contextmanager
def replaced(path: Path) -> Iterator[Path]:
    """A file beside ``path`` to write to; it takes the place of ``path`` at the end, and is removed when writing fails.

    Where ``path`` is a link, what it leads to is replaced; where it is a device such as ``/dev/stdout``, it is written to itself.

    Raises:
        OSError: the file cannot be moved to its place.
    """
    if path.exists() and not path.is_file():
        yield path
        return
    place = Path(os.path.realpath(path))
    partial = place.with_name(f".{place.name}.{os.getpid()}.part")
    try:
        yield partial
        os.replace(partial, place)
    finally:
        partial.unlink(missing_ok=True)


@contextmanager
def replaced_hdf5(path: Path, **options: Any) -> Iterator[Node]:
    """A new HDF5 file that is made in memory and takes the place of ``path`` at the end.

    HDF5 does not survive a disk that fills up while it writes: it ends the whole process. So it writes to memory alone.

    Args:
        path: file to write.
        options: of ``h5py.File``.

    Raises:
        OSError: the file cannot be written.
    """
    import h5py

    with h5py.File(path.name, "w", driver="core", backing_store=False, **options) as file:
        yield file
        file.flush()
        content = file.id.get_file_image()
    with replaced(path) as partial:
        partial.write_bytes(content)


def write_text(path: Path, text: str) -> None:
    """Write a text file in UTF-8.

    Raises:
        ResultFileError: it cannot be written.
    """
    try:
        with replaced(path) as partial:
            partial.write_text(text, encoding="utf-8")
    except OSError as error:
        raise ResultFileError(f"'{path}' cannot be written: {error.strerror or error}") from error

"""What a result was computed with: the versions that result files and report pages carry."""

from __future__ import annotations

import platform
from functools import cache
from importlib import metadata

LIBRARIES = ("numpy", "scipy", "numba")


def versions() -> dict[str, str]:
    """Versions of this package, Python and the numerical libraries; none is imported for it."""
    from lamella import __version__  # late: the package imports this module's users

    return {"lamella": __version__, "python": platform.python_version()} | {library: _version(library) for library in LIBRARIES}


@cache
def _version(library: str) -> str:
    try:
        return metadata.version(library)
    except metadata.PackageNotFoundError:  # on the path without being installed as a package
        return "unknown"

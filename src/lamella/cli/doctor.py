"""The command ``lamella doctor``: is the installation sound, and what to do when it is not."""

from __future__ import annotations

import importlib.util
import os
import platform
import shutil
import sys
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from importlib import metadata
from pathlib import Path

REQUIRED = (
    "numpy",
    "scipy",
    "numba",
    "pydantic",
    "pint",
    "ruamel.yaml",
    "h5py",
    "h5netcdf",
    "xarray",
    "matplotlib",
    "pillow",
    "jinja2",
    "markdown-it-py",
    "rich",
    "typer",
)
OPTIONAL = {
    "pyvista": ("viz", "smoothly shaded pictures; matplotlib draws them otherwise"),
    "imageio": ("viz", "animations as MP4, together with imageio-ffmpeg"),
    "control": ("control", "linear models as those of python-control; their files for NumPy and MATLAB need nothing"),
    "mkl": ("mkl", "large unsymmetric or indefinite systems; the multifrontal solver built in does all others"),
    "distributed": ("cluster", "parameter studies on a cluster; on one machine they need nothing"),
    "pyarrow": ("parquet", "tables of parameter studies as Parquet; they are written as CSV in any case"),
}
ENOUGH_DISK = 1e9


@dataclass(frozen=True)
class Finding:
    """One thing looked at: ``state`` is ``ok``, ``note`` (works, could be better) or ``problem``."""

    what: str
    state: str
    text: str
    advice: str = ""


def doctor_command() -> int:
    """Print a table of findings; 1 when there is a problem."""
    from rich.console import Console
    from rich.markup import escape
    from rich.table import Table

    findings = [finding for look in LOOKS for finding in _guarded(look)]
    table = Table("", "what", "found", "advice", header_style="bold")
    marks = {"ok": "[green]ok[/]", "note": "[yellow]note[/]", "problem": "[red]problem[/]"}
    for finding in findings:
        table.add_row(marks[finding.state], *map(escape, (finding.what, finding.text, finding.advice)))
    Console(highlight=False, width=None if sys.stdout.isatty() else 140).print(table)
    problems = [finding.what for finding in findings if finding.state == "problem"]
    print(f"{len(problems)} problem(s): {', '.join(problems)}" if problems else "lamella is ready to run")
    return 1 if problems else 0


def _guarded(look: Callable[[], Iterator[Finding]]) -> list[Finding]:
    """A look that itself breaks is a finding too: a diagnosis must not end in a traceback."""
    try:
        return list(look())
    except Exception as error:  # noqa: BLE001  # any failure is what is looked for here
        return [
            Finding(look.__name__.removeprefix("look_at_"), "problem", f"{type(error).__name__}: {error}", "reinstall lamella")
        ]


def look_at_versions() -> Iterator[Finding]:
    """Python, the machine and the libraries needed."""
    yield Finding("python", "ok", f"{platform.python_version()} on {platform.system()} {platform.machine()}")
    for package in REQUIRED:
        try:
            yield Finding(package, "ok", metadata.version(package))
        except metadata.PackageNotFoundError:
            yield Finding(package, "problem", "not installed", f"pip install {package}")


def look_at_extras() -> Iterator[Finding]:
    """Libraries that are optional."""
    for package, (extra, purpose) in OPTIONAL.items():
        if importlib.util.find_spec(package) or _has_distribution(package):
            yield Finding(package, "ok", metadata.version(package))
        else:
            yield Finding(package, "note", f"not installed (for {purpose})", f"pip install 'lamella[{extra}]'")


def _has_distribution(package: str) -> bool:
    try:
        metadata.version(package)
    except metadata.PackageNotFoundError:
        return False
    return True


def look_at_kernels() -> Iterator[Finding]:
    """Where compiled kernels are cached and whether they are there."""
    from lamella._jit import CACHE_FOLDER

    count = len(list(CACHE_FOLDER.rglob("*.nbc"))) if CACHE_FOLDER.is_dir() else 0
    state = f"{count} kernels compiled" if count else "empty: the first run compiles for 10 to 20 s"
    yield Finding("kernel cache", "ok" if count else "note", f"{CACHE_FOLDER} ({state})", "" if count else "nothing to do")
    if not os.access(CACHE_FOLDER, os.W_OK):
        yield Finding("kernel cache", "problem", f"{CACHE_FOLDER} cannot be written", "make it writable: every run compiles anew")


def look_at_threads() -> Iterator[Finding]:
    """How many threads a run takes."""
    from lamella import threads

    asked = f"as {threads.VARIABLE} says" if os.environ.get(threads.VARIABLE) else f"more by {threads.VARIABLE} or --threads"
    yield Finding("threads", "ok", f"{threads.number()} for large models, {asked}; {threads.cores()} cores may be used")


def look_at_pictures() -> Iterator[Finding]:
    """Whether shaded pictures can be drawn."""
    from lamella.viz.renderer import opengl_window

    if window := opengl_window():
        yield Finding("OpenGL", "ok", f"shaded pictures with {window}")
    else:
        advice = "apt install libegl1 libgl1-mesa-dri, and pip install 'lamella[viz]'"
        yield Finding("OpenGL", "note", "none found; pictures are drawn with matplotlib", advice)


def look_at_disk() -> Iterator[Finding]:
    """Room and write access where results and temporary files go."""
    for name, folder in (("working folder", Path.cwd()), ("temporary folder", Path(tempfile.gettempdir()))):
        free = shutil.disk_usage(folder).free
        room = f"{folder}: {free / 1e9:.1f} GB free"
        try:
            with tempfile.TemporaryFile(dir=folder):
                pass
        except OSError as error:
            wrong = "note" if name == "working folder" else "problem"  # results may go elsewhere, temporary files may not
            yield Finding(name, wrong, f"{folder} cannot be written: {error.strerror}", "choose a folder with --out")
            continue
        yield Finding(
            name, "ok" if free > ENOUGH_DISK else "note", room, "" if free > ENOUGH_DISK else "results of long runs may not fit"
        )


def look_at_solution() -> Iterator[Finding]:
    """Solve a small plate, which uses every part of the numerical core."""
    from lamella.io.model_file import loads
    from lamella.statics import equilibrium

    text = (
        "{lamella: 1, system: {p: {type: plate, size: [1, 1], mesh: [1, 1], laminate: {ply: {E: 70e9, nu: 0.3, rho: 2700},"
        " thickness: 0.01}, markers: {tip: [1, 0.5]}}, c: {type: clamp, on: p.x-},"
        " f: {type: point_force, on: p.tip, force: [0, 0, -1]}}}"
    )
    deflection = float(equilibrium(loads(text).system)["tip.position"].values[2])
    expected = -4.0 / (70e9 * 0.01**3)  # slender beam, E I w = F L^3 / 3; a plate of one element is a little stiffer
    good = 0.5 < deflection / expected < 1.2
    yield Finding(
        "solution",
        "ok" if good else "problem",
        f"small plate bends by {-deflection * 1e6:.1f} micrometres",
        "" if good else "reinstall lamella",
    )


LOOKS = (look_at_versions, look_at_extras, look_at_kernels, look_at_threads, look_at_pictures, look_at_disk, look_at_solution)

"""The rules of the architecture: imports go one way, few modules know the heavy libraries, files stay small and well named."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

PACKAGE = Path(__file__).parent.parent / "src" / "lamella"

# From the lowest to the highest; a module imports from its own layer and from those below.
LAYERS = [
    {
        "errors",
        "arguments",
        "memory",
        "whole",
        "remembered",
        "units",
        "declaration",
        "roles",
        "kinematics",
        "switch",
        "trigger",
        "dofs",
        "state",
        "critical",
        "inertia",
        "numbering",
        "result",
        "progress",
        "compilation",
        "_compiler",
        "_jit",
        "lane",
        "lane_rows",
        "threads",
    },
    {"math"},
    {"material"},
    {"element", "constraint", "measure", "surface"},
    {"body"},
    {"joint", "load", "contact", "thermal", "sensor"},
    {"model"},
    {"assembly", "signals", "reaction_signals"},
    {"solve"},
    {"integrate"},
    {
        "system",
        "accepted",
        "ended_early",
        "motion",
        "static_run",
        "statics",
        "shapes",
        "modal",
        "stability",
        "linear",
        "stepping",
    },
    {
        *("__init__", "study", "sweep", "io", "fmu", "viz", "verification", "bench", "examples", "templates"),
        *("differentiation", "optimisation"),
    },  # __init__: the public names
    {"cli", "__main__"},
]
LEVEL = {name: level for level, names in enumerate(LAYERS) for name in names}
# Upward imports that are meant: made late, inside a method that would otherwise be a function elsewhere.
DOORS = {
    ("result", "io"),  # Result.save writes itself
}
HEAVY = {
    *("matplotlib", "pyvista", "vtk", "vtkmodules", "h5py", "h5netcdf", "xarray", "pint", "pandas", "imageio", "PIL"),
    *("jinja2", "markdown_it", "distributed", "dask", "pyarrow"),
}
NUMBA_MODULES = {"_compiler", "_jit", "lane"}
FORBIDDEN_NAMES = {"util", "utils", "utilities", "manager", "helper", "helpers", "misc", "common", "tools"}
LONGEST = 350  # the aim is 300; beyond 350 a file does more than one thing


def imports(source: str) -> Iterator[tuple[str, bool]]:
    """Each imported module with whether it is imported when the file is loaded; imports for type checking do not count."""

    def visit(node: ast.AST, at_load: bool) -> Iterator[tuple[str, bool]]:
        for child in ast.iter_child_nodes(node):
            if isinstance(child, ast.If) and "TYPE_CHECKING" in ast.unparse(child.test):
                for branch in child.orelse:
                    yield from visit(branch, at_load)
            elif isinstance(child, ast.Import):
                yield from ((alias.name, at_load) for alias in child.names)
            elif isinstance(child, ast.ImportFrom):
                assert child.level == 0, f"relative import in line {child.lineno}"
                names = [f"lamella.{alias.name}" for alias in child.names] if child.module == "lamella" else [str(child.module)]
                yield from ((name, at_load) for name in names)
            else:
                inside = isinstance(child, ast.FunctionDef | ast.AsyncFunctionDef | ast.Lambda)
                yield from visit(child, at_load and not inside)

    return visit(ast.parse(source), True)


def problems(place: str, source: str) -> list[str]:
    """What a file breaks; ``place`` is its path inside the package, such as ``load/force.py``."""
    found = []
    parts = place.removesuffix(".py").split("/")
    own = parts[0]
    if own not in LEVEL:
        found.append(f"{place}: '{own}' has no layer; give it one in LAYERS")
    if bad := FORBIDDEN_NAMES & {word for part in parts for word in part.split("_")}:
        found.append(f"{place}: the name says nothing ({', '.join(sorted(bad))})")
    if (lines := len(source.splitlines())) > LONGEST:
        found.append(f"{place}: {lines} lines, at most {LONGEST}")
    for module, at_load in imports(source):
        top, *rest = module.split(".")
        if top in ("numba", "llvmlite") and own not in NUMBA_MODULES:
            found.append(f"{place}: imports {top}; only {', '.join(sorted(NUMBA_MODULES))} may")
        if top in HEAVY and at_load:
            found.append(f"{place}: imports {top} when loaded; import it in the function that needs it")
        if top == "lamella" and own in LEVEL:
            target = rest[0] if rest and rest[0] in LEVEL else "__init__"
            is_door = (own, target) in DOORS and not at_load
            if LEVEL[target] > LEVEL[own] and not is_door:
                found.append(f"{place}: imports lamella.{target}, which lies above '{own}'")
    return found


FILES = sorted(PACKAGE.rglob("*.py"))


@pytest.mark.parametrize("path", FILES, ids=[str(path.relative_to(PACKAGE)) for path in FILES])
def test_file_keeps_the_rules(path: Path) -> None:
    assert problems(path.relative_to(PACKAGE).as_posix(), path.read_text(encoding="utf-8")) == []


@pytest.mark.parametrize(
    ("place", "source", "said"),
    [
        ("element/plate48/block.py", "from lamella.load.force import PointForce", "lies above 'element'"),
        ("material/lamina.py", "from lamella import simulate", "lies above 'material'"),
        ("statics.py", "import lamella as lm", "lies above 'statics'"),
        ("integrate/base.py", "import lamella.cli.main", "lies above 'integrate'"),
        ("math/gauss.py", "def f():\n    from lamella.solve import newton", "lies above 'math'"),
        ("result.py", "from lamella.io import results", "lies above 'result'"),  # a door is open to late imports only
        ("element/plate36/shape.py", "from numba import njit", "only _compiler, _jit, lane may"),
        ("element/plate36/shape.py", "def f():\n    import numba.typed", "only _compiler, _jit, lane may"),
        ("viz/plots.py", "import matplotlib.pyplot as plt", "imports matplotlib when loaded"),
        ("viz/plots.py", "class A:\n    import h5py", "imports h5py when loaded"),
        ("solve/utils.py", "", "says nothing (utils)"),
        ("solve/newton_helper.py", "", "says nothing (helper)"),
        ("solve/newton.py", "x = 1\n" * 351, "351 lines"),
        ("things/newton.py", "", "has no layer"),
    ],
)
def test_checker_finds_what_is_wrong(place: str, source: str, said: str) -> None:
    found = problems(place, source)
    assert len(found) == 1
    assert said in found[0]


@pytest.mark.parametrize(
    ("place", "source"),
    [
        ("load/force.py", "from lamella.body.marker import Marker\nfrom lamella.load.dead import DeadForces"),
        ("result.py", "def save():\n    from lamella.io.results import write"),
        ("dofs.py", "from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    from lamella.model import Model"),
        ("viz/plots.py", "def plot():\n    import matplotlib.pyplot"),
        ("_jit.py", "import numba"),
        ("verification/patch/case.py", "import lamella as lm"),
        ("solve/newton.py", "x = 1\n" * 350),
    ],
)
def test_checker_accepts_what_is_right(place: str, source: str) -> None:
    assert problems(place, source) == []

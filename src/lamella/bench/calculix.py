"""The static case P1 in CalculiX: the input deck, the run of ``ccx`` and what it wrote."""

from __future__ import annotations

import shutil
import tempfile
from dataclasses import dataclass
from pathlib import Path

from lamella.bench.clock import cpu_of_program
from lamella.errors import LamellaError
from lamella.verification.p1_static.case import LAMINATE, PLY

SIZE = (1.5, 2.0)
AROUND = ((0, 0), (2, 0), (2, 2), (0, 2), (1, 0), (2, 1), (1, 2), (0, 1))
"""Nodes of an element of eight nodes: corners, then midsides."""


class CalculixError(LamellaError):
    """``ccx`` gave no displacement; the message says what it wrote last."""


@dataclass(frozen=True)
class Solved:
    """CPU time [s], load increments done, Newton iterations (each with a factorisation), displacement of the loaded point [m]."""

    seconds: float
    increments: int
    iterations: int
    z: float


def deck(n: int, force: float) -> str:
    """Input of the cantilever: n x n shells S8R of three plies, clamped at x = 0, a force along z at the middle of x = 1.5 m.

    The plies have no Poisson's ratio across the thickness: a solid, of which CalculiX makes its shells, then has the plane stress
    of a thin laminate. With one, the thickness of a coarse mesh cannot follow the bending, which stiffens it by 2 %.
    """
    number: dict[tuple[int, int], int] = {}
    lines = ["*NODE"]
    for j in range(2 * n + 1):
        for i in range(2 * n + 1):
            if not (i % 2 and j % 2):
                number[i, j] = len(number) + 1
                lines.append(f"{number[i, j]}, {SIZE[0] * i / (2 * n):.12g}, {SIZE[1] * j / (2 * n):.12g}, 0")
    lines.append("*ELEMENT, TYPE=S8R, ELSET=PLATE")
    for element in range(n * n):
        j, i = divmod(element, n)
        lines.append(", ".join(map(str, (element + 1, *(number[2 * i + a, 2 * j + b] for a, b in AROUND)))))
    lines += ["*NSET, NSET=ROOT", *(str(number[0, j]) for j in range(2 * n + 1)), "*NSET, NSET=TIP", str(number[2 * n, n])]
    lines += ["*MATERIAL, NAME=PLY", "*ELASTIC, TYPE=ENGINEERING CONSTANTS"]
    lines += [f"{PLY.E1:g}, {PLY.E2:g}, {PLY.E2:g}, {PLY.nu12:g}, 0, 0, {PLY.G12:g}, {PLY.G12:g}", f"{PLY.G12:g}"]
    lines += ["*ORIENTATION, NAME=ALONG", "1, 0, 0, 0, 1, 0", "*ORIENTATION, NAME=ACROSS", "0, 1, 0, -1, 0, 0"]
    ply = LAMINATE.h / 3
    lines += ["*SHELL SECTION, ELSET=PLATE, COMPOSITE", *(f"{ply:.12g},, PLY, {way}" for way in ("ALONG", "ACROSS", "ALONG"))]
    lines += ["*BOUNDARY", "ROOT, 1, 6", "*STEP, NLGEOM, INC=1000", "*STATIC", "1., 1.", "*CLOAD", f"TIP, 3, {force:.12g}"]
    return "\n".join([*lines, "*NODE PRINT, NSET=TIP", "U", "*END STEP", ""])


def bend(n: int, force: float) -> Solved:
    """Run the deck with automatic increments in a temporary folder.

    Raises:
        CalculixError: it did not reach the full load.
    """
    program = shutil.which("ccx")
    assert program is not None, "asked for only where it is installed"
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "plate.inp").write_text(deck(n, force), encoding="ascii")
        seconds, done = cpu_of_program([program, "plate"], folder)
        increments, iterations = _counts(folder / "plate.sta")
        last = increments[-1] if increments else 0.0
        if last != 1.0:
            said = " ".join(done.stdout.split()[-20:])
            raise CalculixError(f"ccx stopped at {last:g} of the load: {said}")
        z = float((folder / "plate.dat").read_text(encoding="ascii").split()[-1])
    return Solved(seconds, len(increments), iterations, z)


def _counts(path: Path) -> tuple[list[float], int]:
    """Times of the increments that converged, and the iterations of all attempts, from the table of the status file."""
    times, iterations = [], 0
    if path.is_file():
        for line in path.read_text(encoding="ascii").splitlines():
            words = line.split()
            if words and words[0].isdigit():
                iterations += int(words[3])
                if words[2].isdigit():  # an attempt that did not converge is marked by a letter
                    times.append(float(words[4]))
    return times, iterations

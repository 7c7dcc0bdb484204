"""The cantilever P1 in Kratos: a process of its own runs :mod:`lamella.bench.kratos_plate` and tells what came out."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from lamella.bench.clock import ONE_THREAD
from lamella.errors import LamellaError
from lamella.roles import Floats
from lamella.verification.p1_static.case import LAMINATE, PLY

PROGRAM = Path(__file__).with_name("kratos_plate.py")
SIZE = (1.5, 2.0)
ELEMENTS = {"thin triangles": "ShellThinElementCorotational3D3N", "thin quadrilaterals": "ShellThinElementCorotational3D4N"}
"""Two triangles of discrete Kirchhoff theory in each cell of the mesh, or one quadrilateral. Thick triangles need ten load
steps and are 2.5 % off on 8 x 8 cells; thick quadrilaterals do not take a laminate (Kratos 10.4: its law lacks a function)."""

STATIC_STEPS = 3
"""Load steps: with 1, 2 or 5 Newton's method diverges on some meshes, with 4 and more it takes more iterations."""

SOLVERS = {"thin triangles": "LinearSolversApplication.sparse_lu", "thin quadrilaterals": "amgcl"}
"""The fastest of sparse_lu, sparse_qr, skyline and amgcl on the mesh that reaches the goal."""


class KratosError(LamellaError):
    """Kratos gave no displacement; the message is the last line that it wrote."""


@dataclass(frozen=True)
class Solved:
    """CPU time without imports [s], Newton iterations (each with a factorisation), displacements of the loaded point [m]."""

    seconds: float
    iterations: int
    z: Floats


def bend(kind: str, n: int, force: float) -> Solved:
    """Static equilibrium of n x n cells.

    Raises:
        KratosError: it did not reach the full load.
    """
    return _run(kind, n, force, {"steps": STATIC_STEPS})


def move(kind: str, n: int, force: float, steps: int, dt: float, rho_inf: float) -> Solved:
    """Motion by the method of Wood, Bossak and Zienkiewicz (1980), alpha_m = -(1 - rho)/(1 + rho).

    Raises:
        KratosError: a step did not converge.
    """
    return _run(kind, n, force, {"steps": steps, "dt": dt, "damping": -(1.0 - rho_inf) / (1.0 + rho_inf)})


def _run(kind: str, n: int, force: float, how: dict[str, float]) -> Solved:
    ply = [LAMINATE.h / 3, 0.0, PLY.rho, PLY.E1, PLY.E2, PLY.nu12, PLY.G12]
    plate = {
        "n": n,
        "size": SIZE,
        "plies": [[ply[0], angle, *ply[2:]] for angle in (0.0, 90.0, 0.0)],
        "element": ELEMENTS[kind],
        "solver": SOLVERS[kind],
        "force": force,
    }
    # -P: the modules beside the program have names of the standard library
    command = [sys.executable, "-P", str(PROGRAM), json.dumps(plate | how)]
    done = subprocess.run(command, env=os.environ | ONE_THREAD, capture_output=True, text=True, check=False)
    if done.returncode:
        said = [line for line in done.stderr.splitlines() if line.startswith(("RuntimeError", "Error", "ModuleNotFound"))]
        raise KratosError(said[-1] if said else f"it ended with {done.returncode}")
    found = json.loads(done.stdout.splitlines()[-1])
    return Solved(found["seconds"], found["iterations"], np.array(found["z"]))

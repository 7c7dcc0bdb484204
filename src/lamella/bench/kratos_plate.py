"""The composite plate in Kratos, of corotational shells: a program of its own, ``python kratos_plate.py '{...}'``.

It reads the plate as JSON from its argument and writes what came out as JSON in the last line; it imports nothing of lamella,
whose libraries and settings of threads would be in the same process.
"""

from __future__ import annotations

import json
import sys
import time
from importlib import import_module
from typing import Any

TOLERANCE = 1e-6
"""Of Newton's method, by the size of the last correction relative to the displacements."""
MOST = 100
"""Newton's iterations after which a step has failed."""


class KratosPlate:
    """An n x n mesh in the plane, clamped along x = 0, with a force along z at the middle of the edge opposite.

    Args:
        plate: ``n``, ``size`` [m], ``plies`` (rows of thickness, angle in degrees, density, E1, E2, nu12, G12), name of the
            ``element``, ``force`` [N].
    """

    def __init__(self, plate: dict[str, Any]) -> None:
        self.K: Any = import_module("KratosMultiphysics")  # untyped
        self.K.Logger.GetDefaultOutput().SetSeverity(self.K.Logger.Severity.WARNING)
        self.S: Any = import_module("KratosMultiphysics.StructuralMechanicsApplication")
        self.laws: Any = import_module("KratosMultiphysics.ConstitutiveLawsApplication")
        import_module("KratosMultiphysics.LinearSolversApplication")
        self.solvers: Any = import_module("KratosMultiphysics.python_linear_solver_factory")
        self.plate, self.force, self.iterations = plate, plate["force"], 0

    def build(self, moving: bool) -> None:
        """Nodes, elements, clamp and load."""
        K, S, n = self.K, self.S, self.plate["n"]
        self.model = K.Model()
        self.part = part = self.model.CreateModelPart("plate", 2)
        part.ProcessInfo[K.DOMAIN_SIZE] = 3
        pairs = [(K.DISPLACEMENT, K.REACTION), (K.ROTATION, K.REACTION_MOMENT)]
        rates = [K.VELOCITY, K.ACCELERATION, K.ANGULAR_VELOCITY, K.ANGULAR_ACCELERATION] if moving else []
        for variable in (*(v for pair in pairs for v in pair), K.VOLUME_ACCELERATION, S.POINT_LOAD, *rates):
            part.AddNodalSolutionStepVariable(variable)
        material = self.material()
        across, along = self.plate["size"]
        for j in range(n + 1):
            for i in range(n + 1):
                part.CreateNewNode(self.node(i, j), across * i / n, along * j / n, 0.0)
        count = 0
        for j in range(n):
            for i in range(n):
                around = [self.node(i, j), self.node(i + 1, j), self.node(i + 1, j + 1), self.node(i, j + 1)]
                triangles = [around[:3], [around[0], *around[2:]]]
                for corners in triangles if self.plate["element"].endswith("3N") else [around]:
                    count += 1
                    part.CreateNewElement(self.plate["element"], count, corners, material)
        variables = [(getattr(K, f"{a.Name()}_{x}"), getattr(K, f"{b.Name()}_{x}")) for a, b in pairs for x in "XYZ"]
        for variable, reaction in variables:
            K.VariableUtils().AddDof(variable, reaction, part)
            for j in range(n + 1):
                part.Nodes[self.node(0, j)].Fix(variable)
        self.tip = part.Nodes[self.node(n, n // 2)]
        part.CreateNewCondition("PointLoadCondition3D1N", 1, [self.tip.Id], material)

    def node(self, i: int, j: int) -> int:
        """Number of a node, from 1."""
        return j * (self.plate["n"] + 1) + i + 1

    def material(self) -> Any:
        """The laminate; shear across the thickness, which thin shells have not, and strengths are of no account."""
        plies = self.plate["plies"]
        rows = self.K.Matrix(len(plies), 16)
        for k, (*up_to_shear, shear) in enumerate(plies):
            for column, value in enumerate([*up_to_shear, shear, shear, shear, *[1e9] * 7]):
                rows[k, column] = value
        found = self.part.CreateNewProperties(1)
        found.SetValue(self.S.SHELL_ORTHOTROPIC_LAYERS, rows)
        found.SetValue(self.K.VOLUME_ACCELERATION, [0.0, 0.0, 0.0])
        found.SetValue(self.K.CONSTITUTIVE_LAW, self.laws.LinearElasticOrthotropic2DLaw())
        return found

    def march(self, scheme: Any, steps: int, dt: float, ramp: bool) -> list[float]:
        """Deflection of the tip [m] after each step, each by Newton's method with a factorisation in each iteration.

        Raises:
            RuntimeError: a step did not converge.
        """
        K = self.K
        solver = self.solvers.ConstructSolver(K.Parameters(json.dumps({"solver_type": self.plate["solver"]})))
        builder = K.ResidualBasedBlockBuilderAndSolver(solver)
        criterion = K.DisplacementCriteria(TOLERANCE, 1e-12)
        newton = K.ResidualBasedNewtonRaphsonStrategy(self.part, scheme, criterion, builder, MOST, False, False, True)
        newton.SetEchoLevel(0)
        newton.Initialize()
        found = []
        for step in range(1, steps + 1):
            self.part.ProcessInfo[K.STEP] += 1
            self.part.CloneTimeStep(step * dt)
            share = step / steps if ramp else 1.0
            self.tip.SetSolutionStepValue(self.S.POINT_LOAD, 0, [0.0, 0.0, share * self.force])
            newton.InitializeSolutionStep()
            newton.Predict()
            converged = newton.SolveSolutionStep()
            newton.FinalizeSolutionStep()
            self.iterations += self.part.ProcessInfo[K.NL_ITERATION_NUMBER]
            if not converged:
                raise RuntimeError(f"step {step} of {steps} did not converge")
            found.append(self.tip.GetSolutionStepValue(K.DISPLACEMENT_Z))
        return found

    def bend(self, steps: int) -> list[float]:
        """Static equilibrium in load steps."""
        self.build(moving=False)
        return self.march(self.K.ResidualBasedIncrementalUpdateStaticScheme(), steps, 1.0 / steps, ramp=True)

    def move(self, steps: int, dt: float, damping: float) -> list[float]:
        """Motion by Bossak's method, with its parameter alpha_m."""
        self.build(moving=True)
        settings = self.K.Parameters(
            json.dumps({"damp_factor_m": damping, "newmark_beta": 0.25, "projection_variables_list": []})
        )
        return self.march(self.S.StructuralMechanicsBossakScheme(settings), steps, dt, ramp=False)


def main() -> None:
    """Solve what the argument describes; the imports of Kratos are not in the time."""
    task = json.loads(sys.argv[1])
    plate = KratosPlate(task)
    start = time.process_time()
    z = plate.move(task["steps"], task["dt"], task["damping"]) if "dt" in task else plate.bend(task["steps"])
    print(json.dumps({"seconds": time.process_time() - start, "iterations": plate.iterations, "z": z}))


if __name__ == "__main__":
    main()

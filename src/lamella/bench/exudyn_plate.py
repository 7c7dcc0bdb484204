"""The composite plate of P1 and P2 in Exudyn, of ObjectANCFThinPlate with 36 coordinates."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from importlib import import_module
from typing import Any

import numpy as np

from lamella.verification.p1_static.case import LAMINATE, PLY

SIZE = (1.5, 2.0)
INTEGRATION = {"reduced integration": 1, "full integration": 0}
"""Values of ``useReducedOrderIntegration``: the fastest one, and as lamella integrates."""

STATIC_STEPS = 4
"""Load steps: from 4 x 4 to 12 x 12 elements fewer diverge first, and more take longer."""

TOLERANCE = 1e-6
"""Of Newton's method, relative and absolute; the defaults 1e-8 and 1e-10 are below round-off for a plate this thin."""


@dataclass(frozen=True)
class Solved:
    """Counts, and the displacement of the loaded point [m]: its values over time, or the one of statics."""

    iterations: int
    factorisations: int
    z: np.ndarray


def node(n: int, x: float, y: float) -> int:
    """Number of the node of an n x n mesh at (x, y), in shares of the plate's sides."""
    return round(y * n) * (n + 1) + round(x * n)


class ExudynPlate:
    """An assembled plate.

    Args:
        n: elements along each side.
        held: node to the number of its coordinates that are fixed, 3 for a pin and 9 for a clamp.
        loaded: node that carries the force.
        force: along z [N].
        reduced: value of ``useReducedOrderIntegration``.
    """

    def __init__(self, n: int, held: Mapping[int, int], loaded: int, force: float, reduced: int) -> None:
        exu: Any = import_module("exudyn")  # untyped: the types that it declares are not those that it takes
        item: Any = import_module("exudyn.itemInterface")
        self.exu, self.loaded = exu, loaded
        self.container = exu.SystemContainer()
        self.system = system = self.container.AddSystem()
        places = [[SIZE[0] * i / n, SIZE[1] * j / n, 0, 1, 0, 0, 0, 1, 0] for j in range(n + 1) for i in range(n + 1)]
        nodes = [system.AddNode(item.NodePointSlope12(referenceCoordinates=place)) for place in places]
        for first in (j * (n + 1) + i for j in range(n) for i in range(n)):
            system.AddObject(
                item.ObjectANCFThinPlate(
                    thickness=[LAMINATE.h],
                    density=PLY.rho,
                    strainCoefficients=exu.Matrix3DList([LAMINATE.A]),
                    curvatureCoefficients=exu.Matrix3DList([LAMINATE.D]),
                    nodeNumbers=[nodes[k] for k in (first, first + 1, first + n + 2, first + n + 1)],
                    useReducedOrderIntegration=reduced,
                )
            )
        ground = system.AddMarker(item.MarkerNodeCoordinate(nodeNumber=system.AddNode(item.NodePointGround()), coordinate=0))
        for k, count in held.items():
            for coordinate in range(count):
                marker = system.AddMarker(item.MarkerNodeCoordinate(nodeNumber=nodes[k], coordinate=coordinate))
                system.AddObject(item.ObjectConnectorCoordinate(markerNumbers=[ground, marker]))
        marker = system.AddMarker(item.MarkerNodePosition(nodeNumber=nodes[loaded]))
        system.AddLoad(item.LoadForceVector(markerNumber=marker, loadVector=[0, 0, force]))
        self.sensor = system.AddSensor(
            item.SensorNode(nodeNumber=nodes[loaded], storeInternal=True, outputVariableType=exu.OutputVariableType.Displacement)
        )
        system.Assemble()

    def move(self, steps: int, dt: float) -> Solved:
        """Motion in fixed steps, with the fastest settings for this plate: modified Newton, spectral radius 0.6."""
        settings = self._settings()
        integration = settings.timeIntegration
        integration.numberOfSteps, integration.endTime = steps, steps * dt
        integration.generalizedAlpha.spectralRadius = 0.6
        integration.newton.useModifiedNewton = True
        settings.solution.sensors.writePeriod = dt
        self._tolerances(integration)
        self.system.SolveDynamic(settings)
        return self._solved("dynamicSolver", np.asarray(self.system.GetSensorStoredData(self.sensor))[:, 3])

    def bend(self) -> Solved:
        """Static equilibrium, by full Newton: the modified one takes longer here."""
        settings = self._settings()
        static = settings.staticSolver
        static.numberOfLoadSteps = STATIC_STEPS
        self._tolerances(static)
        self.system.SolveStatic(settings)
        place = self.system.GetNodeOutput(self.loaded, self.exu.OutputVariableType.Displacement)
        return self._solved("staticSolver", np.asarray(place)[2:])

    def _settings(self) -> Any:
        settings = self.exu.SimulationSettings()
        settings.solution.file.write = False
        settings.linearSolver.solverType = self.exu.LinearSolverType.EigenSparse
        settings.parallel.numberOfThreads = 1
        return settings

    @staticmethod
    def _tolerances(solver: Any) -> None:
        solver.newton.relativeTolerance, solver.newton.absoluteTolerance = TOLERANCE, TOLERANCE
        solver.verboseMode = 0

    def _solved(self, solver: str, z: np.ndarray) -> Solved:
        counts = self.system.sys[solver].it
        return Solved(counts.newtonStepsCount, counts.newtonJacobiCount, z)

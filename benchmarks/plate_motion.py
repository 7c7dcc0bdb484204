"""A clamped composite plate in motion: lamella beside Exudyn's ObjectANCFThinPlate, in one run, as ratios.

    python benchmarks/plate_motion.py [--steps 500] [--mesh 6] [--force 10]

The case: 1.5 x 2.0 m, [0/90/0], clamped at x = 0, a dead force at the middle of the free edge from t = 0, steps of 1 ms.
Exudyn (an optional extra, ``pip install lamella[bench]``) runs with its fastest settings for this case, modified Newton and
reduced integration, and with full integration as lamella's own. Counts (iterations, factorisations) do not depend on the machine.
"""

from __future__ import annotations

import argparse
import time
from dataclasses import dataclass
from importlib.util import find_spec

import numpy as np

import lamella as lm

SIZE, H, RHO = (1.5, 2.0), 1.5e-3, 1560.0
LAYUP = lm.Laminate(lm.Lamina(E1=181e9, E2=103e9, G12=7.7e9, nu12=0.28, rho=RHO), angles=(0, 90, 0), thickness=H)


@dataclass(frozen=True)
class Run:
    """What one code did: CPU milliseconds and Newton iterations a step; the tip's mean deflection shows that the work is one."""

    name: str
    milliseconds: float
    iterations: float
    factorisations: float
    mean: float


def lamella_run(n: int, force: float, steps: int) -> Run:
    """Fixed steps of 1 ms; start-up and compilation fall out of the difference between a long and a short run."""
    system = lm.System()
    plate = system.add(lm.Plate("plate", size=SIZE, mesh=(n, n), laminate=LAYUP))
    tip = plate.marker("tip", 1.5, 1.0)
    system.add(lm.Clamp("root", plate.edge("x-")))
    system.add(lm.PointForce("load", tip, (0, 0, -force)))
    model, few = system.compile(), max(steps // 10, 1)
    integrator = lm.GeneralizedAlpha(dt=1e-3, rho_inf=0.9)
    lm.simulate(model, 2e-3, integrator)  # compiles what is not in the cache
    start = time.process_time()
    lm.simulate(model, few * 1e-3, integrator)
    short = time.process_time()
    result = lm.simulate(model, steps * 1e-3, integrator)
    seconds = (time.process_time() - short) - (short - start)
    counts = result.statistics
    return Run(
        "lamella",
        seconds / (steps - few) * 1e3,
        counts.newton_iterations / counts.steps,
        counts.factorisations / counts.steps,
        float(result["tip.position"][:, 2].mean()),
    )


def exudyn_run(n: int, force: float, steps: int, reduced: int) -> Run:
    """The same plate with 36-coordinate elements; coordinates of the clamped nodes held by constraints."""
    import exudyn as exu
    from exudyn import itemInterface as item

    container = exu.SystemContainer()
    system = container.AddSystem()
    nodes = [
        system.AddNode(item.NodePointSlope12(referenceCoordinates=[SIZE[0] * i / n, SIZE[1] * j / n, 0, 1, 0, 0, 0, 1, 0]))
        for j in range(n + 1)
        for i in range(n + 1)
    ]
    for j in range(n):
        for i in range(n):
            first = j * (n + 1) + i
            system.AddObject(
                item.ObjectANCFThinPlate(
                    thickness=[H],
                    density=RHO,
                    strainCoefficients=exu.Matrix3DList([LAYUP.A]),
                    curvatureCoefficients=exu.Matrix3DList([LAYUP.D]),
                    nodeNumbers=[nodes[k] for k in (first, first + 1, first + n + 2, first + n + 1)],
                    useReducedOrderIntegration=reduced,
                )
            )
    ground = system.AddMarker(item.MarkerNodeCoordinate(nodeNumber=system.AddNode(item.NodePointGround()), coordinate=0))
    for j in range(n + 1):
        for coordinate in range(9):
            held = system.AddMarker(item.MarkerNodeCoordinate(nodeNumber=nodes[j * (n + 1)], coordinate=coordinate))
            system.AddObject(item.ObjectConnectorCoordinate(markerNumbers=[ground, held]))
    tip = nodes[(n // 2) * (n + 1) + n]
    marker = system.AddMarker(item.MarkerNodePosition(nodeNumber=tip))
    system.AddLoad(item.LoadForceVector(markerNumber=marker, loadVector=[0, 0, -force]))
    sensor = system.AddSensor(
        item.SensorNode(nodeNumber=tip, storeInternal=True, outputVariableType=exu.OutputVariableType.Displacement)
    )
    system.Assemble()
    settings = exu.SimulationSettings()
    integration = settings.timeIntegration
    integration.numberOfSteps, integration.endTime = steps, steps * 1e-3
    integration.generalizedAlpha.spectralRadius = 0.6
    integration.newton.useModifiedNewton = True
    integration.newton.relativeTolerance, integration.newton.absoluteTolerance = 1e-6, 1e-6
    integration.verboseMode = 0
    settings.solution.file.write = False
    settings.solution.sensors.writePeriod = 1e-3
    settings.linearSolver.solverType = exu.LinearSolverType.EigenSparse
    settings.parallel.numberOfThreads = 1
    began = time.process_time()
    system.SolveDynamic(settings)
    seconds = time.process_time() - began
    counts = system.sys["dynamicSolver"].it
    deflection = np.asarray(system.GetSensorStoredData(sensor))[:, 3]
    iterations = counts.newtonStepsCount / steps
    return Run(
        f"Exudyn, {'reduced' if reduced else 'full'} integration", seconds / steps * 1e3, iterations, np.nan, deflection.mean()
    )


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--steps", type=int, default=500)
    parser.add_argument("--mesh", type=int, default=6)
    parser.add_argument("--force", type=float, default=10.0)
    chosen = parser.parse_args()
    arguments = (chosen.mesh, chosen.force, chosen.steps)
    runs = [lamella_run(*arguments)]
    if find_spec("exudyn"):
        runs += [exudyn_run(*arguments, reduced=reduced) for reduced in (1, 0)]
    else:
        print("Exudyn is not installed: pip install lamella[bench]")
    print(f"\n{chosen.mesh} x {chosen.mesh} elements, {chosen.force:g} N, {chosen.steps} steps of 1 ms")
    print(f"{'':32}{'CPU ms':>9}{'ratio':>8}{'Newton/step':>13}{'factor./step':>14}{'mean z [m]':>12}")
    for run in runs:
        ratio = run.milliseconds / runs[0].milliseconds
        print(f"{run.name:32}{run.milliseconds:9.2f}{ratio:8.2f}{run.iterations:13.2f}{run.factorisations:14.2f}{run.mean:12.4f}")


if __name__ == "__main__":
    main()

"""Gradients beside the solutions and runs that they are of: what a parameter costs."""

from __future__ import annotations

import inspect
import statistics
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import lamella as lm
from lamella.bench.clock import cpu
from lamella.bench.row import NAN, Row
from lamella.io.analysis import Analysis

CASE = "gradients"
AT = {"force": -10.0, "E1": 181e9, "nu12": 0.28, "density": 1560.0, "thickness": 4e-3, "length": 1.5}
HEAT = {"alpha1": -0.3e-6, "alpha2": 28e-6, "k1": 5.0, "k2": 0.7, "c": 900.0}
"""What the ply needs to be heated."""
DEFLECTION = lm.SignalOutput("C.position", component="z")
"""Of the loaded point, at the end."""


@dataclass(frozen=True)
class Work:
    """What is differentiated.

    Args:
        name: what it is.
        steps: of it, which times are divided by.
        mesh: elements in both directions.
        damping: retardation time [s].
        lit: whether the sun heats it.
        at: values of the parameters that differ from :data:`AT`.
        output: what is differentiated.
        symbol: of it.
        alone: parameters that are asked for one by one.
    """

    name: str
    steps: int
    mesh: tuple[int, int] = (6, 6)
    damping: float = 0.0
    lit: bool = False
    at: tuple[tuple[str, float], ...] = ()
    output: lm.SignalOutput = DEFLECTION
    symbol: str = "z_C"
    alone: tuple[str, ...] = ("force", "E1", "thickness", "length")

    @property
    def values(self) -> dict[str, float]:
        """Values of all parameters."""
        return {**AT, **dict(self.at)}

    @property
    def analysis(self) -> Analysis:
        """A motion in steps of 1 ms, or statics where there is one step."""
        if self.steps == 1:
            return lm.Statics("still")
        return lm.Motion("swing", self.steps * 1e-3, lm.GeneralizedAlpha(1e-3, rho_inf=0.9))

    def plate(self, **values: float) -> lm.System:
        """A cantilever of 2 m width under a force at the middle of its free edge."""
        at = {**self.values, **values}
        ply = lm.Lamina(E1=at["E1"], E2=10.3e9, G12=7.7e9, nu12=at["nu12"], rho=at["density"], **(HEAT if self.lit else {}))
        layup = lm.Laminate(ply, angles=(0.0, 90.0, 0.0), thickness=at["thickness"])
        system = lm.System()
        plate = system.add(lm.Plate("plate", (at["length"], 2.0), self.mesh, layup, damping=self.damping))
        tip = plate.marker("C", at["length"], 1.0)
        system.add(lm.Clamp("root", plate.edge("x-")))
        system.add(lm.PointForce("load", tip, (0.0, 0.0, at["force"])))
        if self.lit:
            system.add(lm.TemperatureField("heat", plate))
            system.add(lm.SolarFlux("sun", plate, direction=(0.5, 0.0, -0.9), absorptivity=0.8, constant=1361.0))
        return system

    def solve(self) -> object:
        """Compute it without derivatives."""
        analysis = self.analysis
        if isinstance(analysis, lm.Motion):
            return lm.simulate(self.plate(), analysis.t_end, analysis.integrator)
        return lm.equilibrium(self.plate())

    def gradient(self, names: Sequence[str]) -> lm.Gradient:
        """Compute it with derivatives of the output by some parameters."""
        outputs = {"output": self.output}
        return lm.gradient(self._of(names), {name: self.values[name] for name in names}, outputs, analyses=[self.analysis])

    def _of(self, names: Sequence[str]) -> Callable[..., lm.System]:
        """The plate as a function of some parameters alone."""

        def plate(**values: Any) -> lm.System:
            return self.plate(**values)

        keyword = inspect.Parameter.KEYWORD_ONLY
        plate.__signature__ = inspect.Signature([inspect.Parameter(name, keyword) for name in names])  # pyright: ignore[reportFunctionMemberAccess]
        return plate


OVER_TIME = (
    ("rms of a place", lm.SignalOutput("C.position", component="z", statistic="rms"), "rms z_C"),
    ("rms of a reaction", lm.SignalOutput("root.force", component="z", statistic="rms"), "rms F_z"),
    ("mean strain energy", lm.SignalOutput("energy.strain", statistic="mean"), "mean W"),
)
"""Outputs for which each step is evaluated."""
FEW = ("force", "length")
WORK = (
    Work("statics, 24 x 16 elements", 1, (24, 16)),
    Work("motion", 1000),
    Work("motion, 1.5 mm", 1000, at=(("thickness", 1.5e-3),)),
    Work("motion, damping 0.1 ms", 1000, damping=1e-4),
    Work("motion, damping 1 ms", 1000, damping=1e-3),
    Work("motion in the sun, damping 1 ms", 1000, damping=1e-3, lit=True),
    Work("motion, 24 x 16 elements", 300, (24, 16)),
    Work("motion, 24 x 16 elements, damping 1 ms", 300, (24, 16), 1e-3),
    *(
        Work(
            f"motion, {mesh[0]} x {mesh[1]} elements, {what}",
            steps,
            mesh,
            output=output,
            symbol=symbol,
            alone=("force", "length"),
        )
        for mesh, steps in (((6, 6), 1000), ((24, 16), 300))
        for what, output, symbol in OVER_TIME
    ),
)


def run(runs: int) -> Iterator[Row]:
    """CPU time of each piece of work, and what derivatives take beyond it for each parameter, with their models."""
    for work in WORK:
        asked = [(name,) for name in work.alone] + [tuple(AT)]
        for names in ((), *asked):
            work.gradient(names) if names else work.solve()  # loads or compiles kernels
        alone: list[float] = []
        shares: list[list[float]] = [[] for _ in asked]
        found: list[float] = []
        for _ in range(runs):
            found.clear()
            for names, own_shares in zip(asked, shares, strict=True):
                alone.append(cpu(work.solve)[0])  # each time anew, as the speed of machines changes within minutes
                seconds, gradient = cpu(partial(work.gradient, names))
                own_shares.append((seconds / alone[-1] - 1.0) / len(names))
                found.append(float(gradient["output", names[0]]))
        unit, per = ("ms a step", 1e3 / work.steps) if work.steps > 1 else ("ms", 1e3)
        own = Row(case=CASE, code="lamella", what=work.name, time=per * statistics.median(alone), unit=unit)
        yield own.beside(own)
        for names, own_shares, value in zip(asked, shares, found, strict=True):
            one = len(names) == 1
            yield Row(
                case=CASE,
                code="beyond it, a parameter",
                what=names[0] if one else f"each of {len(names)}",
                time=own.time * statistics.median(own_shares),
                unit=unit,
                value=value if one else NAN,
                quantity=f"d {work.symbol} / d {names[0]}" if one else "",
            ).beside(own)

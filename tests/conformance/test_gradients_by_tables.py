"""Derivatives of reactions and energies by the tables of elements of two models, against those of four and whole solutions."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from itertools import product

import numpy as np
import pytest

import lamella as lm
from lamella import dofs
from lamella.roles import Floats

TIGHT = lm.Newton(tolerance=1e-12, keep=0.0, line_search=True)
ALPHA = lm.GeneralizedAlpha(dt=1e-3, rho_inf=0.8, newton=lm.Newton(tolerance=1e-12, keep=0.0, max_iterations=50))
T_END = 0.02
ANALYSES = {"still": (lm.Statics("still", newton=TIGHT),), "swing": (lm.Motion("swing", t_end=T_END, integrator=ALPHA),)}
SPAN = 2e-3
"""Of differences of sixth order of whole solutions, as a share of the parameter."""
CLOSE = {
    "still": {"force": 5e-7, "torque": 1e-7, "strain": 2e-8},
    "swing": {"force": 1e-5, "torque": 2e-6, "strain": 2e-5, "kinetic": 1e-5},
}
"""Shares of an output over the parameter. Tables are differenced to 1e-11, and membranes are stiffer than the bending by 1e5."""


def sheet(thickness: float, **heat: float) -> lm.Laminate:
    return lm.Laminate(lm.Isotropic(E=7e10, nu=0.3, rho=2700.0, **heat), thickness=thickness)


def cantilever(length: float = 0.5, width: float = 0.2, thickness: float = 4e-3, damping: float = 0.0) -> lm.System:
    """A plate fixed to the ground, whose joint tells force and torque in its frame as well, pushed from three sides."""
    system = lm.System()
    ground = system.add(lm.Ground())
    how = {"damping": damping} if damping else {}
    plate = system.add(lm.Plate("plate", (length, width), (3, 2), sheet(thickness), rotation=(0.0, 0.2, 0.3), **how))
    tip = plate.marker("tip", 0.9 * length, 0.3 * width)
    system.add(lm.FixedJoint("root", ground.origin, plate.edge("x-")))
    system.add(lm.PointForce("load", tip, (5.0, 3.0, -20.0)))
    return system


def span(length: float = 0.5, width: float = 0.2, damping: float = 0.0) -> lm.System:
    """A plate between two clamps, which a load stretches."""
    system = lm.System()
    how = {"damping": damping} if damping else {}
    plate = system.add(lm.Plate("plate", (length, width), (4, 2), sheet(4e-3), **how))
    tip = plate.marker("tip", 0.4 * length, 0.3 * width)
    system.add(lm.Clamp("root", plate.edge("x-")))
    system.add(lm.Clamp("end", plate.edge("x+")))
    system.add(lm.PointForce("load", tip, (50.0, 30.0, -200.0)))
    return system


def roof(radius: float = 0.4, length: float = 0.3, damping: float = 0.0) -> lm.System:
    """A cylindrical roof between two clamps, which stand where the radius says."""
    system = lm.System()
    how = {"damping": damping} if damping else {}
    surface = lm.CylinderSurface(radius=radius, length=length, angle=(0.5, 1.7))
    shell = system.add(lm.Shell("roof", surface, (4, 2), sheet(4e-3), **how))
    tip = shell.marker("tip", 0.5 * radius, 0.3 * length)
    system.add(lm.Clamp("root", shell.edge("x-")))
    system.add(lm.Clamp("end", shell.edge("x+")))
    system.add(lm.PointForce("load", tip, (-30.0, 10.0, -100.0)))
    return system


def heated(length: float = 0.5, width: float = 0.2, thickness: float = 2e-3) -> lm.System:
    """A panel that the sun bends; temperatures do not follow in the force of its elements."""
    system = lm.System()
    layup = sheet(thickness, alpha=2.3e-5, k=5.0, c=900.0)
    plate = system.add(lm.Plate("plate", (length, width), (2, 1), layup, damping=2e-3))
    system.add(lm.Clamp("root", plate.edge("x-"), kind="restrained"))
    system.add(lm.PointForce("load", plate.marker("tip", 0.9 * length, 0.3 * width), (0.0, 0.0, -1.0)))
    system.add(lm.TemperatureField("heat", plate))
    system.add(lm.SolarFlux("sun", plate, direction=(0.6, 0.0, -0.8), absorptivity=0.8, constant=1361.0))
    return system


def outputs(moving: bool, local: bool) -> dict[str, lm.SignalOutput]:
    """Components of reactions, and energies, by ``what.component``: single values of statics, means over time of motion."""
    reactions = ("force", "torque", *(("force_local", "torque_local") if local else ()))
    of_vector, of_number = ("rms", "mean") if moving else ("last", "last")
    found = {
        f"{what}.{axis}": lm.SignalOutput(f"root.{what}", component=axis, statistic=of_vector)
        for what, axis in product(reactions, "xyz")
    }
    energies = ("strain", "kinetic") if moving else ("strain",)
    return found | {f"{what}.": lm.SignalOutput(f"energy.{what}", statistic=of_number) for what in energies}


def shares(asked: Mapping[str, lm.SignalOutput], values: Floats, changes: Floats) -> Floats:
    """Changes of outputs, as shares of the vectors that they belong to."""
    whole = [name.split(".")[0] for name in asked]
    size = [np.linalg.norm([value for value, other in zip(values, whole, strict=True) if other == one]) for one in whole]
    return np.abs(changes) / size


def assert_close(analysis: str, asked: Mapping[str, lm.SignalOutput], values: Floats, found: Floats, expected: Floats) -> None:
    """Derivatives times the parameter are the same, as shares of the outputs."""
    close = [CLOSE[analysis][name.split(".")[0].removesuffix("_local")] for name in asked]
    np.testing.assert_array_less(shares(asked, values, found - expected) / close, 1.0, err_msg=" ".join(asked))


def by_whole_solutions(
    model: Callable[[float], lm.System], value: float, analysis: lm.Statics | lm.Motion, asked: Mapping[str, lm.SignalOutput]
) -> tuple[Floats, Floats]:
    """Outputs, and their derivatives times the parameter."""

    def values(share: float) -> Floats:
        system = model(value * (1.0 + share * SPAN))
        moves = isinstance(analysis, lm.Motion)
        run = lm.simulate(system, analysis.t_end, analysis.integrator) if moves else lm.equilibrium(system, newton=TIGHT)
        return np.array([output.value(run) for output in asked.values()])

    sixth = {1: 3 / 4, 2: -3 / 20, 3: 1 / 60}
    return values(0.0), sum(weight / SPAN * (values(k) - values(-k)) for k, weight in sixth.items())


CASES = {
    "cantilever by length": (cantilever, "length", 0.5),
    "cantilever by width": (cantilever, "width", 0.2),
    "cantilever by thickness": (cantilever, "thickness", 4e-3),
    "span by length": (span, "length", 0.5),
    "span by width": (span, "width", 0.2),
    "roof by radius": (roof, "radius", 0.4),
    "roof by length": (roof, "length", 0.3),
}
HOW = {"still": ("still", 0.0), "undamped": ("swing", 0.0), "damped": ("swing", 1e-3)}


@pytest.mark.parametrize(("case", "how"), [*product(CASES, HOW)])
def test_two_models_tell_of_reactions_and_energies_what_four_and_whole_solutions_do(
    case: str, how: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    (made, name, value), (analysis, damping) = CASES[case], HOW[how]
    asked, places, found = outputs(analysis == "swing", made is cantilever), list[float](), list[Floats]()

    def model(**given: float) -> lm.System:
        places.append(given[name])
        return made(**given, damping=damping)

    for count in (2, 2 if name == "thickness" else 4):
        places.clear()
        found.append(value * lm.gradient(model, {name: value}, asked, analyses=ANALYSES[analysis]).matrix[:, 0])
        assert len(places) == 1 + count
        monkeypatch.setattr(dofs.Signal, "by_tables", False)
    values, expected = by_whole_solutions(lambda x: model(**{name: x}), value, ANALYSES[analysis][0], asked)
    for one in (found[1], expected):
        assert_close(analysis, asked, values, found[0], one)
    assert shares(asked, values, expected).max() > 0.5


@pytest.mark.parametrize(("name", "value", "beside"), [("thickness", 2e-3, 2), ("length", 0.5, 4), ("width", 0.2, 4)])
def test_heated_plates_have_reactions_and_energies_by_differences(name: str, value: float, beside: int) -> None:
    method = lm.GeneralizedAlpha(dt=1e-2, rho_inf=0.8, newton=ALPHA.newton)
    analysis, asked, places = lm.Motion("swing", t_end=0.1, integrator=method), outputs(True, False), list[float]()

    def model(**given: float) -> lm.System:
        places.append(given[name])
        return heated(**given)

    found = value * lm.gradient(model, {name: value}, asked, analyses=(analysis,)).matrix[:, 0]
    assert len(places) == 1 + beside
    values, expected = by_whole_solutions(lambda x: model(**{name: x}), value, analysis, asked)
    assert_close("swing", asked, values, found, expected)


def test_signals_that_are_not_of_tables_take_four_models_beside_a_length() -> None:
    """The damping power is quadratic in rates of strains, which a length stretches."""
    places = list[float]()

    def model(length: float) -> lm.System:
        places.append(length)
        return cantilever(length, damping=1e-3)

    asked = outputs(True, False) | {"power": lm.SignalOutput("power.dissipated", statistic="mean")}
    lm.gradient(model, {"length": 0.5}, asked, analyses=ANALYSES["swing"])
    assert len(places) == 5

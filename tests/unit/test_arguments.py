"""Arguments of the public functions: wrong kinds and values are refused with the function, the argument and what is accepted."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

import lamella as lm
from lamella.errors import LamellaError
from lamella.io.modes import read_modes, write_modes
from lamella.io.vtk import write_vtkhdf
from lamella.viz.path import plot_path
from lamella.viz.plots import plot_comparison, plot_convergence, plot_energy
from lamella.viz.scene import picture
from lamella.viz.style import save_figure

STEPS: Any = lm.GeneralizedAlpha(dt=1e-3, rho_inf=0.9)
STATICS = (lm.Statics("still"),)
STUDY = lm.ParameterStudy("m", {"h": lm.Parameter("a", values=(1,))}, lm.GridDesign(), {"y": lm.MassOutput()})
LAYUP = lm.Laminate(lm.Isotropic(E=70e9, nu=0.3, rho=2700), thickness=2e-3)


def strip(elements: int = 1) -> Any:
    system = lm.System()
    plate = system.add(lm.Plate("strip", (0.5, 0.1), (elements, 1), LAYUP))
    system.add(lm.Clamp("root", plate.edge("x-")))
    system.add(lm.PointForce("load", plate.marker("tip", 0.5, 0.05), (0, 0, -1.0)))
    return system


def far(at: float) -> Any:
    system = lm.System()
    system.add(lm.Plate("far", (1.0, 0.1), (1, 1), LAYUP, position=(at, 0, 0)))
    return system


def still(elements: int = 1) -> Any:
    return lm.equilibrium(strip(elements))


def still_by(analyses: Any = STATICS, output: Any = None, sizes: Any = None) -> Any:
    """A gradient by the force of a strip."""

    def loaded(force: float) -> lm.System:
        system = strip()
        system.add(lm.PointForce("more", system.declarations[0].marker("A", 0.5, 0.0), (0, 0, force)))
        return system

    return lm.gradient(loaded, {"force": 1.0}, {"mass": output or lm.MassOutput()}, analyses=analyses, sizes=sizes)


def other(value: Any) -> Any:
    """Any value, for arguments whose type it is not."""
    return value


REFUSED: list[tuple[Callable[[], object], str]] = [
    (lambda: lm.simulate(other(None), 0.01, STEPS), "simulate: system = None; accepted is a System"),
    (lambda: lm.simulate(strip(), other("1 s"), STEPS), "t_end = '1 s'; accepted is a number"),
    (lambda: lm.simulate(strip(), float("nan"), STEPS), "t_end = nan"),
    (lambda: lm.simulate(strip(), float("inf"), STEPS), "t_end = inf; accepted is a finite time later than t_start = 0 s"),
    (lambda: lm.simulate(strip(), 1.0, STEPS, t_start=float("-inf")), "t_start = -inf; accepted is a finite time"),
    (lambda: lm.simulate(strip(), True, STEPS), "t_end = True; accepted is a number"),
    (lambda: lm.simulate(strip(), 0.01, other(lm.GeneralizedAlpha)), "integrator = .*; accepted is an integrator such as"),
    (lambda: lm.simulate(strip(), 0.01, STEPS, frames=other(2.5)), "frames = 2.5; accepted is a whole number"),
    (lambda: lm.simulate(strip(), 0.01, STEPS, frames=-1), "frames = -1; accepted is a number of configurations, 0 or more"),
    (lambda: lm.simulate(strip(), 0.01, STEPS, every=other("1 ms")), "every = '1 ms'; accepted is a number, or None"),
    (lambda: lm.simulate(strip(), 0.01, STEPS, solver=other("best")), "solver = 'best'; accepted is one of auto"),
    (lambda: lm.simulate(strip(), 0.01, STEPS, on_failure="ignore"), "on_failure = 'ignore'; accepted is one of raise, return"),
    (lambda: lm.simulate(strip(), 0.01, STEPS, initial=other("rest")), "initial = 'rest'; accepted is a state"),
    (lambda: lm.simulate(strip(), 0.01, STEPS, initial=still(2).final), "state of 72 coordinates .* one of this system, .48, 0"),
    (lambda: lm.equilibrium(strip(), steps=other("x")), "steps = 'x'; accepted is a whole number or ascending numbers"),
    (lambda: lm.equilibrium(strip(), steps=-1), "steps = -1"),
    (lambda: lm.equilibrium(strip(), times=other([0.0, "x"])), "times = .*accepted is ascending numbers, or None"),
    (lambda: lm.equilibrium_path(strip(), arc=other(0.1)), r"arc = 0.1; accepted is ArcLength\(...\), or None"),
    (lambda: lm.modes(strip(), other("x")), "modes: n = 'x'; accepted is a whole number"),
    (lambda: lm.buckling(strip(), state=other(1)), "buckling: state = 1; accepted is a state"),
    (lambda: lm.run_parameter_study(other({}), "out"), "study = {}; accepted is a ParameterStudy"),
    (lambda: lm.run_optimisation(other(None), "out"), "problem = None; accepted is an Optimisation"),
    (lambda: lm.run_parameter_study(STUDY, other(3)), "run_parameter_study: folder = 3; accepted is a path"),
    (lambda: lm.simulate(strip(), 10**400, STEPS), "simulate: t_end = 1000.*; accepted is a number"),
    (lambda: lm.simulate(strip(), 0.01, STEPS, frames=10**400), "simulate: frames = 1000.*; accepted is a whole number"),
    (lambda: lm.simulate(strip(), 0.01, STEPS, sinks=other(None)), "simulate: sinks = None; accepted is a list of sinks"),
    (lambda: lm.equilibrium(strip(), sinks=other("x")), "equilibrium: sinks = 'x'; accepted is a list of sinks"),
    (lambda: lm.Stepping(strip(), STEPS).get(other(None)), "get: name = None; accepted is a text"),
    (lambda: lm.Stepping(strip(), STEPS).set(other([]), 1.0), r"set: name = \[\]; accepted is a text"),
    (lambda: lm.System(other([1.0, 2.0])), r"System: redundant = \[1.0, 2.0\]; accepted is 'raise' or 'drop'"),
    (lambda: lm.read_result(other(None)), "read_result: path = None; accepted is a path"),
    (lambda: lm.read_result(5000 * "x"), "result file 'x*' does not exist"),
    (lambda: lm.Table.from_csv(other(None)), "from_csv: path = None; accepted is a path"),
    (lambda: lm.Table.from_csv("a\0b"), "the file cannot be read: it is not text"),
    (lambda: still()[other([])], r"result: no signal '\[\]'; recorded are"),
    (lambda: still().history(other({})), "result: no signal '{}'; recorded are"),
    (lambda: still().save(other(None)), "write_result: path = None; accepted is a path"),
    (lambda: still().save(5000 * "x"), "cannot be written: File name too long; accepted is another name"),
    (lambda: still().save("a\0b"), "cannot be written: .*null.*; accepted is another name"),
    (lambda: write_vtkhdf(other(None), "x.vtkhdf"), "write_vtkhdf: result = None; accepted is a result"),
    (lambda: write_modes(other(None), "x.h5"), "write_modes: modes = None; accepted is natural modes or buckling shapes"),
    (lambda: read_modes(5000 * "x"), "'x*' is not a file of modes"),
    (lambda: plot_energy(other(None)), "plot_energy: result = None; accepted is a result"),
    (lambda: plot_path(other(None)), "plot_path: result = None; accepted is a result"),
    (lambda: plot_comparison({"a": still()}, other(None)), "plot_comparison: name = None; accepted is a text"),
    (lambda: plot_convergence(other({"a": 1}), "h"), "series = {'a': 1}; accepted is a mapping of names to two lists of numbers"),
    (lambda: save_figure(other(None), other(None)), "save_figure: path = None; accepted is a path"),
    (lambda: picture(still(), other(None)), "picture: path = None; accepted is a path"),
    (lambda: picture(still(), "x.png", field=other(None)), "picture: field = None; accepted is a text"),
    (lambda: still().plate("strip", frame=other("x")), "plate: frame = 'x'; accepted is a whole number, or None"),
    (lambda: still().plate("strip", frame=9), "frame = 9; accepted is 0 to 1, or None"),
    (lambda: still().plate("strip", per_element=0), "per_element = 0; accepted is a number of intervals, 1 or more"),
    (lambda: still().save("/no/such/folder/x.h5"), "result file '/no/such/folder/x.h5': folder '/no/such/folder' does not exist"),
    (lambda: lm.Plate("p", (1, 1), (1, 1), LAYUP).marker("m", other("left"), 0), "marker: x = 'left'; accepted is a number"),
    (lambda: lm.Ground().marker("m", 0, 0, other(None)), "marker: z = None; accepted is a number"),
    (lambda: lm.gradient("swing", at=other(None), outputs={}), "gradient: at = None; accepted is a mapping of names to a number"),
    (
        lambda: lm.gradient("swing", at={}, outputs=other({"f": "shape"})),
        "outputs = {'f': 'shape'}; accepted is a mapping of",
    ),
    (lambda: lm.gradient("swing", at=other({3: 1.0}), outputs={}), "at = {3: 1.0}; accepted is a mapping of names to a number"),
    (lambda: lm.gradient("swing", {"f": 10**400}, {}), "gradient: f = 10.*; accepted is a number with a unit"),
    (lambda: lm.gradient("swing", {"f": 1.0}, {}, settings="x=1"), "settings = 'x=1'; accepted is a list of key=value texts"),
    (
        lambda: lm.gradient("swing", {"f": 1.0}, {}, sizes={"f": 0.0}),
        "sizes = {'f': 0.0}; accepted is a mapping of names to",
    ),
    (lambda: lm.gradient("swing", {"f": 1.0}, {}, sizes={"g": 1.0}), "gradient: sizes: there is no parameter 'g'. There are: f"),
    (
        lambda: lm.gradient("swing", {"f": 1.0, "g": 1.0}, {}, parameters={"f": lm.Parameter("a"), "g": lm.Parameter("a")}),
        "gradient: g: the path a is that of the parameter 'f' already",
    ),
    (lambda: still_by(sizes={"force": 1e-30}), "force = 1.0 is not changed by a share of its size 1e-30; accepted is a larger"),
    (
        lambda: still_by(analyses=(lm.NaturalModes("free", about="still"), *STATICS)),
        "analysis 'free': about: 'still' is no analysis before it with a state; accepted are none",
    ),
    (
        lambda: still_by(analyses=(*STATICS, lm.NaturalModes("free"), lm.Motion("swing", 0.1, start="free"))),
        "analysis 'swing': start: 'free' is no analysis before it with a state; accepted are still",
    ),
    (lambda: still_by(analyses=(*STATICS, lm.Statics("still", time=1.0))), "analysis 'still': two have this name"),
    (lambda: still_by()[other(("mass", "force", "more"))], r"found\[\('mass', .*; accepted is an output, or an output and a pa"),
    (lambda: still_by(analyses=other(5)), "gradient: analyses = 5; accepted is a list of analyses such as Motion"),
    (lambda: still_by(analyses=other(lm.Statics("still"))), "analyses = .*; accepted is a list of analyses"),
    (lambda: still_by(analyses=other([5])), "analyses = .5.; accepted is a list of analyses"),
    (lambda: still_by(output=lm.MassOutput(body="plate")), "output 'mass': body: there is no body 'plate' with mass"),
    (
        lambda: lm.linearise(strip(), other("load"), ["tip.position"]),
        "linearise: inputs = 'load'; accepted is a list of names",
    ),
    (lambda: lm.linearise(strip(), other(5), ["tip.position"]), "inputs = 5; accepted is a list of names, or a mapping of names"),
    (lambda: lm.linearise(strip(), other({"u": 5}), ["tip.position"]), "inputs = {'u': 5}; accepted is a list of names, or"),
    (lambda: lm.linearise(strip(), ["load"], other("tip.position")), "outputs = 'tip.position'; accepted is a list of names"),
    (lambda: lm.linearise(strip(), ["load"], other([5])), r"outputs = \[5\]; accepted is a list of names"),
    (lambda: lm.Stepping(strip(), STEPS, inputs=other(5)), "Stepping: inputs = 5; accepted is a list of names, or a mapping"),
    (lambda: lm.Stepping(strip(), STEPS, outputs="tip.position.z"), "outputs = 'tip.position.z'; accepted is a list of names"),
    (lambda: lm.Stepping(other(None), STEPS), "Stepping: system = None; accepted is a System or its compiled model"),
    (lambda: far(1e10).compile(), r"'far' lies 1e\+10 m from the origin, 1e\+10 times its size"),
]


@pytest.mark.parametrize(("call", "said"), REFUSED)
def test_what_cannot_be_is_refused_with_words(call: Callable[[], object], said: str) -> None:
    with pytest.raises(LamellaError, match=said):
        call()

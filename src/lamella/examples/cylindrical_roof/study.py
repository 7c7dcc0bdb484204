"""The thin roof with three sections: limit points, snap-back, the way to a side, and imperfections."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.optimize import brentq

from lamella.critical import CriticalPoint
from lamella.examples.cylindrical_roof import drawing
from lamella.examples.swing import Numbers, excess, rounded
from lamella.result import Result
from lamella.roles import Floats
from lamella.stability import Buckling
from lamella.study.findings import Finding
from lamella.study.measures import component

if TYPE_CHECKING:
    from lamella.study.study import Study

LAMINATES = {"isotropic": "isotropic", "0-90-0": "outer-axial", "90-0-90": "outer-around"}
"""Variants and their laminates in the model file."""
FORCE = 1000.0
"""Force at the load factor 1 [N]."""
PUBLISHED = {"isotropic": (12.892, 586.0), "0-90-0": (12.280, 235.0), "90-0-90": (15.905, 476.0)}
"""Sze, Liu and Lo (2004): the largest of the tabulated points (w [mm], P [N]) before the load falls."""
BEHIND = "0-90-0"
"""Its published point lies behind the limit point."""


@dataclass(frozen=True)
class Roof:
    """What a variant has computed.

    Args:
        name: of the variant.
        path: of the perfect roof.
        imperfect: path with an imperfection.
        buckling: lowest load of linear buckling [N].
    """

    name: str
    path: Result
    imperfect: Result
    buckling: float

    def first(self, kind: str) -> CriticalPoint:
        """The first critical point of a kind on the path of the perfect roof."""
        return next(point for point in self.path.critical_points if point.kind == kind)

    @property
    def limit(self) -> float:
        """First limit load of the perfect roof [N]."""
        return FORCE * self.first("limit point").factor

    @property
    def bifurcation(self) -> float:
        """First load at which the perfect roof may leave to a side [N]."""
        return FORCE * self.first("bifurcation").factor

    @property
    def imperfect_limit(self) -> float:
        """Limit load with the imperfection [N]."""
        return FORCE * next(point.factor for point in self.imperfect.critical_points if point.kind == "limit point")


def study(study: Study) -> Iterator[Finding]:
    """Run the three sections, draw their paths, and yield the findings."""
    roofs = [computed(study, name) for name in LAMINATES]
    as_given = not study.overrides  # the published roofs are those of the file
    if study.draw:
        drawing.show_all(study, roofs, PUBLISHED if as_given else {})
    if as_given:
        yield published(roofs)
    yield snap_back(roofs)
    yield sideways(roofs)
    yield imperfection(roofs)
    yield energy(roofs)


def computed(study: Study, name: str) -> Roof:
    """Run a variant."""
    results = study.run(name, [f"system.roof.laminate={LAMINATES[name]}"], pictures=name == "isotropic")
    shapes, path, imperfect = results["shapes"], results["path"], results["imperfect"]
    assert isinstance(shapes, Buckling)
    assert isinstance(path, Result)
    assert isinstance(imperfect, Result)
    return Roof(name, path, imperfect, FORCE * float(shapes.factors[0]))


def curve(result: Result) -> tuple[Floats, Floats]:
    """Downward displacement of C [mm] and load [N] along a path."""
    z = component(result, "C.position", "z")[1]
    return 1e3 * (z[0] - z), FORCE * result["load_factor"].values


def length(w: Floats, load: Floats) -> Floats:
    """Length along a path in the diagram, each axis over its range."""
    steps = np.hypot(np.diff(w) / np.ptp(w), np.diff(load) / np.ptp(load))
    return np.concatenate([[0.0], np.cumsum(steps)])


def load_at(roof: Roof, displacement: float) -> float:
    """Load [N] of the perfect roof where C first reaches a displacement [mm]."""
    w, load = curve(roof.path)
    s = length(w, load)
    along = CubicSpline(s, w)
    k = int(np.argmax(w > displacement))
    return float(CubicSpline(s, load)(brentq(lambda at: float(along(at)) - displacement, s[k - 1], s[k])))


def published(roofs: Sequence[Roof]) -> Finding:
    """Published points lie on the paths."""
    numbers: Numbers = {}
    agrees = True
    for roof in roofs:
        w, load = PUBLISHED[roof.name]
        there = load_at(roof, w)
        agrees &= abs(excess(there, load)) < (2.0 if roof.name == BEHIND else 1.0)
        agrees &= roof.name == BEHIND or abs(excess(roof.limit, load)) < 1.0
        numbers |= {
            f"limit load, {roof.name} [N]": roof.limit,
            f"published largest tabulated load, {roof.name} [N]": load,
            f"load at its displacement, {roof.name} [N]": there,
            f"load at its displacement over the published, {roof.name} [%]": excess(there, load),
        }
    return Finding(
        "The first limit loads are those of Sze, Liu and Lo (2004).",
        agrees,
        rounded(numbers),
        "Published are points of steps along the path, of which the largest is named. That of [0/90/0] lies behind the limit "
        "point, where 1 % of displacement is 0.9 % of load.",
    )


def snap_back(roofs: Sequence[Roof]) -> Finding:
    """C turns back while the load falls."""
    numbers: Numbers = {}
    for roof in roofs:
        w, _ = curve(roof.path)
        numbers[f"way by which C turns back, {roof.name} [mm]"] = float(np.max(np.maximum.accumulate(w) - w))
        points = [FORCE * point.factor for point in roof.path.critical_points if point.kind == "limit point"]
        numbers[f"limit points, {roof.name} [N]"] = ", ".join(f"{load:.1f}" for load in points)
    ways = [value for value in numbers.values() if isinstance(value, float)]
    return Finding(
        "The thin roofs snap back: neither a rising load nor a rising displacement of C can follow their paths.",
        min(ways) > 0.5,
        rounded(numbers),
        "The arc length can.",
    )


def sideways(roofs: Sequence[Roof]) -> Finding:
    """The whole roof may leave to a side before the limit point of its symmetric path."""
    numbers: Numbers = {}
    for roof in roofs:
        numbers |= {
            f"bifurcation, {roof.name} [N]": roof.bifurcation,
            f"of the limit load, {roof.name} [%]": 100 * roof.bifurcation / roof.limit,
            f"linear buckling, {roof.name} [N]": roof.buckling,
        }
    return Finding(
        "Check of our own: a whole roof may leave to a side before the limit point that a quarter has.",
        all(roof.bifurcation < roof.limit for roof in roofs),
        rounded(numbers),
        "The null vector at the bifurcation is antisymmetric. Linear buckling, which knows nothing of the way the roof flattens "
        "before, is not near either of the two.",
    )


def imperfection(roofs: Sequence[Roof]) -> Finding:
    """An imperfection lowers the limit load."""
    numbers: Numbers = {}
    for roof in roofs:
        numbers |= {
            f"limit load, perfect and symmetric, {roof.name} [N]": roof.limit,
            f"limit load with the imperfection, {roof.name} [N]": roof.imperfect_limit,
            f"change, {roof.name} [%]": excess(roof.imperfect_limit, roof.limit),
        }
    return Finding(
        "Check of our own: a tenth of the thickness out of shape takes a part of the limit load.",
        all(roof.imperfect_limit < roof.limit for roof in roofs),
        rounded(numbers),
        "The imperfection has the shape in which the perfect roof leaves its path.",
    )


def energy(roofs: Sequence[Roof]) -> Finding:
    """The work of the load is the strain energy."""
    numbers: Numbers = {}
    for roof in roofs:
        w, load = curve(roof.path)
        s = length(w, load)
        fine = np.linspace(0.0, s[-1], 50 * len(s))
        work = 1e-3 * float(np.trapezoid(CubicSpline(s, load)(fine) * CubicSpline(s, w)(fine, 1), fine))
        numbers[f"work less strain energy, {roof.name} [% of work]"] = 100 * (
            1 - float(roof.path["energy.strain"].values[-1]) / work
        )
    return Finding(
        "Check of our own: along the whole path the load has done the work that is stored.",
        all(abs(float(value)) < 0.2 for value in numbers.values()),
        rounded(numbers),
        "The work is integrated over the points of the path by cubic splines.",
    )

"""Statics, buckling and natural modes in a model file, as declarations."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Annotated, ClassVar

from pydantic import Field

from lamella.assembly.equations import Equations
from lamella.critical import Branch, CriticalPoint
from lamella.declaration import declaration
from lamella.dofs import Signal
from lamella.errors import ModelError
from lamella.io.analysis import Analysis, Computed, Count, model_of, result_of, state_of
from lamella.modal import Modes, modes
from lamella.model import Model
from lamella.result import Result, Sink
from lamella.roles import Floats
from lamella.shapes import Shapes
from lamella.signals import LOAD_FACTOR, system_signals
from lamella.solve.arc_length import ArcLength
from lamella.solve.displacement_control import DisplacementControl
from lamella.solve.newton import Newton
from lamella.stability import Buckling as BucklingShapes
from lamella.stability import buckling
from lamella.static_run import compiled
from lamella.statics import STATIC_NEWTON, equilibrium, equilibrium_path
from lamella.units import Length, Number, Time


@declaration
class Imperfection:
    """A shape that an earlier analysis gave, added to the stress-free geometry.

    Args:
        of: name of an earlier analysis ``buckling`` or ``natural_modes``, or of one in statics with critical points.
        shape: number of the shape or critical point, from 1.
        amplitude: its largest displacement [m].
    """

    of: str
    amplitude: Length
    shape: Count = 1

    def of_earlier(self, analysis: Analysis, earlier: Mapping[str, Computed]) -> Floats:
        """The change of all coordinates, shape (n_q,)."""
        found = earlier.get(self.of)
        if not isinstance(found, Shapes):
            return _critical_point(analysis, self.of, self.shape, earlier).imperfection(self.amplitude)
        if self.shape > len(found.values):
            raise ModelError(
                f"analysis '{analysis.name}': '{self.of}' has no shape {self.shape}; accepted is 1 to {len(found.values)}"
            )
        return found.imperfection(self.shape - 1, self.amplitude)


@declaration
class BranchStart:
    """A bifurcation that an earlier path has passed.

    Args:
        of: name of the earlier analysis.
        point: number of the critical point, from 1.
        amplitude: largest displacement of the first point on the branch [m]; its sign chooses the side.
    """

    of: str
    amplitude: Length
    point: Count = 1

    def of_earlier(self, analysis: Analysis, earlier: Mapping[str, Computed]) -> Branch:
        """Where the path begins."""
        return _critical_point(analysis, self.of, self.point, earlier).branch(self.amplitude)


def _critical_point(analysis: Analysis, of: str, number: int, earlier: Mapping[str, Computed]) -> CriticalPoint:
    """A critical point of the earlier analysis ``of``, by its number from 1.

    Raises:
        ModelError: there is no such analysis, or it has met no such point.
    """
    points = result_of(analysis, of, earlier).critical_points
    if number > len(points):
        accepted = f"accepted is 1 to {len(points)}" if points else "it met none"
        raise ModelError(f"analysis '{analysis.name}': '{of}' has no critical point {number}; {accepted}")
    return points[number - 1]


@declaration
class Statics(Analysis):
    """Static equilibrium under the full load, reached in load steps.

    Args:
        name: unique name.
        steps: number of equal load steps, or ascending load factors to solve for; cut where needed.
        time: time at which loads and prescribed motions are taken [s].
        times: ascending times [s] that are gone through after the load steps to the first of them, each load following its
            profile: loads with different profiles are applied one after the other. ``time`` is then not used.
        imperfection: deviation of the stress-free geometry.
        newton: how each step is solved.
        smallest_step: load step below which the solution is given up.
    """

    name: str
    steps: Count | tuple[Number, ...] = 1
    time: Time = 0.0
    times: tuple[Time, ...] | None = None
    imperfection: Imperfection | None = None
    newton: Newton = STATIC_NEWTON
    smallest_step: Annotated[float, Field(gt=0, lt=1)] = 1e-4

    @property
    def axis(self) -> str:  # pyright: ignore[reportIncompatibleVariableOverride] -- depends on what is asked for
        return "load_factor" if self.times is None else "time"

    @property
    def span(self) -> tuple[float, float]:
        if self.times is not None:
            return (self.times[0], self.times[-1]) if self.times else (0.0, 0.0)
        return 0.0, self.steps[-1] if isinstance(self.steps, tuple) and self.steps else 1.0

    def signals(self, equations: Equations) -> list[Signal]:
        return [LOAD_FACTOR, *system_signals(equations)]

    def prepared(self, model: Model, earlier: Mapping[str, Computed]) -> Model:
        return compiled(model, None if self.imperfection is None else self.imperfection.of_earlier(self, earlier))

    def run(self, model: Model | Equations, earlier: Mapping[str, Computed], frames: int, sinks: Sequence[Sink]) -> Result:
        return equilibrium(
            model,
            t=self.time,
            steps=self.steps,
            times=self.times,
            newton=self.newton,
            smallest_step=self.smallest_step,
            sinks=sinks,
            on_failure="return",
        )


@declaration
class Path(Analysis):
    """The equilibrium path through limit points, by its arc length or by a displacement.

    Args:
        name: unique name.
        until: load factor at which the path ends, 1 when left out; not with ``control``.
        time: time at which loads and prescribed motions are taken [s].
        arc: control of the arc length.
        control: the displacement by which the path is followed, in place of the arc length.
        imperfection: deviation of the stress-free geometry.
        branch: the bifurcation of an earlier path at which it begins.
        newton: how each step is solved.
    """

    axis: ClassVar[str] = "path"
    name: str
    until: Number | None = None
    time: Time = 0.0
    arc: ArcLength | None = None
    control: DisplacementControl | None = None
    imperfection: Imperfection | None = None
    branch: BranchStart | None = None
    newton: Newton = STATIC_NEWTON

    @property
    def span(self) -> tuple[float, float]:
        return 0.0, float(self.control.steps if self.control is not None else (self.arc or ArcLength()).max_steps)

    @property
    def target(self) -> float:
        return float("nan") if self.control is not None else 1.0 if self.until is None else self.until

    def signals(self, equations: Equations) -> list[Signal]:
        return [LOAD_FACTOR, *system_signals(equations)]

    def prepared(self, model: Model, earlier: Mapping[str, Computed]) -> Model:
        if self.branch is not None:
            return result_of(self, self.branch.of, earlier).model
        return compiled(model, None if self.imperfection is None else self.imperfection.of_earlier(self, earlier))

    def run(self, model: Model, earlier: Mapping[str, Computed], frames: int, sinks: Sequence[Sink]) -> Result:
        return equilibrium_path(
            model,
            t=self.time,
            until=self.until,
            arc=self.arc,
            control=self.control,
            branch=None if self.branch is None else self.branch.of_earlier(self, earlier),
            newton=self.newton,
            sinks=sinks,
            on_failure="return",
        )


@declaration
class Buckling(Analysis):
    """Linear buckling: load factors and shapes.

    Args:
        name: unique name.
        count: number of shapes, from the nearest load factor.
        time: time at which loads and prescribed motions are taken [s].
        about: name of an earlier static analysis whose last state they start from; the unloaded one when left out.
    """

    name: str
    count: Count = 4
    time: Time = 0.0
    about: str | None = None

    def prepared(self, model: Model, earlier: Mapping[str, Computed]) -> Model:
        return model_of(self, self.about, earlier) or model

    def run(self, model: Model, earlier: Mapping[str, Computed], frames: int, sinks: Sequence[Sink]) -> BucklingShapes:
        return buckling(model, self.count, t=self.time, state=state_of(self, self.about, earlier))


@declaration
class NaturalModes(Analysis):
    """Natural frequencies and shapes.

    Args:
        name: unique name.
        count: number of modes, from the lowest.
        about: name of an earlier analysis whose last state the modes are about; the reference configuration when left out.
    """

    name: str
    count: Count = 10
    about: str | None = None

    def prepared(self, model: Model, earlier: Mapping[str, Computed]) -> Model:
        return model_of(self, self.about, earlier) or model

    def run(self, model: Model, earlier: Mapping[str, Computed], frames: int, sinks: Sequence[Sink]) -> Modes:
        return modes(model, self.count, state=state_of(self, self.about, earlier))

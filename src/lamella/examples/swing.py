"""What the plate examples compute for each variant: equilibrium, natural modes about it, and the motion after a sudden load."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from lamella.body.plate import Plate
from lamella.modal import Modes
from lamella.result import Result
from lamella.roles import Floats
from lamella.study.measures import component, dominant_frequency, period, time_average
from lamella.study.study import Study

MESH = "system.plate.mesh"
Numbers = dict[str, float | str]


@dataclass(frozen=True)
class Swing:
    """A variant of a model file with the analyses ``still``, ``modes`` and ``swing``, and a marker C.

    Args:
        still: static z of C [m].
        frequencies: of small vibrations about the static deflection [Hz].
        t: times [s].
        z: z of C over time [m].
        result: the motion.
    """

    still: float
    frequencies: Floats
    t: Floats
    z: Floats
    result: Result

    @property
    def lowest(self) -> float:
        return float(self.z.min())

    @property
    def mean(self) -> float:
        return time_average(self.t, self.z)

    @property
    def frequency(self) -> float:
        """From the times at which C passes its static deflection [Hz]; NaN when the motion is too short."""
        return 1.0 / period(self.t, self.z, self.still)

    @property
    def peak_frequency(self) -> float:
        """Of the largest peak in the spectrum [Hz]."""
        return dominant_frequency(self.t, self.z)

    def until(self, t_end: float) -> Swing:
        """The part of the motion up to a time [s]."""
        kept = self.t <= t_end + 1e-9
        return Swing(self.still, self.frequencies, self.t[kept], self.z[kept], self.result)

    @property
    def damped(self) -> float:
        """Energy the integrator has taken, of the largest work of the loads [%]."""
        work = self.result.samples("work.loads")
        return -100.0 * float(self.result.samples("energy.balance")[-1]) / float(work.max())


def run_swing(study: Study, name: str, overrides: Sequence[str], *, pictures: bool = False) -> Swing:
    """Run a variant.

    Args:
        study: runs it.
        name: of the variant.
        overrides: ``key=value`` texts that make it.
        pictures: write the variant's own pictures and report too.
    """
    computed = study.run(name, overrides, pictures=pictures)
    still, modes, swing = computed["still"], computed["modes"], computed["swing"]
    assert isinstance(still, Result)
    assert isinstance(modes, Modes)
    assert isinstance(swing, Result)
    return Swing(
        float(component(still, "C.position", "z")[1][-1]), modes.frequencies, *component(swing, "C.position", "z"), swing
    )


def animation_of(study: Study, name: str, analysis: str = "swing") -> Path | None:
    """The animation of a variant's motion, when one was drawn."""
    files = (path for item in study.finished[name] if item.analysis.name == analysis for path in item.files)
    return next((path for path in files if path.stem == "animation"), None)


def load(force: float) -> str:
    """The override for a force downwards [N]."""
    return f"system.load.force=[0, 0, {-force:.12g} N]"


def meshes(study: Study, sizes: Sequence[int]) -> list[tuple[int, int]]:
    """The square meshes of a study; only the given one when the user has chosen a mesh."""
    if not any(text.startswith(MESH) for text in study.overrides):
        return [(n, n) for n in sizes]
    return [(body.mesh[0], body.mesh[1]) for body in study.read().system.declarations if isinstance(body, Plate)]


def mesh(elements: tuple[int, int]) -> str:
    """The override for a mesh."""
    return f"{MESH}=[{elements[0]}, {elements[1]}]"


def label(elements: tuple[int, int]) -> str:
    """A mesh as text."""
    return f"{elements[0]}x{elements[1]}"


def excess(value: float, reference: float) -> float:
    """By how much a value is larger than another [%]."""
    return 100.0 * (value / reference - 1.0)


def rounded(numbers: Mapping[str, float | str]) -> Numbers:
    """Numbers with five significant digits, percentages with three, without those that could not be computed."""
    shown: Numbers = {}
    for name, value in numbers.items():
        digits = 3 if name.endswith(("%]", "of work]")) else 5
        shown[name] = float(f"{value:.{digits}g}") if isinstance(value, float) else value
    return {name: value for name, value in shown.items() if isinstance(value, str) or np.isfinite(value)}

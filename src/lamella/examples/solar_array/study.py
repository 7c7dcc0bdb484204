"""The unfolding solar array: rigid panels against flexible ones of two layups, with what damping, mesh and hinges change."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from lamella.examples.solar_array import drawing
from lamella.examples.swing import Numbers, rounded
from lamella.result import Result
from lamella.roles import Floats
from lamella.study.findings import Finding
from lamella.study.measures import component, time_average

if TYPE_CHECKING:
    from lamella.study.study import Study

PANELS = ("p1", "p2", "p3", "p4")
DURATION = 5.0
LAYUPS = {
    "symmetric": (-45, 45, -45, 45, 90, 0, 0, 90, 45, -45, 45, -45),
    "antisymmetric": (-45, 45, -45, 45, 90, 0, 0, -90, -45, 45, -45, 45),
}
"""Fibre angles of the paper's two layups, bottom to top [deg]."""

PHASES = {"accelerating": (0.1, 0.5 * DURATION - 0.1), "decelerating": (0.5 * DURATION + 0.1, DURATION - 0.1)}
"""Times [s] between which the drive accelerates or decelerates evenly."""

COARSE = "analysis.unfolding.integrator.dt=5 ms"
Chosen = Mapping[str, "Unfolding"]


@dataclass(frozen=True)
class Unfolding:
    """Forces of one variant.

    Args:
        t: times [s].
        drive: force that drives corners 1 and 2 along x, together, with the share of the middle hinge [N].
        y1, y2: forces of the guides on corners 1 and 2 along y [N].
        z: forces of the guides along z, together [N].
        result: the motion.
    """

    t: Floats
    drive: Floats
    y1: Floats
    y2: Floats
    z: Floats
    result: Result

    def within(self, phase: str, values: Floats) -> tuple[Floats, Floats]:
        """Times and values in a phase."""
        start, end = PHASES[phase]
        kept = (self.t >= start - 1e-9) & (self.t <= end + 1e-9)
        return self.t[kept], values[kept]

    def mean(self, phase: str, values: Floats) -> float:
        """Time average in a phase."""
        return time_average(*self.within(phase, values))

    def oscillation(self, phase: str, what: str, rigid: Unfolding) -> float:
        """Standard deviation in a phase of the force beyond that of rigid panels, which changes by itself as they move [N]."""
        beyond = getattr(self, what) - np.interp(self.t, rigid.t, getattr(rigid, what))
        return float(np.std(self.within(phase, beyond)[1]))


def study(study: Study) -> Iterator[Finding]:
    """Run the variants, draw the paper's figures 9 to 11, and yield the findings."""
    runs = {"rigid": unfold(study, "rigid", each("strain=rigid"))}
    for name in LAYUPS:
        runs[name] = unfold(study, name, [layup(name)], pictures=name == "symmetric")
    others = variants(study)
    if study.draw:
        drawing.show_all(study, runs, others)
    yield means(runs)
    yield opposite(runs)
    yield layups_differ(runs)
    yield nothing_spurious(runs, others)
    yield resolution(runs["rigid"], others)


def unfold(study: Study, name: str, overrides: Sequence[str], *, pictures: bool = False) -> Unfolding:
    """Run one variant."""
    result = study.run(name, overrides, pictures=pictures)["unfolding"]
    assert isinstance(result, Result)

    def force(support: str, label: str) -> Floats:
        return component(result, f"{support}.force", label)[1]

    return Unfolding(
        result.at,
        force("drive1", "x") + force("drive2", "x"),
        force("node1", "y"),
        force("node2", "y"),
        force("node1", "z") + force("node2", "z"),
        result,
    )


def variants(study: Study) -> dict[str, Unfolding]:
    """What step, damping, mesh and the kind of hinge change, with steps of 5 ms; and the small-deformation comparators."""
    points = [f"system.hinge{k}.points=[0, 2 m]" for k in (1, 2, 3)]
    found = {}
    for name in LAYUPS:
        chosen = [COARSE, layup(name)]
        found[f"{name}, 6x6"] = unfold(study, f"{name}-5ms", chosen)
        found[f"{name}, 3x3"] = unfold(study, f"{name}-3x3", [*chosen, *each("mesh=[3, 3]")])
        found[f"{name}, point hinges"] = unfold(study, f"{name}-points", [*chosen, *points])
    usual = [COARSE, layup("symmetric")]
    found["rho_inf 0.6"] = unfold(study, "rho-0.6", [*usual, "analysis.unfolding.integrator.rho_inf=0.6"])
    found["structural damping"] = unfold(study, "damped", [*usual, *each("damping=5 ms")])
    return found


def each(setting: str) -> list[str]:
    """The same setting for every panel."""
    return [f"system.{panel}.{setting}" for panel in PANELS]


def layup(name: str) -> str:
    """The override for a layup."""
    return f"laminates.panel.angles={list(LAYUPS[name])}"


def means(runs: Chosen) -> Finding:
    """The flexible panels vibrate about the forces of rigid ones."""
    numbers: Numbers = {}
    errors = []
    for phase in PHASES:
        rigid = runs["rigid"]
        for what in ("drive", "z"):
            reference = rigid.mean(phase, getattr(rigid, what))
            numbers[f"{what} force, {phase}, mean, rigid [N]"] = reference
            for name in LAYUPS:
                run = runs[name]
                value = run.mean(phase, getattr(run, what))
                numbers[f"{what} force, {phase}, mean, {name} [N]"] = value
                numbers[f"{what} force, {phase}, oscillation, {name} [N]"] = run.oscillation(phase, what, rigid)
                errors.append(abs(value - reference) / abs(reference) if what == "drive" else 0.0)
    numbers["largest difference of the means of the driving force [%]"] = 100.0 * max(errors)
    return Finding(
        "Deformation makes the forces oscillate, and their mean is that of rigid panels (figs. 9 to 11).",
        max(errors) < 0.06,
        rounded(numbers),
        "Means are taken over the time of even acceleration and of even deceleration; the oscillation is the standard deviation "
        "of the difference from the force of rigid panels.",
    )


def opposite(runs: Chosen) -> Finding:
    """The forces along y at corners 1 and 2 are opposite, and they are large."""
    numbers: Numbers = {}
    agrees = True
    for name in LAYUPS:
        run = runs[name]
        for phase in PHASES:
            y1, y2 = run.within(phase, run.y1)[1], run.within(phase, run.y2)[1]
            numbers[f"y force of corner 1, {phase}, mean, {name} [N]"] = float(y1.mean())
            numbers[f"y force of corner 1, {phase}, standard deviation, {name} [N]"] = float(y1.std())
            unequal = float(np.std(y1 + y2) / np.std(y1))
            numbers[f"unequal part of the y forces, {phase}, {name} [%]"] = 100.0 * unequal
            agrees &= unequal < 0.35 and float(y1.std()) > 3.0 * run.oscillation(phase, "drive", runs["rigid"])
    numbers["largest y force, rigid [N]"] = float(np.abs(runs["rigid"].y1).max())
    return Finding(
        "The forces along y at corners 1 and 2 are equal and opposite, with an oscillation too large to be neglected (fig. 9).",
        agrees,
        rounded(numbers),
        "Their mean is not zero: the outer edge bows and pulls its guided corners together. Rigid panels need no force along y.",
    )


def layups_differ(runs: Chosen) -> Finding:
    """Layups agree along y and z and while accelerating; the driving force differs while decelerating."""
    first, second = (runs[name] for name in LAYUPS)
    numbers: Numbers = {}
    apart = {}
    for what in ("drive", "y1", "z"):
        for phase in PHASES:
            a, b = first.within(phase, getattr(first, what))[1], second.within(phase, getattr(second, what))[1]
            apart[what, phase] = float(np.std(b - a)) / first.oscillation(phase, what, runs["rigid"])
            numbers[f"{what}, {phase}: layups differ by, of the oscillation [%]"] = 100.0 * apart[what, phase]
    symmetric, antisymmetric = (run.oscillation("decelerating", "drive", runs["rigid"]) for run in (first, second))
    stronger = antisymmetric / symmetric
    numbers["oscillation of the driving force while decelerating, antisymmetric over symmetric"] = stronger
    grows = apart["drive", "decelerating"] > 1.5 * apart["drive", "accelerating"]
    return Finding(
        "The layups agree while the drive accelerates; while it decelerates the driving forces differ, that of the antisymmetric "
        "layup oscillating more (fig. 11).",
        grows and stronger > 0.99,
        rounded(numbers),
        "The two laminates differ by 5 % in one bending stiffness (and in B16, D16), so that the difference is one of phase that "
        "grows in time more than one of size; how much stronger one oscillates depends on mesh and hinges, see the last finding.",
    )


def nothing_spurious(runs: Chosen, others: Chosen) -> Finding:
    """Energy is kept, the driver's profile excites no spikes, and damping is known."""
    numbers: Numbers = {}
    for name, run in runs.items():
        work = run.result.samples("work.supports")
        balance = run.result.samples("energy.balance")
        numbers[f"energy damped by the integrator, {name} [% of work]"] = -100.0 * float(balance[-1]) / float(np.abs(work).max())
    rigid, usual = runs["rigid"], others["symmetric, 6x6"]
    for name in ("rho_inf 0.6", "structural damping"):
        for phase in PHASES:
            change = others[name].oscillation(phase, "drive", rigid) / usual.oscillation(phase, "drive", rigid)
            numbers[f"oscillation of the driving force with {name}, {phase}, over that without"] = change
    # A force that one sample holds alone is numerical: a vibration at the step's own frequency.
    jumps = []
    for name in LAYUPS:
        run = runs[name]
        second = np.abs(run.drive[2:] - 2.0 * run.drive[1:-1] + run.drive[:-2])
        jumps.append(float(np.percentile(second, 99.9) / np.std(run.drive)))
    numbers["largest change of the driving force's slope in a step, of its oscillation [%]"] = 100.0 * max(jumps)
    damped = [value for name, value in numbers.items() if name.startswith("energy damped") and isinstance(value, float)]
    return Finding(
        "Check of our own: energy is kept, the drive excites no spikes of force, and numerical damping is small.",
        max(abs(value) for value in damped) < 2.0 and max(jumps) < 0.5,
        rounded(numbers),
        "Generalised-alpha with rho_inf = 0.9 and no structural damping; 'structural damping' is Kelvin-Voigt with 5 ms.",
    )


def resolution(rigid: Unfolding, others: Chosen) -> Finding:
    """How the comparison of the layups depends on mesh and hinges."""
    numbers: Numbers = {}
    ratios = []
    for kind in ("6x6", "3x3", "point hinges"):
        pair = [others[f"{name}, {kind}"] for name in LAYUPS]
        for phase in PHASES:
            for name, run in zip(LAYUPS, pair, strict=True):
                oscillation = run.oscillation(phase, "drive", rigid)
                numbers[f"oscillation of the driving force, {kind}, {phase}, {name} [N]"] = oscillation
        symmetric, antisymmetric = (run.oscillation("decelerating", "drive", rigid) for run in pair)
        ratios.append(antisymmetric / symmetric)
    return Finding(
        "Study of our own: with every mesh and hinge the antisymmetric layup oscillates at least as much while decelerating.",
        min(ratios) > 0.98,
        rounded(numbers),
        "By how much is not converged: it takes a finer mesh and the paper's own mechanism to compare sizes.",
    )

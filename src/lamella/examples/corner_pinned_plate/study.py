"""The plate on four pinned corners under 2 N and 10 N: refinement, frequency over force, and the well-posed variant."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

import lamella as lm
from lamella.examples.corner_pinned_plate import drawing
from lamella.examples.swing import Numbers, Swing, excess, label, load, mesh, meshes, rounded, run_swing
from lamella.roles import Floats
from lamella.study.findings import Finding
from lamella.study.measures import component

if TYPE_CHECKING:
    from lamella.study.study import Study

FORCES = (2, 10)
MOVING = (4, 6, 8)
"""Elements along a side in the motions."""
REFINED = (3, 4, 6, 8, 12, 16, 24)
"""Elements along a side in the statics; many are doubles of others."""
SLIDING = ("system.pin2.axes=yz", "system.pin3.axes=z", "system.pin4.axes=z")
"""Corners held along z; what is left of xyz at pins 1 and 2 only keeps the plate from drifting and turning in its plane."""
FORCES_AT_REST = (0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 3.5, 5.0, 7.5, 10.0)

CALCULIX = {(2, 8): -0.003432, (2, 24): -0.003629, (10, 8): -0.007218, (10, 24): -0.007614}
"""Static z_C [m] by force [N] and elements along a side, shells S8R of CalculiX, for the model as the file gives it."""
TRACE = ((0.1, 0.25, 0.5, 0.75, 1.0), (-0.002513, -0.003577, -0.004216, -0.001188, -0.002327))
"""z_C [m] at times [s] under 2 N, from another code with absolute nodal coordinates, 6x6, steps of 0.25 ms."""
WELL_POSED = {2: -0.00926, 10: -0.0436}
"""Static z_C [m] with sliding corners, mean of three programs, which agree to 0.4 %."""

Heights = Mapping[tuple[int, int], float]


def study(study: Study) -> Iterator[Finding]:
    """Run the variants, draw the paper's figures 6 and 7 and what explains them, and yield the findings."""
    grids = meshes(study, MOVING)
    middle = grids[len(grids) // 2]
    swings = {
        (force, label(grid)): run_swing(
            study, f"{force}N-mesh-{label(grid)}", [load(force), mesh(grid)], pictures=(force, grid) == (FORCES[-1], middle)
        )
        for force in FORCES
        for grid in grids
    }
    as_given = not study.overrides  # the other programs computed the model as the file gives it
    study.say("frequencies of small vibrations over the force")
    stiffening = frequencies(study)
    refined = len(grids) > 1  # a mesh given by the user leaves nothing to refine
    pinned = static_heights(study, "corners pinned", ()) if refined else {}
    sliding = static_heights(study, "corners sliding in the plane", SLIDING) if refined else {}
    if study.draw:
        drawing.show_all(
            study, swings, label(middle), stiffening, pinned, sliding, CALCULIX if as_given else {}, TRACE if as_given else None
        )
    if as_given:
        yield equal_meshes(pinned, swings)
    if refined:
        yield no_limit(pinned)
        yield well_posed(sliding, WELL_POSED if as_given else {})
    yield rising_frequency({force: swings[force, label(middle)] for force in FORCES}, stiffening)


def static_heights(study: Study, what: str, overrides: Sequence[str]) -> dict[tuple[int, int], float]:
    """Static z_C [m] by force [N] and number of elements along a side."""
    factors = [force / FORCES[-1] for force in FORCES]
    found = {}
    for n in REFINED:
        study.say(f"statics, {what}, {n}x{n} elements")
        model = study.read([load(FORCES[-1]), mesh((n, n)), *overrides])
        at, z = component(lm.equilibrium(model.system, steps=factors), "C.position", "z")
        found |= {(force, n): float(z[np.argmin(np.abs(at - factor))]) for force, factor in zip(FORCES, factors, strict=True)}
    return found


def frequencies(study: Study) -> tuple[Floats, Floats]:
    """Forces [N], and the lowest two frequencies of small vibrations about the equilibrium under them [Hz], shape (n, 2)."""
    found = [lm.modes(study.read().system, 2).frequencies]
    for force in FORCES_AT_REST:
        model = study.read([load(force)]).system.compile()
        found.append(lm.modes(model, 2, state=lm.equilibrium(model).final).frequencies)
    return np.array([0.0, *FORCES_AT_REST]), np.array(found)


def equal_meshes(pinned: Heights, swings: Mapping[tuple[int, str], Swing]) -> Finding:
    """36 of these elements give what 64 of another program's give."""
    numbers: Numbers = {}
    for force in FORCES:
        numbers |= {
            f"static z_C, {force} N, here 36 elements [m]": pinned[force, 6],
            f"static z_C, {force} N, here 64 elements [m]": pinned[force, 8],
            f"static z_C, {force} N, CalculiX 64 S8R [m]": CALCULIX[force, 8],
            f"here 36 against CalculiX 64, {force} N [%]": excess(pinned[force, 6], CALCULIX[force, 8]),
            f"here 64 against CalculiX 64, {force} N [%]": excess(pinned[force, 8], CALCULIX[force, 8]),
            f"mean in motion, here 36 against 64, {force} N [%]": excess(swings[force, "6x6"].mean, swings[force, "8x8"].mean),
        }
    closeness = max(abs(excess(pinned[force, 6], CALCULIX[force, 8])) for force in FORCES)
    return Finding(
        "36 of these elements give what ANSYS needs 64 elements for (fig. 6).",
        closeness < 1.0,
        rounded(numbers),
        "Agrees as a comparison of meshes: 36 elements here stand where 64 eight-node shells of CalculiX stand, and SHELL281 of "
        "ANSYS is an eight-node shell too. It says nothing about accuracy, since there is no limit to be near to.",
    )


def no_limit(pinned: Heights) -> Finding:
    """The deflection has converged with 36 elements: it has not, and cannot."""
    numbers: Numbers = {}
    for force in FORCES:
        for n in (3, 6, 12):
            numbers[f"change of static z_C, {n}x{n} to {2 * n}x{2 * n}, {force} N [%]"] = excess(
                pinned[force, 2 * n], pinned[force, n]
            )
        slope = np.polyfit(np.log2(REFINED[2:]), [1e3 * pinned[force, n] for n in REFINED[2:]], 1)[0]
        numbers[f"z_C per doubling from 6x6 on, {force} N [mm]"] = float(slope)
    return Finding(
        "With 36 elements the deflection has converged (fig. 6).",
        all(abs(excess(pinned[force, 24], pinned[force, 12])) < 1.0 for force in FORCES),
        rounded(numbers),
        "A point support in the plane of a two-dimensional elastic body is singular: the membrane gives way without bound, as "
        "the logarithm of the number of elements, so every doubling adds nearly the same deflection, in every program. Curves "
        "that coincide in a plot are close only because the logarithm is slow.",
    )


def well_posed(sliding: Heights, others: Mapping[int, float]) -> Finding:
    """With corners free to slide in the plane the deflection converges."""
    numbers: Numbers = {}
    changes = []
    for force in FORCES:
        for n in (3, 6, 12):
            numbers[f"change of static z_C, {n}x{n} to {2 * n}x{2 * n}, {force} N [%]"] = excess(
                sliding[force, 2 * n], sliding[force, n]
            )
        changes.append(abs(excess(sliding[force, 24], sliding[force, 12])))
        numbers[f"static z_C, 24x24, {force} N [m]"] = sliding[force, 24]
        if force in others:
            numbers[f"three other programs, {force} N [m]"] = others[force]
            changes.append(abs(excess(sliding[force, 24], others[force])))
    return Finding(
        "Check of our own: held along z only, corners free to slide in the plane, the deflection does converge.",
        max(changes) < 0.4,
        rounded(numbers),
        "Without forces in the plane there is no singularity, and the plate deflects 2.6 (2 N) to 6 times (10 N) as far: what "
        "carries the load of the pinned plate is its mid-surface.",
    )


def rising_frequency(swings: Mapping[int, Swing], stiffening: tuple[Floats, Floats]) -> Finding:
    """A larger force raises the frequency."""
    low, high = swings[2], swings[10]
    forces, lowest = stiffening[0], stiffening[1][:, 0]
    two, ten = (float(np.interp(force, forces, lowest)) for force in FORCES)
    numbers: Numbers = {
        "largest peak of the spectrum of z_C, 2 N [Hz]": low.peak_frequency,
        "largest peak of the spectrum of z_C, 10 N [Hz]": high.peak_frequency,
        "ratio of the two": high.peak_frequency / low.peak_frequency,
        "first natural frequency, unloaded [Hz]": float(lowest[0]),
        "first natural frequency, at rest under 2 N [Hz]": two,
        "first natural frequency, at rest under 10 N [Hz]": ten,
        "static deflection, 10 N over 2 N (5 if linear)": high.still / low.still,
    }
    return Finding(
        "Other than the cantilever's, the frequency of the pinned plate rises with the force: the stretched mid-surface stiffens "
        "it (fig. 6 against 7).",
        high.peak_frequency > 1.2 * low.peak_frequency and ten > 1.2 * two,
        rounded(numbers),
    )

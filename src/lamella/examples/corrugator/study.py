"""The belt of a corrugating machine: tilt, drift, stress and forces of contact, with unequal and with equal forces."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from lamella.contact.block import ContactBlock
from lamella.errors import DeclarationError
from lamella.examples.corrugator import at_rest, drawing
from lamella.examples.swing import Numbers, rounded
from lamella.result import Result
from lamella.roles import Floats
from lamella.study.findings import Finding
from lamella.study.measures import component, time_average
from lamella.study.study import Study

LENGTH, WIDTH, H = 2.5, 0.8, 4e-3
R2, R3 = 0.15, 0.12
ARM = 0.5
"""Distance of the forces on roller 2 from its middle [m]."""
PAPER = (
    "profiles.press.t_end=1 s",
    "profiles.tighten.t_end=0.4 s",
    "profiles.pull.t_start=1 s",
    "profiles.pull.t_end=3 s",
    "profiles.speed.t_start=3 s",
    "profiles.speed.t_end=5 s",
    "analysis.run.t_end=15 s",
    "output.frames=375",
)
"""The paper's 15 s, the first for pressing and tightening; the model itself has a shorter schedule."""
EVEN = ("system.pull_a.force=[3000 N, 0, 0]", "system.pull_b.force=[3000 N, 0, 0]", "analysis.run.t_end=4.3 s")
VARIANTS: Mapping[str, tuple[str, ...]] = {
    "unequal": PAPER,
    "equal": EVEN,
    "plate36": ("system.belt.element=plate36",),
}
Runs = Mapping[str, Result]


def study(study: Study) -> Iterator[Finding]:
    """Run the variants, draw the paper's figures 7 to 12, and yield the findings."""
    runs: dict[str, Result] = {}
    for name, overrides in VARIANTS.items():
        result = study.run(name, overrides)["run"]
        assert isinstance(result, Result)
        runs[name] = result
    study.say("the belt at rest, with exact strains and small deformation on several meshes")
    tight = at_rest.all_meshes(study)
    if study.draw:
        drawing.show_all(study, runs)
        drawing.show_meshes(study, at_rest.errors(tight))
    yield drift(runs)
    yield stress(runs["unequal"])
    yield pressing(runs["unequal"])
    yield even(runs)
    yield element(runs)
    yield balance(runs["unequal"])
    yield at_rest.small_deformation(tight, LENGTH, R2, H)


def settled(run: Result) -> float:
    """When the belt has gone around once at full speed [s].

    Raises:
        DeclarationError: the run ends before.
    """
    t, speed = component(run, "roller3.angular_velocity", "z")
    full = float(speed.max())
    once = float(t[np.argmax(speed > 0.9999 * full)]) + LENGTH / (full * (R3 + 0.5 * H)) if full > 0.0 else np.inf
    if once >= t[-1]:
        raise DeclarationError(
            "study corrugator",
            f"a run ends at {t[-1]:.4g} s, before the belt has gone around once at full speed",
            "accepted is a later analysis.run.t_end; a copy of the model file alone may be run to any time",
        )
    return once


def mean(run: Result, name: str, label: str) -> float:
    """Time average of a component of a signal while the belt runs at full speed."""
    t, values = component(run, name, label)
    late = t >= settled(run)
    return time_average(t[late], values[late])


def late_frames(run: Result) -> list[int]:
    """Frames while the belt runs at full speed."""
    return [int(frame) for frame in np.flatnonzero(run.frame_at >= settled(run))]


def tilt(run: Result) -> tuple[Floats, Floats]:
    """Time [s] and tilt of roller 2 about y, positive where its end b is nearer to roller 1 [rad]."""
    t, a = component(run, "end_a.position", "x")
    return t, (a - component(run, "end_b.position", "x")[1]) / (2 * ARM)


def loop_mean(run: Result) -> Floats:
    """z of the belt's middle line, averaged around the loop, at each frame [m].

    A point of the belt moves to and fro along z once in every turn, since the loop is askew; the average shows the drift alone.
    """
    return np.array([run.plate("belt", frame, 2).r[1, :-1, 2].mean() for frame in range(len(run.frame_at))])


def drift_rate(run: Result) -> float:
    """Drift of the belt along z at full speed, by least squares [m/s]."""
    late = late_frames(run)
    return float(np.polyfit(run.frame_at[late], loop_mean(run)[late], 1)[0])


def centre_von_mises(run: Result) -> Floats:
    """The larger one of the von Mises stresses of both sides at the belt's centre, at each frame [Pa]."""
    samples = (run.plate("belt", frame, 2) for frame in range(len(run.frame_at)))
    return np.array([max(float(s.von_mises(0, side)[1, 1]) for side in ("bottom", "top")) for s in samples])


def tension(run: Result) -> Floats:
    """Membrane force along the belt at 0, 25, 50, 75, 100 % of its width, mean over the loop and time [N/m]."""
    frames = late_frames(run)[::5]
    return np.mean([run.plate("belt", frame, 4).section_forces()[:, :-1, 0].mean(axis=1) for frame in frames], axis=0)


def touching(run: Result, frame: int) -> tuple[Floats, Floats]:
    """Pressure of all rollers [Pa] and friction per area [Pa] on the unrolled belt, rows along its width; shape (7, 280)."""
    q, v = run.frame_q[frame], run.frame_v[frame]
    blocks = [block for block in run.model.forces if isinstance(block, ContactBlock)]
    fields = [block.field(q, v) for block in blocks]
    pressure = sum(field.pressure for field in fields)
    friction = np.linalg.norm(sum(field.traction for field in fields), axis=-1)
    mesh, n = run.model.plates[0], round(np.sqrt(blocks[0].sheet.n_point))

    def unrolled(values: Floats) -> Floats:
        cells = values.reshape(mesh.ny, mesh.nx, n, n)
        return cells.transpose(0, 2, 1, 3).reshape(mesh.ny * n, mesh.nx * n)

    return unrolled(np.asarray(pressure)), unrolled(friction)


def drift(runs: Runs) -> Finding:
    """Unequal forces tilt roller 2, and the belt drifts to the slack side."""
    run = runs["unequal"]
    t, angle = tilt(run)
    late = t >= settled(run)
    rate, slope = drift_rate(run), time_average(t[late], angle[late])
    speed = mean(run, "roller3.angular_velocity", "z") * (R3 + 0.5 * H)
    numbers: Numbers = {
        "displacement of roller 2 along X at full speed [mm]": 1e3
        * (mean(run, "roller2.position", "x") - float(component(run, "roller2.position", "x")[1][0])),
        "tilt of roller 2, end b nearer [mrad]": 1e3 * slope,
        "drift towards end b [mm/s]": 1e3 * rate,
        "drift per metre of travel [mm/m]": 1e3 * rate / speed,
        "drift over tilt times speed": rate / (slope * speed),
        "offset of the belt at the end [mm]": 1e3 * float(loop_mean(run)[-1]),
        "force of roller 1 on the belt along Z [N]": -mean(run, "touch1.force", "z"),
        "force of roller 2 on the belt along Z [N]": -mean(run, "touch2.force", "z"),
        "force of roller 3 on the belt along Z [N]": -mean(run, "touch3.force", "z"),
    }
    return Finding(
        "With unequal forces on its ends roller 2 is no longer parallel to roller 1, and the belt drifts towards the slack side.",
        slope > 0.0 and rate > 0.0,
        rounded(numbers),
        "End b is the one that is pulled less. The rate is a small part of tilt times speed; it depends on friction, "
        "element and mesh.",
    )


def stress(run: Result) -> Finding:
    """The side that is pulled more is stressed more."""
    N = tension(run) / H
    history, late = centre_von_mises(run), late_frames(run)
    total = float(np.trapezoid(N * H, dx=WIDTH / 4))
    numbers: Numbers = {
        "membrane stress at the edge of end a, mean over the loop [MPa]": 1e-6 * float(N[0]),
        "membrane stress in the middle [MPa]": 1e-6 * float(N[2]),
        "membrane stress at the edge of end b [MPa]": 1e-6 * float(N[-1]),
        "edge a over edge b": float(N[0] / N[-1]),
        "tension of a strand [N]": total,
        "half of the forces on roller 2 [N]": 3500.0,
        "von Mises stress at the belt's centre: largest [MPa]": 1e-6 * float(history[late].max()),
        "von Mises stress at the belt's centre: median [MPa]": 1e-6 * float(np.median(history[late])),
    }
    return Finding(
        "The stress on the side with the larger force is clearly larger than on the other.",
        float(N[0]) > 1.5 * float(N[-1]) > 0.0,
        rounded(numbers),
        "Bending dominates: the straight strands have lost the curvature of the stress-free cylinder, and roller 3 "
        "bends the belt backwards.",
    )


def pressing(run: Result) -> Finding:
    """Roller 3 presses on the belt over its whole width, and drives it by friction."""
    pressure = np.mean([touching(run, frame)[0] for frame in late_frames(run)[::5]], axis=0).sum(axis=1)
    surface = [abs(mean(run, f"roller{k}.angular_velocity", "z")) * (R + 0.5 * H) for k, R in ((1, R2), (2, R2), (3, R3))]
    numbers: Numbers = {
        "force of roller 3 on the belt along Y [N]": -mean(run, "touch3.force", "y"),
        "sum of the normal forces, roller 1 [N]": _mean_scalar(run, "touch1.normal"),
        "sum of the normal forces, roller 2 [N]": _mean_scalar(run, "touch2.normal"),
        "sum of the normal forces, roller 3 [N]": _mean_scalar(run, "touch3.normal"),
        "pressure of all rollers, row of points at edge a over row at edge b": float(pressure[0] / pressure[-1]),
        "speed of the belt's mid-surface by roller 1 [m/s]": surface[0],
        "by roller 2 [m/s]": surface[1],
        "by roller 3, which drives [m/s]": surface[2],
        "slip of roller 2 [%]": 100.0 * (surface[1] / surface[2] - 1.0),
    }
    agrees = abs(float(numbers["slip of roller 2 [%]"])) < 0.2 and float(pressure.min()) > 0.0
    return Finding(
        "The forces of contact between belt and rollers are found point by point; friction on roller 3 drives belt and rollers.",
        agrees,
        rounded(numbers),
    )


def even(runs: Runs) -> Finding:
    """With equal forces nothing tilts or drifts."""
    run = runs["equal"]
    t, angle = tilt(run)
    late = t >= settled(run)
    numbers: Numbers = {
        "largest tilt of roller 2 at full speed [mrad]": 1e3 * float(np.abs(angle[late]).max()),
        "drift [mm/s]": 1e3 * drift_rate(run),
        "displacement of roller 2 along X at full speed [mm]": 1e3
        * (mean(run, "roller2.position", "x") - float(component(run, "roller2.position", "x")[1][0])),
    }
    small = abs(float(numbers["drift [mm/s]"])) < 1e-3 * abs(1e3 * drift_rate(runs["unequal"]))
    return Finding(
        "Check of our own: with equal forces, 3500 N on each end, roller 2 does not tilt and the belt does not drift.",
        small and float(np.abs(angle[late]).max()) < 1e-6,
        rounded(numbers),
    )


def element(runs: Runs) -> Finding:
    """The paper's element, without r_xy, on the same mesh."""
    numbers: Numbers = {}
    signs: list[bool] = []
    for name, run in (("plate48", runs["unequal"]), ("plate36", runs["plate36"])):
        t, angle = tilt(run)
        late = t >= settled(run)
        rate, slope = drift_rate(run), time_average(t[late], angle[late])
        numbers[f"tilt, {name} [mrad]"] = 1e3 * slope
        numbers[f"drift, {name} [mm/s]"] = 1e3 * rate
        signs += [rate > 0.0, slope > 0.0]
    return Finding(
        "Check of our own: the paper's element with 36 coordinates tilts and drifts to the same side as the one with 48.",
        all(signs),
        rounded(numbers),
        "On one element across the belt plate36 is softer, since its slope jumps between its nodes; see the page on shells.",
    )


def balance(run: Result) -> Finding:
    """Forces and energy are balanced."""
    work = run.samples("work.loads")[-1] + run.samples("work.supports")[-1]
    left = float(run.samples("energy.balance")[-1])
    forces = {f"{k}{axis}": mean(run, f"touch{k}.force", axis) for k in (1, 2, 3) for axis in "xyz"}
    numbers: Numbers = {
        "force of the belt on roller 2 along X [N]": forces["2x"],
        "forces on its ends [N]": 7000.0,
        "force on all rollers along X [N]": sum(forces[f"{k}x"] for k in (1, 2, 3)),
        "along Y [N]": sum(forces[f"{k}y"] for k in (1, 2, 3)),
        "along Z [N]": sum(forces[f"{k}z"] for k in (1, 2, 3)),
        "work of forces and drives [J]": float(work),
        "turned into heat [J]": float(run.samples("work.dissipated")[-1]),
        "left by the balance of energy [J]": left,
        "left, of work [%]": 100.0 * left / float(work),
    }
    sums = [float(numbers[name]) for name in ("force on all rollers along X [N]", "along Y [N]", "along Z [N]")]
    agrees = abs(forces["2x"] + 7000.0) < 35.0 and max(map(abs, sums)) < 10.0 and abs(left) < 5e-3 * abs(float(work))
    return Finding(
        "Check of our own: the belt holds roller 2 against its forces, what acts on the belt is in balance, and energy is kept.",
        agrees,
        rounded(numbers),
    )


def _mean_scalar(run: Result, name: str) -> float:
    """Time average of a scalar signal at full speed."""
    late = run.at >= settled(run)
    return time_average(run.at[late], run.samples(name)[late])

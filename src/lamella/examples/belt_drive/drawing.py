"""The pictures of the study."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from lamella.examples.belt_drive import published
from lamella.examples.belt_drive.loop import APART, LENGTH, Loop, R, place, strands, tensions
from lamella.result import Result
from lamella.roles import Floats
from lamella.study.measures import component

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from lamella.study.study import Study

VIEW = (0.0, -0.4, 1.0)
"""Direction in which the camera looks: along the axles, from above; X points to the left."""
STICK, SLIP = "#dcebe3", "#f7dfe2"
"""Behind the arcs of stick and of slip."""
OUTWARD = 0.4e-6
"""Length by which a pressure is drawn [m/Pa]."""
PLACES = ("slack strand", "pulley 2, braked", "tight strand", "pulley 1, drives")


def show_all(study: Study, run: Result, around: Loop) -> None:
    """Draw what runs around the loop, the drive, its history, and the belt in space."""
    study.show(loop_figure(around), "loop", "Around the loop, along the belt's motion: tension, pressure and friction, slip.")
    study.show(
        drive_figure(run, around),
        "drive",
        "The drive at the end: tension of the belt, and the pressure of the pulleys as a fringe.",
    )
    study.show(history_figure(run), "history", "Speeds, torque and tensions over time; dots are the published values at 2.45 s.")
    study.say("drawing the belt")
    shaded(study, run)


def loop_figure(around: Loop) -> Figure:
    """Tension, pressure with friction, and slip over the place around the loop."""
    from lamella.examples.belt_drive.study import MU
    from lamella.viz.style import COLOURS, INK, new_figure, styled

    with styled():
        figure = new_figure(6.4)
        panels = figure.subplots(3, 1, sharex=True, height_ratios=(1.2, 1.2, 1.0))
        for axes in panels:
            _shade(axes, around)
        against, T = published.tension()
        s = np.mod(2 * APART + np.pi * R - against, LENGTH)  # theirs begins where ours meets pulley 1
        order = np.argsort(s)
        top, middle, bottom = panels
        top.plot(s[order], T[order], "o", color=COLOURS[1], markersize=2.6, label="published, cable")
        top.plot(around.s, around.tension, color=COLOURS[0], label="lamella, shell")
        top.set(ylabel="Tension [N]", ylim=(0, 760))
        top.legend(loc="upper left", ncols=2)
        middle.plot(around.s, 1e-3 * MU * around.pressure, color=COLOURS[3], linewidth=1.1, label="μ times pressure")
        middle.plot(around.s, -1e-3 * MU * around.pressure, color=COLOURS[3], linewidth=1.1)
        middle.plot(around.s, 1e-3 * around.traction, color=COLOURS[0], label="friction on the belt, along its motion")
        middle.set(ylabel="Stress [kPa]")
        middle.legend(loc="upper left")
        bottom.plot(around.s, 1e3 * around.slip, color=COLOURS[0])
        bottom.set(ylabel="Slip [mm/s]", xlabel="Distance along the belt's motion [m]", xlim=(0.0, LENGTH))
        for k, name in enumerate(PLACES):
            top.text((k + 0.5) * LENGTH / 4, 1.03, name, transform=top.get_xaxis_transform(), ha="center", color=INK, fontsize=9)
    return figure


def _shade(axes: Axes, around: Loop) -> None:
    """Colour the arcs of stick and slip."""
    from lamella.examples.belt_drive.study import slipping

    half = 0.5 * (around.s[1] - around.s[0])
    slips, touches = slipping(around), around.pressure > 1e3
    for colour, kept in ((SLIP, touches & slips), (STICK, touches & ~slips)):
        for first, last in _runs(kept):
            axes.axvspan(around.s[first] - half, around.s[last] + half, color=colour, linewidth=0, zorder=0)


def _runs(kept: np.ndarray) -> list[tuple[int, int]]:
    """First and last numbers of runs of true."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], kept.astype(int), [0]])))
    return [(int(a), int(b) - 1) for a, b in zip(edges[::2], edges[1::2], strict=True)]


def drive_figure(run: Result, around: Loop) -> Figure:
    """The pulleys, the belt coloured by its tension, the pressure as a fringe, and where it sticks."""
    from matplotlib.collections import LineCollection
    from matplotlib.patches import Circle

    from lamella.examples.belt_drive.study import slipping
    from lamella.viz.style import COLOUR_MAP, INK, new_figure, styled

    with styled():
        figure = new_figure(3.6)
        axes = figure.subplots()
        axes.set(aspect="equal", xlim=(-0.155, APART + 0.155), ylim=(-0.138, 0.146))
        axes.axis("off")
        for k, centre in enumerate((0.0, APART)):
            axes.add_patch(Circle((centre, 0.0), R - 2e-3, facecolor="#eef1f5", edgecolor="#8a95a3", linewidth=1.0))
            axes.add_patch(Circle((centre, 0.0), 0.008, facecolor="white", edgecolor="#8a95a3", linewidth=1.0))
            omega = component(run, f"pulley{k + 1}.angular_velocity", "z")[1][-1]
            axes.text(centre, -0.03, f"pulley {k + 1}\n{omega:.2f} rad/s", ha="center", va="top", fontsize=9, color=INK)
            _turn(axes, centre)
        slips, touches = slipping(around), around.pressure > 1e3
        base, out = _line(around.s, 4e-3), _line(around.s, 4e-3 + OUTWARD * around.pressure)
        for colour, kept in (("#d1495b", touches & slips), ("#2a9d6f", touches & ~slips)):
            bars = LineCollection(list(np.stack([base[kept], out[kept]], axis=1)), colors=colour, linewidths=1.1, alpha=0.75)
            axes.add_collection(bars)
        path, T = _path(run)
        line = LineCollection(list(np.stack([path[:-1], path[1:]], axis=1)), cmap=COLOUR_MAP, linewidths=4.0)
        line.set(array=0.5 * (T[1:] + T[:-1]), capstyle="round")
        axes.add_collection(line)
        figure.colorbar(line, ax=axes, label="Tension [N]", shrink=0.75, pad=0.01)
        T1, T2 = strands(run, len(run.frame_at) - 1)
        for y, text, way in ((0.118, f"tight, {T1:.0f} N", -1.0), (-0.118, f"slack, {T2:.0f} N", 1.0)):
            axes.text(0.5 * APART, y, text, ha="center", va="center", fontsize=9, color=INK)
            arrow: Any = {"arrowstyle": "-|>", "color": INK, "linewidth": 1.0}
            ends = (0.5 * APART + 0.03 * way, 0.78 * y), (0.5 * APART - 0.03 * way, 0.78 * y)
            axes.annotate("", xy=ends[0], xytext=ends[1], arrowprops=arrow)
        axes.text(-0.15, 0.145, "sticks", color="#2a9d6f", fontsize=9, fontweight="bold", va="top")
        axes.text(-0.15, 0.128, "slips", color="#d1495b", fontsize=9, fontweight="bold", va="top")
    return figure


def _turn(axes: Axes, centre: float) -> None:
    """An arc with an arrow: the sense of rotation."""
    angle = np.radians(np.linspace(40.0, 140.0, 30))
    x, y = centre + 0.045 * np.cos(angle), 0.045 * np.sin(angle)
    axes.plot(x[:-1], y[:-1], color="#4b5563", linewidth=1.2)
    axes.annotate("", xy=(x[-1], y[-1]), xytext=(x[-3], y[-3]), arrowprops={"arrowstyle": "-|>", "color": "#4b5563"})


def _line(s: Floats, height: Floats | float) -> Floats:
    """Points at a height above the belt's path, shape (n, 2)."""
    piece = np.minimum((4.0 * s / LENGTH).astype(int), 3)
    angle = np.select(
        [piece == 0, piece == 1, piece == 2],
        [np.full_like(s, -0.5 * np.pi), (s - APART) / R - 0.5 * np.pi, np.full_like(s, 0.5 * np.pi)],
        (s - 2 * APART - np.pi * R) / R + 0.5 * np.pi,
    )
    along = np.select([piece == 0, piece == 1, piece == 2], [s, np.full_like(s, APART), 2 * APART + np.pi * R - s], 0.0)
    return np.stack([along + (R + height) * np.cos(angle), (R + height) * np.sin(angle)], axis=1)


def _path(run: Result) -> tuple[Floats, Floats]:
    """The belt at the end, closed, shape (n, 2), and its tension; means over an element, which oscillate less."""
    r = run.plate("belt", None, 7).r[0, :-1]
    s, T = place(r), tensions(run, len(run.frame_at) - 1)[1]
    kernel = np.ones(7) / 7
    smooth = np.convolve(np.concatenate([T[-3:], T, T[:3]]), kernel, mode="valid")
    order = np.argsort(s)
    path = r[order][:, :2]
    return np.concatenate([path, path[:1]]), np.concatenate([smooth[order], smooth[order][:1]])


def history_figure(run: Result) -> Figure:
    """Speeds, torque and tensions over time, with the published values."""
    from lamella.viz.style import COLOURS, new_figure, styled

    with styled():
        figure = new_figure(5.6)
        panels = figure.subplots(3, 1, sharex=True)
        t = run.frame_at
        both = np.array([strands(run, frame) for frame in range(len(t))]).T
        rows: tuple[tuple[str, tuple[tuple[str, Floats, Floats, float | None], ...]], ...] = (
            (
                "Speed [rad/s]",
                (
                    ("pulley 1", *component(run, "pulley1.angular_velocity", "z"), None),
                    ("pulley 2", *component(run, "pulley2.angular_velocity", "z"), published.SPEED),
                ),
            ),
            ("Torque [N m]", (("on pulley 1", run.at, run.samples("drive.torque"), published.TORQUE),)),
            ("Tension [N]", (("tight strand", t, both[0], published.TIGHT), ("slack strand", t, both[1], published.SLACK))),
        )
        for axes, (label, curves) in zip(panels, rows, strict=True):
            for colour, (name, at, values, known) in zip(COLOURS, curves, strict=False):
                axes.plot(at, values, color=colour, label=name, linewidth=1.2)
                if known is not None:
                    axes.plot([2.45], [known], "o", color=colour, markersize=5, markeredgecolor="white", clip_on=False, zorder=5)
            axes.set_ylabel(label)
            axes.legend(loc="upper left", bbox_to_anchor=(1.01, 1.02), borderaxespad=0.0)
        panels[-1].set_xlabel("Time [s]")
        panels[-1].set_xlim(0.0, max(2.45, float(t[-1])))
    return figure


def shaded(study: Study, run: Result) -> None:
    """The belt on its pulleys, coloured by strain, and its motion."""
    from lamella.viz.scene import animation, picture

    folder = study.folder / "pictures"
    field, label = "membrane_strain.xx", "Membrane strain along the belt [–]"
    shape = picture(run, folder / "belt.png", field=field, view=VIEW, per_element=8, label=label)
    study.captions[shape] = "The belt on its pulleys at the end, coloured by its strain; seen from behind, pulley 1 on the right."
    moving = animation(run, folder / "motion.gif", field=field, view=VIEW, frames=60, per_element=6)
    study.captions[moving] = "The motion."
    study.files += [shape, moving]

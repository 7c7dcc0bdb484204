"""The pictures of the study."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from lamella.examples.cylindrical_roof.study import Roof
    from lamella.study.study import Study

TITLES = {"isotropic": "isotropic", "0-90-0": "[0/90/0]", "90-0-90": "[90/0/90]"}
SCALE = 3.0
"""Factor on the displacements in the shaded pictures."""
VIEW = (0.5, 1.0, -0.45)
"""Direction in which the camera looks: along the axis, a little from above."""


def show_all(study: Study, roofs: Sequence[Roof], published: Mapping[str, tuple[float, float]]) -> None:
    """Draw everything for the report page."""
    study.show(
        paths(roofs, published),
        "paths",
        "Load over the displacement of C. The path of the perfect roof is symmetric; hollow circles are its limit points, "
        "crosses bifurcations at which it may leave to a side, and the square is the published point. Dashed: a tenth of the "
        "thickness out of shape.",
    )
    snapshots(study, roofs[0])
    study.say("drawing the roof")
    from lamella.viz.scene import animation

    moving = animation(roofs[0].imperfect, study.folder / "pictures" / "snap.gif", view=VIEW, scale=SCALE)
    study.captions[moving] = f"The imperfect isotropic roof along its path: it snaps to a side first. Displacement × {SCALE:g}."
    study.files.append(moving)


def paths(roofs: Sequence[Roof], published: Mapping[str, tuple[float, float]]) -> Figure:
    """A panel for each section: perfect and imperfect path, critical points, the published point."""
    from lamella.examples.cylindrical_roof.study import FORCE, curve
    from lamella.viz.style import COLOURS, DASHES, INK, new_figure, styled

    with styled():
        figure = new_figure(3.9)
        panels = figure.subplots(1, len(roofs))
        for axes, roof in zip(panels, roofs, strict=True):
            w, load = curve(roof.path)
            axes.plot(w, load, color=COLOURS[0], label="perfect, symmetric")
            axes.plot(*curve(roof.imperfect), color=COLOURS[1], linestyle=DASHES[1], label="imperfection of h/10")
            for kind, marker, fill in (("limit point", "o", "white"), ("bifurcation", "x", INK)):
                points = [point for point in roof.path.critical_points if point.kind == kind]
                at, loads = (
                    [np.interp(point.at, np.arange(len(w)), w) for point in points],
                    [FORCE * point.factor for point in points],
                )
                axes.plot(at, loads, marker, color=INK, markerfacecolor=fill, markersize=4.5, label=kind, zorder=3)
            if roof.name in published:
                where, height = published[roof.name]
                axes.plot(where, height, "s", color=COLOURS[2], markersize=5, label="Sze, Liu and Lo (2004)", zorder=4)
            axes.set(title=TITLES[roof.name], xlabel="Displacement of C [mm]")
        panels[0].set_ylabel("Load [N]")
        figure.legend(*panels[0].get_legend_handles_labels(), loc="outside lower center", ncols=3)
    return figure


def snapshots(study: Study, roof: Roof) -> None:
    """The perfect and the imperfect roof at limit points."""
    from lamella.viz.scene import picture

    for name, result, what in (
        ("symmetric", roof.path, "The perfect isotropic roof"),
        ("sideways", roof.imperfect, "The isotropic roof with its imperfection"),
    ):
        limits = [point.at for point in result.critical_points if point.kind == "limit point"]
        at = [limits[0], 0.5 * (limits[0] + limits[-1]), limits[-1], float(len(result.at) - 1)]
        path = study.folder / "pictures" / f"{name}.png"
        picture(result, path, at=at, view=VIEW, scale=SCALE, title=f"{what}, displacement × {SCALE:g}")
        study.captions[path] = f"{what} near its first limit point, on the way to the last one, there, and at the end."
        study.files.append(path)

"""Shaded pictures by PyVista (VTK) without a screen."""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import Any

import numpy as np

from lamella.roles import Floats
from lamella.viz.camera import Camera
from lamella.viz.renderer import (
    LINE_COLOUR,
    OUTLINE_COLOUR,
    SOLID_COLOUR,
    Body,
    ColourScale,
    Picture,
    Renderer,
    Sheet,
    opengl_window,
)

DISTANCE = 4.0
"""Camera's distance in half widths of the scene; it changes nothing in an orthographic view."""

_LIT: dict[str, Any] = {"ambient": 0.3, "diffuse": 0.8, "specular": 0.25, "specular_power": 18}
_STILL: dict[str, Any] = {"render": False, "reset_camera": False}
"""Neither draw at once nor aim anew when something is added: one drawing a frame is enough."""


class PyVistaRenderer(Renderer):
    """Smoothly shaded surfaces under a light kit."""

    def __init__(self, camera: Camera, colours: ColourScale, size: tuple[int, int]) -> None:
        super().__init__(camera, colours, size)
        if opengl_window():  # spares VTK, and the user, its search for a screen
            os.environ.setdefault("VTK_DEFAULT_OPENGL_WINDOW", opengl_window())
        import pyvista

        self._pyvista: Any = pyvista
        self._plotter: Any = pyvista.Plotter(off_screen=True, window_size=list(size), lighting="light kit")
        self._plotter.set_background("white")
        self._plotter.enable_anti_aliasing("ssaa")
        self._aim()

    def draw(self, sheets: Sequence[Sheet], bodies: Sequence[Body] = ()) -> Picture:
        self._plotter.renderer.clear_actors()
        for sheet in sheets:
            self._add_surface(sheet)
            self._add_lines(self._before_surface(sheet.lines), LINE_COLOUR, opacity=0.8)
            self._add_lines(sheet.outlines, OUTLINE_COLOUR)
        for body in bodies:
            self._add_body(body)
            if len(body.edges):
                self._add_lines(self._before_surface(body.points[body.edges]), LINE_COLOUR, opacity=0.8)
        self._plotter.camera.clipping_range = self._clipping
        self._plotter.render()
        return np.asarray(self._plotter.screenshot(return_img=True))[..., :3]

    def close(self) -> None:
        self._plotter.close()

    def _add_surface(self, sheet: Sheet) -> None:
        grid = self._pyvista.StructuredGrid(*(sheet.points[..., k] for k in range(3)))
        grid.point_data["values"] = sheet.values.reshape(-1, order="F")
        self._plotter.add_mesh(
            grid,
            scalars="values",
            clim=(self.colours.low, self.colours.high),
            cmap=self.colours.colour_map,
            smooth_shading=True,
            show_scalar_bar=False,
            **_LIT,
            **_STILL,
        )

    def _add_body(self, body: Body) -> None:
        triangle = body.faces[:, 2] == body.faces[:, 3]
        parts = [
            np.insert(faces, 0, faces.shape[1], axis=1).reshape(-1) for faces in (body.faces[~triangle], body.faces[triangle, :3])
        ]
        mesh = self._pyvista.PolyData(body.points, faces=np.concatenate(parts))
        shading = {"smooth_shading": True, "split_sharp_edges": True}
        self._plotter.add_mesh(mesh, color=SOLID_COLOUR, **shading, **_LIT, **_STILL)

    def _add_lines(self, lines: Sequence[Floats], colour: str, opacity: float = 1.0) -> None:
        mesh = self._polylines(lines)
        self._plotter.add_mesh(mesh, color=colour, line_width=1.5, opacity=opacity, lighting=False, **_STILL)

    def _before_surface(self, lines: Sequence[Floats] | Floats) -> list[Floats]:
        """Lines slightly before the surface they lie on, so that they are not half hidden in it."""
        lift = 2e-3 * self.camera.half_width * self.camera.look
        return [line - lift for line in lines]

    def _polylines(self, lines: Sequence[Floats]) -> Any:
        """All lines as one mesh, which draws faster than a mesh each."""
        ends = np.cumsum([len(line) for line in lines])
        cells = [np.concatenate([[len(line)], np.arange(end - len(line), end)]) for line, end in zip(lines, ends, strict=True)]
        return self._pyvista.PolyData(np.concatenate(lines), lines=np.concatenate(cells))

    def _aim(self) -> None:
        camera, lens = self.camera, self._plotter.camera
        distance = DISTANCE * max(camera.half_width, camera.half_height)
        lens.position = tuple(camera.centre - distance * camera.look)
        lens.focal_point = tuple(camera.centre)
        lens.up = tuple(camera.up)
        lens.parallel_projection = True
        lens.parallel_scale = camera.half_height
        self._clipping = (0.02 * distance, 2.0 * distance)

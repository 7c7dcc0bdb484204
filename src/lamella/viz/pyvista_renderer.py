"""Shaded pictures by PyVista (VTK) without a screen."""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import Any

import numpy as np

from lamella.roles import Floats
from lamella.viz.camera import Camera
from lamella.viz.renderer import LINE_COLOUR, OUTLINE_COLOUR, ColourScale, Picture, Renderer, Sheet, opengl_window

DISTANCE = 4.0
"""Camera's distance in half widths of the scene; it changes nothing in an orthographic view."""

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

    def draw(self, sheets: Sequence[Sheet]) -> Picture:
        self._plotter.renderer.clear_actors()
        for sheet in sheets:
            self._add_surface(sheet)
            self._plotter.add_mesh(
                self._before_surface(sheet.lines), color=LINE_COLOUR, line_width=1.5, opacity=0.8, lighting=False, **_STILL
            )
            self._plotter.add_mesh(
                self._polylines([sheet.outline]), color=OUTLINE_COLOUR, line_width=1.5, lighting=False, **_STILL
            )
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
            ambient=0.3,
            diffuse=0.8,
            specular=0.25,
            specular_power=18,
            show_scalar_bar=False,
            **_STILL,
        )

    def _before_surface(self, lines: Sequence[Floats]) -> Any:
        """Lines slightly before the surface they lie on, so that they are not half hidden in it."""
        lift = 2e-3 * self.camera.half_width * self.camera.look
        return self._polylines([line - lift for line in lines])

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

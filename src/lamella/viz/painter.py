"""Shaded pictures without OpenGL: faces sorted by depth and painted by matplotlib, the farthest first."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from lamella.roles import Floats
from lamella.viz.renderer import LINE_COLOUR, OUTLINE_COLOUR, Picture, Renderer, Sheet

AMBIENT, DIFFUSE, SPECULAR, SHININESS = 0.42, 0.62, 0.18, 16
LIGHT = (0.35, 0.45, -0.85)
"""Direction of the light in the camera's axes (right, up, look): from above the left shoulder."""

DPI = 100
FINEST = 64
"""Grids are refined until they have this many cells along their longer side, for smooth colours."""


class Painter(Renderer):
    """Lambert shading with a highlight, each face in one colour (painter's algorithm, Newell et al. 1972)."""

    def draw(self, sheets: Sequence[Sheet]) -> Picture:
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.collections import PolyCollection
        from matplotlib.colors import to_rgb
        from matplotlib.figure import Figure

        width, height = self.size
        figure = Figure(figsize=(width / DPI, height / DPI), dpi=DPI, facecolor="white")
        canvas = FigureCanvasAgg(figure)
        axes = figure.add_axes((0.0, 0.0, 1.0, 1.0), xlim=(-1, 1), ylim=(-1, 1))
        axes.set_axis_off()
        polygons, colours, depths, widths = [], [], [], []
        for sheet in sheets:
            corners, face_colours, depth, lift = self._faces(sheet)
            polygons += list(corners)
            colours += list(face_colours)
            depths += list(depth)
            widths += [0.5] * len(depth)  # an edge of the face's own colour closes the seam to its neighbour
            for line, colour, width in [(line, LINE_COLOUR, 0.5) for line in sheet.lines] + [
                (sheet.outline, OUTLINE_COLOUR, 1.1)
            ]:
                flat, depth = self.camera.project(line)
                polygons += list(np.stack([flat[:-1], flat[1:]], axis=1))
                depths += list(0.5 * (depth[:-1] + depth[1:]) - lift)
                colours += [to_rgb(colour)] * (len(line) - 1)
                widths += [width] * (len(line) - 1)
        order = np.argsort(depths)[::-1]
        painted = [colours[k] for k in order]
        axes.add_collection(
            PolyCollection(
                [polygons[k] for k in order],
                facecolors=painted,
                edgecolors=painted,
                linewidths=[widths[k] for k in order],
                closed=True,
            )
        )
        canvas.draw()
        return np.asarray(canvas.buffer_rgba())[..., :3].copy()

    def close(self) -> None:
        """Nothing is held between pictures."""

    def _faces(self, sheet: Sheet) -> tuple[Floats, Floats, Floats, float]:
        """Corners in the picture (n, 4, 2), colours (n, 3) and depths (n,) of the grid's cells, and the lift of lines on them."""
        factor = -(-FINEST // max(sheet.points.shape[0] - 1, sheet.points.shape[1] - 1))
        corners = _cells(refined(sheet.points, factor))
        flat, depth = self.camera.project(corners)
        normal = np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])
        normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-300)
        colours = self.colours.colours(_cells(refined(sheet.values, factor)).mean(axis=1))
        lift = factor * float(np.ptp(depth, axis=1).max())  # a line's segment spans the cell of the coarser grid
        return flat, self._lit(normal, colours), depth.mean(axis=1), lift

    def _lit(self, normal: Floats, colours: Floats) -> Floats:
        camera = self.camera
        light = np.array(LIGHT) / np.linalg.norm(LIGHT) @ np.stack([camera.right, camera.up, camera.look])
        facing = np.where(normal @ camera.look > 0, -1.0, 1.0)[:, None] * normal  # both sides of a plate are lit
        lambert = np.maximum(facing @ light, 0.0)[:, None]
        halfway = light - camera.look
        highlight = np.maximum(facing @ (halfway / np.linalg.norm(halfway)), 0.0)[:, None] ** SHININESS
        return np.clip(colours * (AMBIENT + DIFFUSE * lambert) + SPECULAR * highlight, 0.0, 1.0)


def refined(grid: Floats, factor: int) -> Floats:
    """A grid (my, mx, ...) with ``factor`` intervals for each one, linear between its points."""
    for axis in (0, 1):
        n = grid.shape[axis] - 1
        at = np.arange(n * factor + 1) / factor
        low = np.minimum(at.astype(int), n - 1)
        share = (at - low).reshape((-1,) + (1,) * (grid.ndim - axis - 1))
        grid = np.take(grid, low, axis) * (1.0 - share) + np.take(grid, low + 1, axis) * share
    return grid


def _cells(grid: Floats) -> Floats:
    """The four corner values of each cell of a grid (my, mx, ...), in order around it; shape (n, 4, ...)."""
    corners = np.stack([grid[:-1, :-1], grid[:-1, 1:], grid[1:, 1:], grid[1:, :-1]], axis=2)
    return corners.reshape(-1, *corners.shape[2:])

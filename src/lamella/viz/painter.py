"""Shaded pictures without OpenGL: faces sorted by depth and painted by matplotlib, the farthest first."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from lamella.roles import Floats
from lamella.viz.renderer import LINE_COLOUR, OUTLINE_COLOUR, SOLID_COLOUR, Body, Picture, Renderer, Sheet
from lamella.viz.solids import face_normals

AMBIENT, DIFFUSE, SPECULAR, SHININESS = 0.42, 0.62, 0.18, 16
LIGHT = (0.35, 0.45, -0.85)
"""Direction of the light in the camera's axes (right, up, look): from above the left shoulder."""

DPI = 100
FINEST = 64
"""Cells are divided in each direction until so many fit into the picture's longer side: small ones are sorted well."""


@dataclass
class _Strokes:
    """Polygons and lines to be painted, with colours, depths along the view and widths of their edges."""

    polygons: list[Floats] = field(default_factory=list)
    colours: list[Floats] = field(default_factory=list)
    depths: list[float] = field(default_factory=list)
    widths: list[float] = field(default_factory=list)


class Painter(Renderer):
    """Lambert shading with a highlight, each face in one colour (painter's algorithm, Newell et al. 1972)."""

    def draw(self, sheets: Sequence[Sheet], bodies: Sequence[Body] = ()) -> Picture:
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.collections import PolyCollection
        from matplotlib.figure import Figure

        width, height = self.size
        figure = Figure(figsize=(width / DPI, height / DPI), dpi=DPI, facecolor="white")
        canvas = FigureCanvasAgg(figure)
        axes = figure.add_axes((0.0, 0.0, 1.0, 1.0), xlim=(-1, 1), ylim=(-1, 1))
        axes.set_axis_off()
        strokes = _Strokes()
        for sheet in sheets:
            lift = self._add_faces(strokes, *self._sheet_faces(sheet))
            for line in sheet.lines:
                self._add_line(strokes, line, LINE_COLOUR, 0.5, lift)
            for line in sheet.outlines:
                self._add_line(strokes, line, OUTLINE_COLOUR, 1.1, lift)
        for body in bodies:
            self._add_body(strokes, body)
        order = np.argsort(strokes.depths)[::-1]
        painted = [strokes.colours[k] for k in order]
        axes.add_collection(
            PolyCollection(
                [strokes.polygons[k] for k in order],
                facecolors=painted,
                edgecolors=painted,
                linewidths=[strokes.widths[k] for k in order],
                closed=True,
            )
        )
        canvas.draw()
        return np.asarray(canvas.buffer_rgba())[..., :3].copy()

    def close(self) -> None:
        """Nothing is held between pictures."""

    @property
    def _cell(self) -> float:
        """Longest side of a cell [m]."""
        return 2.0 * max(self.camera.half_width, self.camera.half_height) / FINEST

    def _sheet_faces(self, sheet: Sheet) -> tuple[Floats, Floats]:
        """Corners (n, 4, 3) and colours (n, 3) of the cells of a sheet's refined grid."""
        factors = [intervals(sheet.points, axis, self._cell) for axis in (0, 1)]
        colours = self.colours.colours(_cells(refined(sheet.values, factors)).mean(axis=1))
        return _cells(refined(sheet.points, factors)), colours

    def _add_body(self, strokes: _Strokes, body: Body) -> None:
        """The faces of a body that look at the camera, in cells as small as those of plates, and their edges."""
        from matplotlib.colors import to_rgb

        corners = body.points[body.faces]
        seen = face_normals(corners) @ self.camera.look < 0.0
        if not seen.any():
            return
        cells = np.concatenate([divided(quad, self._cell) for quad in corners[seen]])
        lift = self._add_faces(strokes, cells, np.tile(to_rgb(SOLID_COLOUR), (len(cells), 1)))
        sides = np.stack([body.faces[seen], np.roll(body.faces[seen], -1, axis=1)], axis=-1).reshape(-1, 2)
        visible = {(min(side), max(side)) for side in sides.tolist()}
        for edge in body.edges.tolist():
            if (min(edge), max(edge)) in visible:
                self._add_line(strokes, body.points[edge], LINE_COLOUR, 0.5, lift)

    def _add_faces(self, strokes: _Strokes, corners: Floats, colours: Floats) -> float:
        """Add lit cells; returns the lift of lines on them."""
        flat, depth = self.camera.project(corners)
        strokes.polygons += list(flat)
        strokes.colours += list(self._lit(face_normals(corners), colours))
        strokes.depths += list(depth.mean(axis=1))
        strokes.widths += [0.5] * len(depth)  # an edge of the face's own colour closes the seam to its neighbour
        return float(np.ptp(depth, axis=1).max())

    def _add_line(self, strokes: _Strokes, line: Floats, colour: str, width: float, lift: float) -> None:
        from matplotlib.colors import to_rgb

        flat, depth = self.camera.project(refined(line, [intervals(line, 0, self._cell)]))
        count = len(depth) - 1
        strokes.polygons += list(np.stack([flat[:-1], flat[1:]], axis=1))
        strokes.colours += [np.array(to_rgb(colour))] * count
        strokes.depths += list(0.5 * (depth[:-1] + depth[1:]) - lift)
        strokes.widths += [width] * count

    def _lit(self, normal: Floats, colours: Floats) -> Floats:
        camera = self.camera
        light = np.array(LIGHT) / np.linalg.norm(LIGHT) @ np.stack([camera.right, camera.up, camera.look])
        facing = np.where(normal @ camera.look > 0, -1.0, 1.0)[:, None] * normal  # both sides of a plate are lit
        lambert = np.maximum(facing @ light, 0.0)[:, None]
        halfway = light - camera.look
        highlight = np.maximum(facing @ (halfway / np.linalg.norm(halfway)), 0.0)[:, None] ** SHININESS
        return np.clip(colours * (AMBIENT + DIFFUSE * lambert) + SPECULAR * highlight, 0.0, 1.0)


def intervals(points: Floats, axis: int, cell: float) -> int:
    """Into how many parts no longer than ``cell`` the intervals of a grid of points (..., 3) are divided along an axis."""
    return max(1, int(np.ceil(np.linalg.norm(np.diff(points, axis=axis), axis=-1).max() / cell)))


def refined(grid: Floats, factors: Sequence[int]) -> Floats:
    """A grid with so many intervals for each one along its first axes, linear between its points."""
    for axis, factor in enumerate(factors):
        n = grid.shape[axis] - 1
        at = np.arange(n * factor + 1) / factor
        low = np.minimum(at.astype(int), n - 1)
        share = (at - low).reshape((-1,) + (1,) * (grid.ndim - axis - 1))
        grid = np.take(grid, low, axis) * (1.0 - share) + np.take(grid, low + 1, axis) * share
    return grid


def divided(quad: Floats, cell: float) -> Floats:
    """Cells no longer than ``cell`` that make a quadrilateral with corners (4, 3), shape (n, 4, 3)."""
    sides = np.linalg.norm(np.roll(quad, -1, axis=0) - quad, axis=1)
    counts = [max(1, int(np.ceil(max(sides[k], sides[k + 2]) / cell))) for k in (0, 1)]
    u, v = np.linspace(0.0, 1.0, counts[0] + 1)[None, :, None], np.linspace(0.0, 1.0, counts[1] + 1)[:, None, None]
    return _cells((1.0 - v) * ((1.0 - u) * quad[0] + u * quad[1]) + v * ((1.0 - u) * quad[3] + u * quad[2]))


def _cells(grid: Floats) -> Floats:
    """The four corner values of each cell of a grid (my, mx, ...), in order around it; shape (n, 4, ...)."""
    corners = np.stack([grid[:-1, :-1], grid[:-1, 1:], grid[1:, 1:], grid[1:, :-1]], axis=2)
    return corners.reshape(-1, *corners.shape[2:])

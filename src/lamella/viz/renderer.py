"""What a renderer draws, and which renderer this machine can use."""

from __future__ import annotations

import importlib.util
import os
import subprocess
import sys
from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

from lamella.errors import DeclarationError, MissingExtraError
from lamella.roles import Floats, Ints
from lamella.viz.camera import Camera

if TYPE_CHECKING:
    from matplotlib.colors import Colormap

Picture = NDArray[np.uint8]
RendererName = Literal["auto", "pyvista", "matplotlib"]
LINE_COLOUR, OUTLINE_COLOUR = "#22303c", "#9aa5b1"
SOLID_COLOUR = "#b9c0c8"
"""Of rigid bodies, which carry no field: a grey that no colour map has."""

PROBE_SECONDS = 60.0
CHOICE = "LAMELLA_RENDERER"
"""Environment variable that takes the place of ``auto``, for machines whose OpenGL is known to work, or not to."""

_PROBE = """
import pyvista
plotter = pyvista.Plotter(off_screen=True, window_size=(64, 64))
plotter.add_mesh(pyvista.Sphere(), color="red")
picture = plotter.screenshot(return_img=True)
print("drawn" if picture.std() > 1 else "blank", plotter.render_window.GetClassName())
"""


@dataclass(frozen=True)
class Sheet:
    """One plate as it is drawn.

    Args:
        points: grid in the (scaled) deformed configuration [m], shape (my, mx, 3).
        values: what the colour shows, shape (my, mx).
        lines: element boundaries, each a polyline, shapes (n, 3).
        outlines: edges of the reference configuration, each a polyline, shapes (n, 3).
    """

    points: Floats
    values: Floats
    lines: Sequence[Floats]
    outlines: Sequence[Floats]


@dataclass(frozen=True)
class Body:
    """One rigid body as it is drawn.

    Args:
        points: vertices [m], shape (n, 3).
        faces: quadrilaterals of vertex numbers, outward by the right-hand rule; a triangle repeats its last vertex, shape (m, 4).
        edges: pairs of vertex numbers that are drawn as lines, shape (k, 2).
    """

    points: Floats
    faces: Ints
    edges: Ints


@dataclass(frozen=True)
class ColourScale:
    """How values become colours."""

    name: str
    low: float
    high: float

    @property
    def colour_map(self) -> Colormap:
        """The named map of matplotlib, without the darkest part, where shading and lines would not show."""
        import matplotlib
        from matplotlib.colors import ListedColormap

        first = {"viridis": 0.2, "viridis_r": 0.0}.get(self.name, 0.06)
        last = {"viridis": 1.0, "viridis_r": 0.8}.get(self.name, 0.94)
        return ListedColormap(matplotlib.colormaps[self.name](np.linspace(first, last, 256)))

    def colours(self, values: Floats) -> Floats:
        """Red, green and blue in [0, 1], shape (..., 3)."""
        share = np.clip((values - self.low) / (self.high - self.low), 0.0, 1.0)
        return self.colour_map(share)[..., :3]


class Renderer(ABC):
    """Draws sheets and rigid bodies as seen by one camera.

    1. ``draw`` returns an RGB picture of the size given at construction, on white, and may be called again and again.
    2. The camera's rectangle fills the picture exactly, so that all renderers frame alike.
    3. ``close`` gives back what the renderer holds.
    """

    def __init__(self, camera: Camera, colours: ColourScale, size: tuple[int, int]) -> None:
        self.camera, self.colours, self.size = camera, colours, size

    @abstractmethod
    def draw(self, sheets: Sequence[Sheet], bodies: Sequence[Body] = ()) -> Picture:
        """A picture, shape (height, width, 3)."""

    @abstractmethod
    def close(self) -> None:
        """The renderer is not used any more."""


def make_renderer(name: RendererName, camera: Camera, colours: ColourScale, size: tuple[int, int]) -> Renderer:
    """The renderer asked for; ``auto`` is PyVista where OpenGL works, else matplotlib.

    Raises:
        DeclarationError: no such renderer.
        MissingExtraError: ``pyvista`` is asked for and cannot be used.
    """
    chosen = os.environ.get(CHOICE, name) if name == "auto" else name
    if chosen not in ("auto", "pyvista", "matplotlib"):
        raise DeclarationError("picture", f"renderer = {chosen!r}", "accepted are auto, pyvista, matplotlib")
    if chosen == "matplotlib" or (chosen == "auto" and not opengl_window()):
        from lamella.viz.painter import Painter

        return Painter(camera, colours, size)
    if importlib.util.find_spec("pyvista") is None:
        raise MissingExtraError("renderer 'pyvista' needs PyVista: pip install 'lamella[viz]'")
    if not opengl_window():
        raise MissingExtraError(
            "renderer 'pyvista' needs an OpenGL library (for example libegl1 and libgl1-mesa-dri); 'auto' does without"
        )
    from lamella.viz.pyvista_renderer import PyVistaRenderer

    return PyVistaRenderer(camera, colours, size)


@cache
def opengl_window() -> str:
    """Name of VTK's render window that works here, empty when none does.

    VTK ends the whole process where it finds no OpenGL, so a child process tries it, once.
    """
    if importlib.util.find_spec("pyvista") is None:
        return ""
    arguments: dict[str, Any] = {"capture_output": True, "text": True, "timeout": PROBE_SECONDS, "check": False}
    try:
        done = subprocess.run([sys.executable, "-c", _PROBE], **arguments)
    except (subprocess.TimeoutExpired, OSError):
        return ""
    words = done.stdout.split()
    return words[-1] if done.returncode == 0 and words[-2:-1] == ["drawn"] else ""

"""Rendered panels put together with headings and a colour bar, and saved as a picture or an animation."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from lamella.errors import MissingExtraError
from lamella.viz.camera import Camera
from lamella.viz.renderer import ColourScale, Picture
from lamella.viz.style import save_figure, styled
from lamella.whole import replaced

if TYPE_CHECKING:
    from PIL.Image import Image

UNIT = 100
"""Layout is counted in hundredths of an inch, whatever the resolution."""

SAMPLED = 6
"""Frames of an animation whose colours make its palette."""

NEARLY_WHITE = 246

BAR, HEAD = 110, 26
"""Room for the colour bar, and for the heading of a panel or of the picture."""


class Composer:
    """A picture of one or several panels that share a camera and a colour scale.

    Args:
        camera: gives the panels' proportions.
        colours: of the bar.
        label: of the bar, with unit; no bar when empty.
        panels: number of panels.
        width: of the whole picture [pixel].
        title: heading of the whole picture.
        dpi: resolution; text is as large as at 100 dots per inch on a screen of so many more.

    ``panel`` is the size a renderer must draw [pixel].
    """

    def __init__(self, camera: Camera, colours: ColourScale, label: str, panels: int, width: int, title: str, dpi: int) -> None:
        aspect = camera.half_width / camera.half_height
        columns = min(panels, 3 if panels > 4 or (panels == 3 and aspect <= 1.2) else 2)
        rows = -(-panels // columns)
        width, self._dpi = width * UNIT // dpi, dpi
        panel = (width - BAR if label else width) // columns
        self._panel = (panel, max(round(panel / aspect), 60))
        self.panel = (self._panel[0] * dpi // UNIT, self._panel[1] * dpi // UNIT)
        top = HEAD if title else 0
        self._size = (width, rows * (self._panel[1] + HEAD) + top)
        with styled():
            self._figure, self._images, self._texts = self._build(panels, columns, top)
            if title:
                self._figure.text(12 / width, 1 - 6 / self._size[1], title, va="top", fontsize=11, fontweight="bold")
            if label:
                self._add_bar(colours, label)

    def show(self, pictures: Sequence[Picture], captions: Sequence[str]) -> None:
        """Put pictures and captions into the panels."""
        for image, text, pixels, caption in zip(self._images, self._texts, pictures, captions, strict=True):
            image.set_data(pixels)
            text.set_text(caption)

    def pixels(self) -> Picture:
        """The whole picture, shape (height, width, 3)."""
        with styled():
            self._figure.canvas.draw()
        return np.asarray(self._figure.canvas.buffer_rgba())[..., :3].copy()

    def save(self, path: Path) -> Path:
        """Save as PNG, SVG or PDF."""
        return save_figure(self._figure, path, self._dpi, colours=None)

    def _build(self, panels: int, columns: int, top: int) -> tuple[Any, list[Any], list[Any]]:
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure

        width, height = self._size
        figure = Figure(figsize=(width / UNIT, height / UNIT), dpi=self._dpi)
        FigureCanvasAgg(figure)
        images, texts = [], []
        w, h = self._panel
        for number in range(panels):
            row, column = divmod(number, columns)
            upper = top + row * (h + HEAD)
            axes = figure.add_axes((column * w / width, 1 - (upper + HEAD + h) / height, w / width, h / height))
            axes.set_axis_off()
            images.append(axes.imshow(np.full((h, w, 3), 255, np.uint8), aspect="auto", interpolation="antialiased"))
            texts.append(figure.text((column * w + 12) / width, 1 - (upper + 7) / height, "", va="top", fontsize=9.5))
        return figure, images, texts

    def _add_bar(self, colours: ColourScale, label: str) -> None:
        from matplotlib.cm import ScalarMappable
        from matplotlib.colors import Normalize

        width, height = self._size
        tall = min(0.78 * height, 420.0) / height
        axes = self._figure.add_axes((1 - (BAR - 18) / width, 0.5 - tall / 2, 14 / width, tall))
        bar = self._figure.colorbar(ScalarMappable(Normalize(colours.low, colours.high), colours.colour_map), cax=axes)
        bar.set_label(label)
        bar.outline.set_linewidth(0.0)


def save_gif(pictures: Iterable[Picture], path: Path, seconds: float) -> Path:
    """An animation that repeats for ever; only what changes from frame to frame is stored, so all share one palette.

    Args:
        pictures: frames, shape (height, width, 3) each.
        path: file to write.
        seconds: how long each is shown; the format counts in hundredths.
    """
    from PIL import Image

    drawn = list(pictures)
    palette = _palette(drawn)
    frames = [Image.fromarray(picture).quantize(palette=palette, dither=Image.Dither.NONE) for picture in drawn]
    with replaced(path, "animation") as partial:
        options = {"save_all": True, "append_images": frames[1:], "loop": 0, "optimize": False}
        frames[0].save(partial, format="GIF", duration=max(20, 10 * round(100 * seconds)), **options)
    return path


def save_mp4(pictures: Iterable[Picture], path: Path, seconds: float) -> Path:
    """A film, where imageio-ffmpeg is installed.

    Raises:
        MissingExtraError: it is not.
    """
    try:
        import imageio_ffmpeg  # pyright: ignore[reportMissingImports]
        from imageio.v2 import get_writer  # pyright: ignore[reportMissingImports]
    except ImportError as error:
        raise MissingExtraError(
            f"animation '{path}': MP4 needs 'pip install imageio imageio-ffmpeg'; .gif needs nothing"
        ) from error
    del imageio_ffmpeg  # imageio finds it by itself; the import tells only that it is there
    with replaced(path, "animation") as partial, get_writer(partial, fps=1.0 / seconds, macro_block_size=2) as film:
        for picture in pictures:
            film.append_data(picture)  # pyright: ignore[reportAttributeAccessIssue] -- imageio's type of a writer is too wide
    return path


def _palette(pictures: Sequence[Picture]) -> Image:
    """A picture of one pixel with the 256 colours that suit all pictures best, pure white among them.

    Colours are weighted by the root of their area: by area alone, the bright end of the scale would be lost when few frames
    reach it.
    """
    from PIL import Image

    shown = np.linspace(0, len(pictures) - 1, min(len(pictures), SAMPLED)).round().astype(int)
    areas = np.zeros(1 << 18, np.int64)  # of each colour in six bits a channel
    for k in shown:
        red, green, blue = np.moveaxis(pictures[k] >> 2, -1, 0).astype(np.int32)
        areas += np.bincount((red << 12 | green << 6 | blue).reshape(-1), minlength=len(areas))
    present = np.flatnonzero(areas)
    colours = np.column_stack([present >> 12, present >> 6 & 63, present & 63])
    weighted = np.repeat((colours << 2) + 2, np.minimum(np.sqrt(areas[present]).astype(int), 60), axis=0).astype(np.uint8)
    found = Image.fromarray(weighted[None]).quantize(255, method=Image.Quantize.MEDIANCUT, dither=Image.Dither.NONE)
    entries = np.array(found.getpalette()[: 3 * 255]).reshape(-1, 3)  # type: ignore[index]  # the mode is P
    entries[entries.min(axis=1) > NEARLY_WHITE] = 255  # the white of the page
    palette = Image.new("P", (1, 1))
    palette.putpalette([255, 255, 255, *entries.reshape(-1).tolist()])
    return palette

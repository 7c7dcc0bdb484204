"""Shaded pictures and animations of deformed plates, coloured by a field, and of rigid bodies, in grey.

``picture`` and ``animation`` draw with PyVista where OpenGL works and with matplotlib everywhere else; both frame alike.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from lamella.arguments import FINITE, PATH, POSITIVE, TEXT, Kind, accepts, at_least, instance, optional
from lamella.errors import DeclarationError, ResultFileError
from lamella.io.modes import mode_frames, natural_amplitude
from lamella.result import Result
from lamella.roles import Floats
from lamella.shapes import Shapes
from lamella.viz.camera import Camera, fit_camera
from lamella.viz.compose import Composer, save_gif, save_mp4
from lamella.viz.fields import Snapshot, SurfaceSampler, scalar, select
from lamella.viz.renderer import Body, ColourScale, Renderer, RendererName, Sheet, make_renderer
from lamella.viz.solids import SolidSampler, SolidShot, drawable

LOAD_FACTOR, MODE_FREQUENCY = "load_factor", "frequency"
"""Signals that captions quote: of static solutions, and of natural modes."""

MOST_FITTED = 60
"""Frames looked at to fit the camera and the colours; more would not show."""

PICTURE_DPI, ANIMATION_DPI = 160, 100
"""Resolutions: a picture is for print, an animation for the screen."""

LEAST_WIDTH = 300
"""Pixels that a picture takes at least: its colour bar and what it is of."""

View = str | tuple[float, float, float]


@dataclass(frozen=True)
class Drawing:
    """Everything pictures of one result have in common."""

    result: Result
    sampler: SurfaceSampler
    solids: SolidSampler
    field: str
    scale: float
    per_element: int
    camera: Camera
    colours: ColourScale
    label: str

    def sheets(self, frame: int) -> list[Sheet]:
        """The plates a renderer draws of one frame."""
        field, component = select(self.field)
        return [_sheet(shot, scalar(field, component, shot), self.scale, self.per_element) for shot in self.sampler.at(frame)]

    def bodies(self, frame: int) -> list[Body]:
        """The rigid bodies a renderer draws of one frame."""
        return [Body(_moved_points(shot, self.scale), shot.faces, shot.edges) for shot in self.solids.at(frame)]

    def caption(self, frame: int) -> str:
        """Where a frame stands on the axis of the result."""
        at = float(self.result.frame_at[frame])
        if self.result.axis == "time":
            return f"t = {at:.4g} s"
        if self.result.axis == "mode":
            natural = MODE_FREQUENCY in self.result
            value = self._sampled(MODE_FREQUENCY if natural else LOAD_FACTOR, at)
            return f"Mode {at:.0f}: {value:.4g} Hz" if natural else f"Shape {at:.0f}: load factor {value:.4g}"
        factor = self._sampled(LOAD_FACTOR, at) if LOAD_FACTOR in self.result else at
        return f"load factor = {factor:.4g}"

    def _sampled(self, name: str, at: float) -> float:
        """A signal at the sample nearest to an axis value."""
        return float(self.result.samples(name)[int(np.argmin(np.abs(self.result.at - at)))])


def _is_place(value: object) -> bool:
    """Whether a value is a place on the axis of a result, or some."""
    if isinstance(value, (Sequence, np.ndarray)) and not isinstance(value, (str, bytes)):
        return len(value) > 0 and all(map(FINITE.accepts, value))
    return FINITE.accepts(value)


@accepts(
    result=instance("a result", Result),
    path=PATH,
    field=TEXT,
    at=optional(Kind(_is_place, "a finite number, or a list of one or more")),
    scale=FINITE,
    per_element=at_least(1),
    width=at_least(LEAST_WIDTH),
)
def picture(
    result: Result,
    path: str | Path,
    *,
    at: float | Sequence[float] | None = None,
    field: str = "displacement",
    scale: float = 1.0,
    view: View = "isometric",
    title: str = "",
    label: str = "",
    per_element: int = 6,
    width: int = 1760,
    renderer: RendererName = "auto",
) -> Path:
    """Draw the deformed plates and the rigid bodies at one or several times.

    Args:
        result: of a solution, or read from a file.
        path: PNG (or SVG, PDF) to write.
        at: time [s], load factor or point of a path, or several for panels side by side; the nearest frames are drawn; by
            default the last.
        field: name of :data:`lamella.viz.fields.FIELDS`, or a component such as ``displacement.z``.
        scale: factor on the displacement; 1 is true to scale.
        view: ``isometric``, ``front``, ``side``, ``top``, or the direction in which the camera looks.
        title: heading.
        label: of the colour bar, by default the field's name and unit.
        per_element: grid intervals along each side of an element.
        width: of the whole picture [pixel].
        renderer: ``auto``, ``pyvista`` or ``matplotlib``.

    Raises:
        DeclarationError: unknown field, view or renderer, or a result without frames or with nothing to draw.
        ResultFileError: the picture cannot be written.
    """
    frames = _frames_at(result, at)
    drawing = _prepare(result, field, scale, per_element, view, frames)
    bar, heading = label or drawing.label, title or _title(scale)
    composer = Composer(drawing.camera, drawing.colours, bar, len(frames), width, heading, PICTURE_DPI)
    with _drawing(drawing, composer, renderer) as painter:
        drawn = [painter.draw(drawing.sheets(frame), drawing.bodies(frame)) for frame in frames]
        composer.show(drawn, [drawing.caption(frame) for frame in frames])
    return composer.save(Path(path))


@accepts(modes=instance("natural modes or buckling shapes", Shapes), path=PATH, count=at_least(1))
def mode_sheet(
    modes: Shapes,
    path: str | Path,
    *,
    count: int = 9,
    view: View = "isometric",
    title: str | None = None,
    width: int = 1760,
    renderer: RendererName = "auto",
) -> Path:
    """Draw the first shapes side by side, coloured by displacement, with number and frequency or load factor.

    Args:
        modes: what was computed.
        path: PNG (or SVG, PDF) to write.
        count: largest number of shapes.
        view, title, width, renderer: as in :func:`picture`.

    Raises:
        DeclarationError: nothing to draw in the model, or an unknown view or renderer.
        ResultFileError: the picture cannot be written.
    """
    scale = natural_amplitude(modes)
    shapes = mode_frames(modes, 1.0, count)
    shown = {"at": shapes.frame_at.tolist(), "label": "Displacement / its largest [–]", "title": title or modes.title}
    return picture(shapes, path, scale=scale, view=view, width=width, renderer=renderer, **shown)


@accepts(
    result=instance("a result", Result),
    path=PATH,
    field=TEXT,
    scale=FINITE,
    per_element=at_least(1),
    width=at_least(LEAST_WIDTH),
    frames=at_least(1),
    seconds=optional(POSITIVE),
)
def animation(
    result: Result,
    path: str | Path,
    *,
    field: str = "displacement",
    scale: float = 1.0,
    view: View = "isometric",
    title: str = "",
    per_element: int = 4,
    width: int = 720,
    frames: int = 48,
    seconds: float | None = None,
    renderer: RendererName = "auto",
) -> Path:
    """Animate the deformed plates and the rigid bodies: a GIF, or an MP4 where imageio-ffmpeg is installed.

    Args:
        result: of a solution, or read from a file.
        path: ``*.gif`` or ``*.mp4``.
        frames: largest number of frames, spread evenly.
        seconds: how long it lasts; by default 12 frames a second, repeated for ever.
        field, scale, view, title, per_element, width, renderer: as in :func:`picture`.

    Raises:
        DeclarationError: as :func:`picture`.
        MissingExtraError: an MP4 is asked for without imageio-ffmpeg.
        ResultFileError: the animation cannot be written.
    """
    path = Path(path)
    if path.suffix.lower() not in (".gif", ".mp4"):
        raise ResultFileError(f"animation '{path}': unknown suffix '{path.suffix}'; accepted are .gif and .mp4")
    _refuse_empty(result)
    chosen = _spread(len(result.frame_at), frames)
    drawing = _prepare(result, field, scale, per_element, view, chosen)
    composer = Composer(drawing.camera, drawing.colours, drawing.label, 1, width, title or _title(scale), ANIMATION_DPI)
    with _drawing(drawing, composer, renderer) as painter:

        def pictures() -> Iterator[np.ndarray]:
            for frame in chosen:
                composer.show([painter.draw(drawing.sheets(frame), drawing.bodies(frame))], [drawing.caption(frame)])
                yield composer.pixels()

        each = (seconds or len(chosen) / 12.0) / len(chosen)
        return save_gif(pictures(), path, each) if path.suffix.lower() == ".gif" else save_mp4(pictures(), path, each)


class _drawing:  # noqa: N801 -- used as a statement: with _drawing(...)
    """A renderer for the panels of a composer, closed at the end."""

    def __init__(self, drawing: Drawing, composer: Composer, name: RendererName) -> None:
        self.renderer = make_renderer(name, drawing.camera, drawing.colours, composer.panel)

    def __enter__(self) -> Renderer:
        return self.renderer

    def __exit__(self, *_: object) -> None:
        self.renderer.close()


def _prepare(result: Result, field: str, scale: float, per_element: int, view: View, shown: Sequence[int]) -> Drawing:
    """Fit the camera to all frames and the colours to those shown."""
    chosen, component = select(field)
    fitted = sorted({*_spread(len(result.frame_at), MOST_FITTED), *shown})
    coarse, solids, points, low, high = SurfaceSampler(result, 2), SolidSampler(result), [], [], []
    for frame in fitted:
        for shot in coarse.at(frame):
            points += [_moved(shot, scale).reshape(-1, 3), shot.reference.r.reshape(-1, 3)]
            if frame in shown:
                values = scalar(chosen, component, shot)
                low.append(np.nanmin(values) if np.isfinite(values).any() else 0.0)
                high.append(np.nanmax(values) if np.isfinite(values).any() else 0.0)
        points += [_moved_points(shot, scale) for shot in solids.at(frame)]
    camera = fit_camera(np.concatenate(points), view)
    name = chosen.title + (f", {chosen.labels[component]}" if component is not None else "")
    unit = "" if chosen.unit == "1" else f" [{chosen.unit}]"
    return Drawing(
        result,
        SurfaceSampler(result, per_element),
        solids,
        field,
        scale,
        per_element,
        camera,
        _colour_scale(min(low, default=0.0), max(high, default=0.0)),
        name + unit if result.model.plates else "",
    )


def _colour_scale(low: float, high: float) -> ColourScale:
    """From zero for what has one sign, symmetric with a neutral middle for what has two."""
    largest = max(abs(low), abs(high))
    if largest == 0.0:
        return ColourScale("viridis", 0.0, 1.0)
    if low < -1e-3 * largest and high > 1e-3 * largest:
        return ColourScale("RdBu_r", -largest, largest)
    return ColourScale("viridis", 0.0, high) if high > -low else ColourScale("viridis_r", low, 0.0)


def _sheet(shot: Snapshot, values: Floats, scale: float, per_element: int) -> Sheet:
    points = _moved(shot, scale)
    rows, columns = range(0, points.shape[0], per_element), range(0, points.shape[1], per_element)
    reference = shot.reference.r
    along_x, along_y = shot.plate.loops  # a surface that is closed has no edges where it begins
    outlines = [] if along_y else [reference[0], reference[-1]]
    outlines += [] if along_x else [reference[:, 0], reference[:, -1]]
    return Sheet(points, values, [points[j] for j in rows] + [points[:, i] for i in columns], outlines)


def _moved(shot: Snapshot, scale: float) -> Floats:
    return shot.reference.r + scale * shot.displacement


def _moved_points(shot: SolidShot, scale: float) -> Floats:
    return shot.reference + scale * shot.displacement


def _frames_at(result: Result, at: float | Sequence[float] | None) -> list[int]:
    _refuse_empty(result)
    if at is None:
        return [len(result.frame_at) - 1]
    return [int(np.argmin(np.abs(result.frame_at - value))) for value in np.atleast_1d(np.asarray(at, float))]


def _refuse_empty(result: Result) -> None:
    if not len(result.frame_at):
        raise DeclarationError("picture", "the result has no frame", "accepted is a result that got beyond its start")
    if not drawable(result.model):
        raise DeclarationError("picture", "the model has nothing to draw", "accepted is one with a plate, or a body with a shape")


def _spread(there: int, most: int) -> list[int]:
    """At most ``most`` of the frames, evenly spread, first and last included."""
    return sorted({int(k) for k in np.round(np.linspace(0, there - 1, min(there, max(most, 1))))})


def _title(scale: float) -> str:
    return "" if scale == 1.0 else f"displacement × {scale:g}"

"""One style for all figures: size, type, colours and how they are saved."""

from __future__ import annotations

import io
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from lamella.arguments import PATH, accepts
from lamella.errors import ResultFileError
from lamella.whole import replaced

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

COLOURS = ("#1f5fa8", "#d1495b", "#2a9d6f", "#e09f3e", "#7b5ea7", "#3aa6c1", "#8c6d46", "#6b7280")
"""Line colours; neighbours differ in lightness too, for prints in grey and for colour-blind readers."""

COMPONENT_COLOURS = {"x": "#d1495b", "y": "#2a9d6f", "z": "#1f5fa8"}
"""The components of vectors are red, green and blue, as axes are in most viewers."""

DASHES: tuple[Any, ...] = ("-", (0, (5, 1.5)), (0, (1.2, 1.2)), (0, (6, 1.5, 1.2, 1.5)))
INK, FAINT = "#1d2733", "#d8dee6"
COLOUR_MAP = "viridis"
LONG_LABEL = 24
"""Number of letters from which legends stand below the axes."""

WIDTH = 7.2
"""Width of a figure [inch], a text column of a report."""

RC: Any = {
    "font.family": "DejaVu Sans",
    "font.size": 9.5,
    "axes.titlesize": 10.5,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.titlepad": 8.0,
    "axes.labelsize": 9.5,
    "axes.labelcolor": INK,
    "axes.edgecolor": "#8a95a3",
    "axes.linewidth": 0.8,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.formatter.useoffset": False,
    "axes.formatter.limits": (-3, 4),
    "axes.formatter.use_mathtext": True,
    "grid.color": FAINT,
    "grid.linewidth": 0.6,
    "text.color": INK,
    "xtick.color": "#4b5563",
    "ytick.color": "#4b5563",
    "xtick.labelsize": 8.5,
    "ytick.labelsize": 8.5,
    "xtick.direction": "out",
    "lines.linewidth": 1.5,
    "lines.solid_capstyle": "round",
    "legend.frameon": False,
    "legend.fontsize": 8.5,
    "figure.dpi": 110,
    "figure.facecolor": "white",
    "savefig.dpi": 160,
    "svg.fonttype": "path",
    "svg.hashsalt": "lamella",
    "path.simplify_threshold": 0.2,
}


@contextmanager
def styled() -> Iterator[None]:
    """Figures made within have the common style; nothing global is left changed."""
    import matplotlib

    with matplotlib.rc_context(RC):
        yield


def new_figure(height: float, width: float = WIDTH) -> Figure:
    """An empty figure [inch], drawn without a screen and without pyplot's global state."""
    from matplotlib.figure import Figure

    return Figure(figsize=(width, height), layout="constrained")


def place_legend(axes: Axes) -> None:
    """The legend where it hides no data: to the right of the axes, or below them when its texts are long."""
    handles, labels = axes.get_legend_handles_labels()
    if max(map(len, labels), default=0) <= LONG_LABEL:
        axes.legend(handles, labels, loc="upper left", bbox_to_anchor=(1.01, 1.02), borderaxespad=0.0)
        return
    figure = axes.get_figure(root=True)
    assert figure is not None
    columns = max(1, min(len(labels), 92 // (max(map(len, labels)) + 6)))
    figure.legend(handles, labels, loc="outside lower center", ncols=columns)


@accepts(path=PATH)
def save_figure(figure: Figure, path: str | Path, dpi: int = RC["savefig.dpi"], *, colours: int | None = 256) -> Path:
    """Save as PNG, SVG or PDF, by the suffix; the same figure gives the same bytes.

    Args:
        figure: to be saved.
        path: file to write.
        dpi: resolution of a PNG [1/inch].
        colours: largest number of colours of a PNG, which makes that of a plot a third as large; None keeps all, for shading.

    Raises:
        ResultFileError: the suffix is not known or the file cannot be written.
    """
    path = Path(path)
    formats: dict[str, dict[str, Any]] = {".png": {}, ".svg": {"Date": None}, ".pdf": {"CreationDate": None}}
    kind = path.suffix.lower()
    if kind not in formats:
        raise ResultFileError(f"figure '{path}': unknown suffix '{path.suffix}'; accepted are {', '.join(formats)}")
    drawn = io.BytesIO()  # where a disk is full, the writer of PDF fails with what hides the cause
    with styled():
        if kind == ".png":
            _save_png(figure, drawn, dpi, colours)
        else:
            figure.savefig(drawn, format=kind[1:], metadata=formats[kind])
    with replaced(path, "figure") as partial:
        partial.write_bytes(drawn.getvalue())
    return path


def _save_png(figure: Figure, file: io.BytesIO, dpi: int, colours: int | None) -> None:
    from PIL import Image

    drawn = io.BytesIO()
    figure.savefig(drawn, format="rgba", dpi=dpi)
    width, height = (int(round(inches * dpi, 6)) for inches in figure.get_size_inches())
    picture = Image.frombytes("RGBA", (width, height), drawn.getvalue()).convert("RGB")
    if colours is not None:
        picture = picture.quantize(colours, method=Image.Quantize.MEDIANCUT, dither=Image.Dither.NONE)
    picture.save(file, format="PNG", optimize=True, dpi=(dpi, dpi))

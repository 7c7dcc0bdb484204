"""Draw what verification cases show: curves and orders as SVG, shapes as WebP, each as a data URI."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from lamella.modal import Modes
from lamella.verification.picture import Curves, Orders, Picture, Series, Shape
from lamella.viz.page import embedded
from lamella.viz.plots import Curve, plot_convergence, plot_curves

if TYPE_CHECKING:
    from collections.abc import Mapping

SHAPE_WIDTH = 960
"""Width of a shape [pixel]; twice the width it is shown at."""

QUALITY = 82
"""Of WebP; shading compresses well and its lines stay sharp."""


def drawn(picture: Picture) -> str:
    """A picture as a data URI.

    Raises:
        LamellaError: a field or view that does not exist, or a result with nothing to draw.
    """
    if isinstance(picture, Curves):
        return embedded(
            plot_curves(
                _arrays(picture.computed),
                picture.x_label,
                picture.y_label,
                points=_arrays(picture.reference),
                title=picture.title,
                joined=picture.joined,
                log=picture.log,
            )
        )
    if isinstance(picture, Orders):
        errors, labels = _arrays(picture.errors), (picture.x_label, picture.y_label)
        return embedded(plot_convergence(errors, *labels, title=picture.title, orders=picture.expected))
    return _shaded(picture)


def _arrays(series: Mapping[str, Series]) -> dict[str, Curve]:
    return {label: (np.asarray(x, float), np.asarray(y, float)) for label, (x, y) in series.items()}


def _shaded(shape: Shape) -> str:
    from PIL import Image

    from lamella.viz.scene import mode_sheet, picture

    with tempfile.TemporaryDirectory() as folder:
        path, small = Path(folder) / "shape.png", Path(folder) / "shape.webp"
        if isinstance(shape.of, Modes):
            mode_sheet(shape.of, path, count=shape.shapes, view=shape.view, title=shape.title, width=SHAPE_WIDTH)
        else:
            given = {"at": shape.at, "field": shape.field, "scale": shape.scale, "view": shape.view, "title": shape.title}
            picture(shape.of, path, width=SHAPE_WIDTH, **given)
        with Image.open(path) as image:
            image.convert("RGB").save(small, quality=QUALITY, method=6)
        return embedded(small)

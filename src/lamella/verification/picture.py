"""What a verification case shows beside its checks: data of pictures, drawn only when a manual is asked for."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import ArrayLike

from lamella.errors import DeclarationError

if TYPE_CHECKING:
    from lamella.modal import Modes
    from lamella.result import Result

Series = tuple[ArrayLike, ArrayLike]
"""Abscissae and values, of the same length."""


@dataclass(frozen=True)
class Curves:
    """Computed values as lines and their references as open markers, in one set of axes.

    Args:
        title: heading.
        x_label: horizontal axis with unit, for example ``Load factor [–]``.
        y_label: vertical axis with unit, for example ``Displacement [m]``.
        computed: label to (x, y).
        reference: label to (x, y); published points, or a closed form at any number of points.
        joined: False draws computed values as dots, for abscissae that are numbers of something, such as modes.
        log: axes that are logarithmic: ``x``, ``y`` or ``xy``.

    Raises:
        DeclarationError: nothing to draw, an empty series, or one of unequal lengths.
    """

    title: str
    x_label: str
    y_label: str
    computed: Mapping[str, Series]
    reference: Mapping[str, Series] = field(default_factory=dict)
    joined: bool = True
    log: Literal["", "x", "y", "xy"] = ""

    def __post_init__(self) -> None:
        _refuse_unequal(self, {**self.computed, **self.reference})


@dataclass(frozen=True)
class Orders:
    """Errors over the step or element size, both logarithmic, with the order observed.

    Args:
        title: heading.
        x_label: horizontal axis with unit, for example ``Time step [s]``.
        errors: label to (sizes, errors), errors above zero.
        expected: orders drawn as thin lines to compare with.
        y_label: vertical axis with unit.

    Raises:
        DeclarationError: nothing to draw, a series of unequal lengths, or a value that has no logarithm.
    """

    title: str
    x_label: str
    errors: Mapping[str, Series]
    expected: Sequence[int] = ()
    y_label: str = "Relative error [–]"

    def __post_init__(self) -> None:
        _refuse_unequal(self, self.errors)
        for label, (size, error) in self.errors.items():
            if not (np.all(np.asarray(size) > 0) and np.all(np.asarray(error) > 0)):
                raise DeclarationError(f"Orders '{self.title}'", f"'{label}' is not above zero", "accepted are values above zero")


@dataclass(frozen=True)
class Shape:
    """Deformed plates and rigid bodies, or the shapes of natural modes.

    Args:
        title: heading.
        of: result of a solution, or natural modes.
        at: time [s] or load factor, or several for panels side by side; by default the last.
        field: what the colours show, a name of :data:`lamella.viz.fields.FIELDS`, or a component such as ``displacement.z``.
        scale: factor on the displacement; 1 is true to scale.
        view: ``isometric``, ``front``, ``side``, ``top``, or the direction in which the camera looks.
        shapes: largest number of modes drawn; ``at``, ``field`` and ``scale`` are for results.
    """

    title: str
    of: Result | Modes
    at: float | Sequence[float] | None = None
    field: str = "displacement"
    scale: float = 1.0
    view: str | tuple[float, float, float] = "isometric"
    shapes: int = 6


Picture = Curves | Orders | Shape


def _refuse_unequal(picture: Curves | Orders, series: Mapping[str, Series]) -> None:
    item = f"{type(picture).__name__} '{picture.title}'"
    if not series:
        raise DeclarationError(item, "nothing to draw", "accepted is at least one series (x, y)")
    for label, (x, y) in series.items():
        shapes = np.shape(x), np.shape(y)
        if len(shapes[0]) != 1 or shapes[0] != shapes[1] or shapes[0] == (0,):
            raise DeclarationError(
                item, f"'{label}' has x of shape {shapes[0]} and y of shape {shapes[1]}", "accepted are equal (n,)"
            )

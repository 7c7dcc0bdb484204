"""The surface of a belt that lies around pulleys: straight strands that touch circles, and the arcs between them."""

from __future__ import annotations

from functools import cached_property
from typing import Literal

import numpy as np

from lamella.declaration import declaration
from lamella.errors import DeclarationError
from lamella.roles import Floats
from lamella.surface.base import Surface, SurfacePoints
from lamella.units import Length, Thickness

Pulley = tuple[Length, Length, Thickness]


@declaration
class PulleySurface(Surface):
    """A closed belt around two or more parallel pulleys: x is the arc length along it, y the height along their axis z.

    It runs counter-clockwise about z, and begins where it leaves the first pulley; the normal points outward. From the pulley
    (c_i, r_i) to the next one, at the distance d in the direction e, a strand leaves both in the direction n,

        n . e = (r_i - r_j) / d,    from c_i + r_i n to c_j + r_j n.

    The curvature jumps where a strand ends, so that nodes should lie there.

    Args:
        pulleys: centre and radius (x, y, r) of each circle, in the order in which the belt meets them counter-clockwise [m]; the
            radius is that of the belt's mid-surface. The belt touches all of them.
        width: of the belt [m].

    Raises:
        DeclarationError: fewer than two pulleys, pulleys that overlap or are not touched in this order.
    """

    pulleys: tuple[Pulley, ...]
    width: Thickness
    kind: Literal["pulleys"] = "pulleys"

    def __post_init__(self) -> None:
        """Refuse what no belt goes around."""
        if len(self.pulleys) < 2:
            raise DeclarationError("PulleySurface", f"{len(self.pulleys)} pulleys", "accepted are two or more")
        centres, radii = self._circles
        for i, c in enumerate(centres):
            for j in range(i):
                apart, least = float(np.linalg.norm(c - centres[j])), float(radii[i] + radii[j])
                if apart <= least:
                    raise DeclarationError(
                        "PulleySurface",
                        f"pulleys {j + 1} and {i + 1} overlap: {apart:.4g} m from centre to centre",
                        f"accepted is more than the sum of their radii, {least:.4g} m",
                    )
        turns = self._arcs[1]
        if abs(turns.sum() - 2.0 * np.pi) > 1e-9:
            raise DeclarationError(
                "PulleySurface",
                f"the belt wraps its pulleys by {', '.join(f'{turn:.0f}' for turn in np.degrees(turns))} deg",
                "accepted are pulleys that it touches from inside, in counter-clockwise order: 360 deg together",
            )

    @cached_property
    def _circles(self) -> tuple[Floats, Floats]:
        """Centres, shape (n, 2), and radii."""
        table = np.array(self.pulleys, float)
        return table[:, :2], table[:, 2]

    @cached_property
    def _strands(self) -> tuple[Floats, Floats]:
        """Angle of the normal of the strand that leaves each pulley [rad], and its length [m]."""
        centres, radii = self._circles
        to = np.roll(centres, -1, axis=0) - centres
        d, step = np.linalg.norm(to, axis=1), radii - np.roll(radii, -1)
        return np.arctan2(to[:, 1], to[:, 0]) - np.arccos(step / d), np.sqrt(d**2 - step**2)

    @cached_property
    def _arcs(self) -> tuple[Floats, Floats]:
        """Angle at which each pulley is met, and by which it is wrapped [rad]."""
        leaves = self._strands[0]
        meets = np.roll(leaves, 1)
        return meets, np.mod(leaves - meets, 2.0 * np.pi)

    @cached_property
    def _starts(self) -> Floats:
        """Arc length at the beginning of each strand and of the arc that follows it, and at the end, shape (2 n + 1,)."""
        turns, radii = np.roll(self._arcs[1], -1), np.roll(self._circles[1], -1)
        return np.concatenate([[0.0], np.cumsum(np.stack([self._strands[1], radii * turns], axis=1))])

    @property
    def size(self) -> tuple[float, float]:
        return float(self._starts[-1]), self.width

    @property
    def loops(self) -> tuple[bool, bool]:
        return (True, False)

    def at(self, x: Floats, y: Floats) -> SurfacePoints:
        count = len(self.pulleys)
        x = np.mod(x, self._starts[-1])
        piece = np.clip(np.searchsorted(self._starts, x, side="right") - 1, 0, 2 * count - 1)
        curved, here = piece % 2 == 1, (piece // 2 + piece % 2) % count  # a strand belongs to the pulley it leaves
        s = x - self._starts[piece]
        centres, radii = self._circles
        angle = np.where(curved, self._arcs[0][here] + s / radii[here], self._strands[0][here])
        c, d, zero = np.cos(angle), np.sin(angle), np.zeros_like(x)
        ahead = np.where(curved, 0.0, s)
        r = np.stack([centres[here, 0] + radii[here] * c - ahead * d, centres[here, 1] + radii[here] * d + ahead * c, y], axis=1)
        return SurfacePoints(
            r, np.stack([-d, c, zero], axis=1), np.stack([zero, zero, zero + 1.0], axis=1), np.stack([zero] * 3, axis=1)
        )

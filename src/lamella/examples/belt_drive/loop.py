"""What the belt and the pulleys feel around the loop: tension, pressure, friction and slip over the place in space."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lamella.contact.block import ContactBlock
from lamella.result import Result
from lamella.roles import Floats

R, APART, WIDTH = 0.1, 0.1 * np.pi, 0.08
LENGTH = 2 * APART + 2 * np.pi * R
BINS = 240
"""Intervals around the loop: 60 of each strand and each arc."""
MARGIN = 0.04
"""At the ends of strands, where the belt lifts off the pulleys [m]."""


def place(r: Floats) -> Floats:
    """Distance [m] around the loop, along the belt's motion, of points (..., 3), from where the belt leaves pulley 1.

    First the slack strand, below; then pulley 2, the tight strand, and pulley 1.
    """
    x, y = r[..., 0], r[..., 1]
    right = APART + R * np.mod(np.arctan2(y, x - APART) + 0.5 * np.pi, 2 * np.pi)
    left = 2 * APART + np.pi * R + R * np.mod(np.arctan2(y, x) - 0.5 * np.pi, 2 * np.pi)
    strand = np.where(y < 0.0, x, 2 * APART + np.pi * R - x)
    return np.where(x > APART, right, np.where(x < 0.0, left, strand))


@dataclass(frozen=True)
class Loop:
    """Means over time and width in equal intervals around the loop, shapes (BINS,).

    Args:
        s: place of their middles [m].
        tension: of the whole width [N].
        pressure: [Pa].
        traction: friction on the belt along its motion [Pa].
        slip: speed of the belt against the pulley, along its motion; NaN where it touches none [m/s].
    """

    s: Floats
    tension: Floats
    pressure: Floats
    traction: Floats
    slip: Floats

    def arc(self, pulley: int) -> np.ndarray:
        """Numbers of the intervals on a pulley, in the order in which the belt passes them."""
        return np.arange(BINS // 4, BINS // 2) if pulley == 2 else np.arange(3 * BINS // 4, BINS)


def tensions(run: Result, frame: int) -> tuple[Floats, Floats]:
    """Places [m] and tensions of the whole width [N] along the belt: force of the stretched section, without damping.

    The membrane force N does its work on Green's strain, so that the tension is N times the stretch.
    """
    sample = run.plate("belt", frame, 7)
    force = sample.section_forces()[..., 0]
    return place(sample.r)[0, :-1], (WIDTH * force * stretch(run, sample.strains[..., 0])).mean(axis=0)[:-1]


def stretch(run: Result, strain: Floats) -> Floats:
    """Length over length at the start, from Green's strain with the prestrain."""
    prestrain = run.model.plates[0].section.prestrain
    return np.sqrt(1.0 + 2.0 * (strain - (0.0 if prestrain is None else prestrain[0])))


def strands(run: Result, frame: int) -> tuple[float, float]:
    """Tensions of the tight and of the slack strand [N]."""
    s, T = tensions(run, frame)
    tight = (s > APART + np.pi * R + MARGIN) & (s < 2 * APART + np.pi * R - MARGIN)
    slack = (s > MARGIN) & (s < APART - MARGIN)
    return float(T[tight].mean()), float(T[slack].mean())


def loop(run: Result, frames: list[int]) -> Loop:
    """Means over some frames."""
    blocks = [block for block in run.model.forces if isinstance(block, ContactBlock)]
    sums, counts = np.zeros((4, BINS)), np.zeros((3, BINS))
    for frame in frames:
        s, T = tensions(run, frame)
        sums[0] += _binned(s, T)
        counts[0] += _binned(s, np.ones_like(T))
        q, v = run.frame_q[frame], run.frame_v[frame]
        r, along = _points(run, frame, blocks[0])
        s = place(r)
        fields = [block.field(q, v) for block in blocks]
        pressure, traction, slip = (
            np.sum([getattr(field, name) for field in fields], axis=0) for name in ("pressure", "traction", "slip")
        )
        touching = np.sum([field.pressure > 0.0 for field in fields], axis=0)
        for row, values in enumerate((pressure, np.sum(traction * along, axis=-1), np.sum(slip * along, axis=-1)), 1):
            sums[row] += _binned(s, values)
        counts[1] += _binned(s, np.ones_like(s))
        counts[2] += _binned(s, touching)
    with np.errstate(invalid="ignore", divide="ignore"):
        means = [sums[0] / counts[0], sums[1] / counts[1], sums[2] / counts[1], sums[3] / counts[2]]
    return Loop((np.arange(BINS) + 0.5) * LENGTH / BINS, *means)


def _binned(s: Floats, values: Floats) -> Floats:
    """Sums of values in equal intervals around the loop."""
    number = np.minimum((s / LENGTH * BINS).astype(int), BINS - 1)
    return np.asarray(np.bincount(number.reshape(-1), values.reshape(-1).astype(float), BINS), float)


def _points(run: Result, frame: int, block: ContactBlock) -> tuple[Floats, Floats]:
    """Positions of the points of contact, and unit vectors along the belt there, shapes (n_element, n_point, 3)."""
    mesh, n = run.model.plates[0], round(np.sqrt(block.sheet.n_point))
    vectors = run.frame_q[frame][mesh.coords].reshape(len(mesh.coords), -1, 3) * mesh.scale[:, ::3, None]
    middle = (np.arange(n) + 0.5) / n
    S, S_xi = mesh.element.shape(np.tile(middle, n), np.repeat(middle, n))[:2]
    r, r_xi = np.einsum("pa,eac->epc", S, vectors), np.einsum("pa,eac->epc", S_xi, vectors)
    return r, r_xi / np.linalg.norm(r_xi, axis=-1, keepdims=True)

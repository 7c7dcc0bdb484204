"""How far published points of a diagram lie beside a computed curve."""

from __future__ import annotations

import numpy as np
from scipy.interpolate import CubicSpline

from lamella.roles import Floats


def distances(points: Floats, curve: Floats) -> Floats:
    """Distances (n,) of points (2, n) from the cubic spline over the length through the nodes (2, m) of a curve.

    Both are in the units of the diagram in which they are measured: each axis over its largest value, or logarithms, in which a
    distance is a relative error shared by abscissa and ordinate.
    """
    length = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(curve)))])
    fine = CubicSpline(length, curve, axis=1)(np.linspace(0.0, length[-1], 200 * curve.shape[1]))
    return np.linalg.norm(points[:, :, None] - fine[:, None, :], axis=0).min(axis=1)

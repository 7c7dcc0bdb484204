"""Small meshes of any element on flat and curved reference surfaces, and dense matrices of blocks, for the tests of elements."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

EIGHTH_ORDER = {1: 4 / 5, 2: -1 / 5, 3: 4 / 105, 4: -1 / 280}


def flat(x, y):
    return {"r": (x, y, 0.0), "r_x": (1.0, 0.0, 0.0), "r_y": (0.0, 1.0, 0.0), "r_xy": (0.0, 0.0, 0.0)}


def cylinder(x, y, radius=1.3):
    s, c = np.sin(x / radius), np.cos(x / radius)
    return {"r": (radius * s, y, radius * (1 - c)), "r_x": (c, 0.0, s), "r_y": (0.0, 1.0, 0.0), "r_xy": (0.0, 0.0, 0.0)}


def twisted(x, y):
    """A skewed and twisted surface: not orthonormal parameters, curvature in every direction."""
    return {
        "r": (1.1 * x + 0.3 * y, 0.9 * y - 0.1 * x * y, 0.4 * x * y + 0.2 * x * x - 0.3 * y * y),
        "r_x": (1.1, -0.1 * y, 0.4 * y + 0.4 * x),
        "r_y": (0.3, 0.9 - 0.1 * x, 0.4 * x - 0.6 * y),
        "r_xy": (0.0, -0.1, 0.4),
    }


SURFACES = {"flat": flat, "cylinder": cylinder, "twisted": twisted}


@dataclass
class Patch:
    """Coordinate numbers (n_element, n), scale and reference of each element, all node vectors and which are positions."""

    element: object
    coords: np.ndarray
    scale: np.ndarray
    reference: np.ndarray
    rest: np.ndarray
    is_position: np.ndarray
    nodes: list[tuple[float, float]]

    @property
    def tables(self):
        return self.coords, self.scale, self.reference


def patch(element, xs, ys, surface=flat):
    """Rectangles between the lines xs and ys; nodes with x fastest."""
    per_node = element.vectors_per_node
    nodes = [(x, y) for y in ys for x in xs]
    rest = np.array([[surface(x, y)[name] for name in element.vector_names] for x, y in nodes]).reshape(-1, 3)
    coords, scale = [], []
    for j in range(len(ys) - 1):
        for i in range(len(xs) - 1):
            corners = [(j + dj) * len(xs) + i + di for di, dj in element.nodes]
            vectors = (per_node * np.array(corners)[:, None] + np.arange(per_node)).reshape(-1)
            coords.append((3 * vectors[:, None] + np.arange(3)).reshape(-1))
            scale.append(np.repeat(element.scales(xs[i + 1] - xs[i], ys[j + 1] - ys[j]), 3))
    coords = np.array(coords)
    q = rest.reshape(-1)
    return Patch(element, coords, np.array(scale), q[coords], q, np.tile(element.is_position, len(nodes)), nodes)


def gathered_force(block, q, v=None):
    f = np.full(len(block.f_coords), np.nan)
    block.force(0.0, q, q if v is None else v, f)
    return _summed(block.f_coords, f * block.f_scale, len(q))


def _summed(coords, values, n):
    out = np.zeros(n)
    used = coords >= 0
    np.add.at(out, coords[used], values[used])
    return out


def dense(block, q, v=None, alpha_q=1.0, alpha_v=0.0, q_previous=None):
    """Force (n,) and tangent (n, n)."""
    n = len(q)
    f, k = np.full(len(block.f_coords), np.nan), np.full(len(block.k_rows), np.nan)
    block.force_tangent(0.0, q, q if v is None else v, alpha_q, alpha_v, q if q_previous is None else q_previous, f, k)
    used = block.k_rows >= 0
    K = np.zeros((n, n))
    np.add.at(K, (block.k_rows[used], block.k_cols[used]), (k * block.k_scale)[used])
    if block.symmetry == "symmetric":
        K = K + K.T - np.diag(np.diag(K))
    return _summed(block.f_coords, f * block.f_scale, n), K


def derivative(function, step):
    """d function(h)/dh at 0 by central differences of order eight."""
    return sum(w * (function(k * step) - function(-k * step)) for k, w in EIGHTH_ORDER.items()) / step


def turned(vectors, is_position, rotation, translation):
    """Rigid motion of all node vectors, flat."""
    moved = vectors.reshape(-1, 3) @ rotation.T
    moved[is_position] += translation
    return moved.reshape(-1)


def random_rotation(rng):
    R = np.linalg.qr(rng.standard_normal((3, 3)))[0]
    return R * np.sign(np.linalg.det(R))


def section(rng):
    """An unsymmetric laminate: positive definite, every entry of A, B, D."""
    root = rng.standard_normal((6, 6))
    return root @ root.T + np.eye(6)

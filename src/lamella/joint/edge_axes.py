"""Directions along and across an edge and normal to its surface, at each of its nodes in the reference configuration."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lamella.body.mesh import PlateMesh
from lamella.body.plate import Edge
from lamella.roles import Floats


@dataclass(frozen=True)
class EdgeAxes:
    """Unit vectors at a node of an edge.

    Args:
        s: along the edge, R_s / |R_s|.
        t: across it in the tangent plane, s x n.
        n: normal of the surface, R_x x R_y over its length.
        n_s: derivative of n by the parameter along the edge [1/m]; exactly zero where it is rounding.
    """

    s: Floats
    t: Floats
    n: Floats
    n_s: Floats


def edge_axes(mesh: PlateMesh, edge: Edge, initial: Floats) -> dict[int, EdgeAxes]:
    """The axes at the nodes of an edge, by node number.

    With R_s and R_t along and across the edge the normal is n = +-R_s x R_t / J, so

        J n_s = (I - n n^T) (+-)(R_ss x R_t + R_s x R_st).

    The second derivative R_ss of the cubic edge jumps at a node by a term of the order of the element's length squared; the mean
    of both sides is taken. R_st of an element without r_xy is the difference of R_t between nodes.

    Args:
        mesh: the plate.
        edge: its edge.
        initial: all coordinate vectors in the reference configuration, shape (n_vectors, 3).
    """
    nodes = [int(node) for node in mesh.edge_nodes(edge.side)]
    along, across = mesh.edge_slope(edge.side)
    r, r_s, r_t = (initial[[mesh.vector(node, name) for node in nodes]] for name in ("r", along, across))
    length = mesh.lx if along == "r_x" else mesh.ly
    twists = [mesh.vector(node, "r_xy") for node in nodes] if "r_xy" in mesh.element.vector_names else None
    r_st = np.gradient(r_t, length, axis=0) if twists is None else initial[twists]
    sides: dict[int, list[Floats]] = {}
    for k, chord in enumerate(np.diff(r, axis=0)):
        at_start = 6 * chord / length**2 - (4 * r_s[k] + 2 * r_s[k + 1]) / length
        at_end = -6 * chord / length**2 + (2 * r_s[k] + 4 * r_s[k + 1]) / length
        sides.setdefault(nodes[k], []).append(at_start)
        sides.setdefault(nodes[k + 1], []).append(at_end)
    r_ss = np.array([np.mean(sides[node], axis=0) for node in nodes])
    sign = 1.0 if along == "r_x" else -1.0
    normal = sign * np.cross(r_s, r_t)
    change = sign * (np.cross(r_ss, r_t) + np.cross(r_s, r_st))
    s, n, J = _unit(r_s), _unit(normal), np.linalg.norm(normal, axis=1, keepdims=True)
    n_s = (change - np.sum(change * n, axis=1, keepdims=True) * n) / J
    n_s[np.linalg.norm(n_s, axis=1) * length * len(sides) < 1e-9] = 0.0  # an edge whose normal turns by less has a constant one
    return {node: EdgeAxes(s[k], np.cross(s[k], n[k]), n[k], n_s[k]) for k, node in enumerate(nodes)}


def _unit(vectors: Floats) -> Floats:
    return vectors / np.linalg.norm(vectors, axis=1, keepdims=True)

"""Integrals over edges and mid-surfaces by the length and area of the reference configuration.

The parameters x, y of a plate are lengths, those of a curved reference surface need not be. A length along an edge is
|R_s| ds with the parameter s, an area |R_x x R_y| dx dy, where R is the mid-surface in the reference configuration.
"""

from __future__ import annotations

import numpy as np

from lamella.body.mesh import PlateMesh
from lamella.kinematics import PointRows
from lamella.math.gauss import gauss_rule
from lamella.roles import Floats, Ints

N_GAUSS = 4
"""Points in each direction of an element: exact for the shape functions where the line element is at most quartic."""


def edge_quadrature(mesh: PlateMesh, side: str, initial: Floats) -> tuple[list[PointRows], Floats]:
    """Points along an edge and their weights w_p, so that int f ds = sum_p w_p f_p over the reference length.

    Args:
        mesh: the plate.
        side: its edge.
        initial: all coordinate vectors in the reference configuration, shape (n_vectors, 3).

    Returns:
        The points, element by element, and their weights [m], shape (n_elements, N_GAUSS).
    """
    points, _ = mesh.edge_points(side, gauss_rule(N_GAUSS)[0])
    return mesh.locate_each(points), edge_weights(mesh, side, initial)


def edge_weights(mesh: PlateMesh, side: str, initial: Floats) -> Floats:
    """The weights of :func:`edge_quadrature` alone, shape (n_elements, N_GAUSS)."""
    places, weights = gauss_rule(N_GAUSS)
    end = 0 if side[1] == "-" else 1
    fixed = np.full(N_GAUSS, float(end))
    if side[0] == "x":
        elements, (xi, eta), slope, length = mesh.nx * np.arange(mesh.ny) + end * (mesh.nx - 1), (fixed, places), 2, mesh.ly
    else:
        elements, (xi, eta), slope, length = end * (mesh.ny - 1) * mesh.nx + np.arange(mesh.nx), (places, fixed), 1, mesh.lx
    x = mesh.scale[elements, ::3, None] * initial[mesh.coords[elements, ::3] // 3]
    R_s = mesh.element.shape(xi, eta)[slope] @ x / length
    return np.linalg.norm(R_s, axis=2) * weights * length


def surface_integrals(mesh: PlateMesh, initial: Floats) -> tuple[Ints, Floats]:
    """Integrals int S_k dA of the shape functions of each element over the reference area.

    Args:
        mesh: the plate.
        initial: all coordinate vectors in the reference configuration, shape (n_vectors, 3).

    Returns:
        Numbers of the vectors and the integrals that weigh them [m^2 times the unit of S_k], both of shape (n_elements, n_shape).
    """
    places, weights = gauss_rule(N_GAUSS)
    eta, xi = (grid.reshape(-1) for grid in np.meshgrid(places, places, indexing="ij"))
    S, S_xi, S_eta = mesh.element.shape(xi, eta)[:3]
    vectors, scale = mesh.coords[:, ::3] // 3, mesh.scale[:, ::3]
    x = scale[:, :, None] * initial[vectors]
    R_x, R_y = (np.einsum("pk,ekc->epc", slope, x) / length for slope, length in ((S_xi, mesh.lx), (S_eta, mesh.ly)))
    areas = np.linalg.norm(np.cross(R_x, R_y), axis=2) * np.outer(weights, weights).reshape(-1) * mesh.lx * mesh.ly
    return vectors, areas @ S * scale

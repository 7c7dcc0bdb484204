"""Solids: volume and inertia against integrals over their drawn surface, whose faces point outward."""

from __future__ import annotations

import numpy as np
import pytest

import lamella as lm
from lamella.body import shape
from lamella.errors import DeclarationError

SOLIDS = {
    "box": lm.Box((0.3, 0.5, 0.8)),
    "cylinder": lm.Cylinder(radius=0.4, length=1.1),
    "flat cylinder": lm.Cylinder(radius=0.7, length=0.05),
    "sphere": lm.Sphere(radius=0.6),
}
solids = pytest.mark.parametrize("name", SOLIDS)


def triangles(solid):
    """Corners of the surface's triangles, shape (n, 3, 3); quadrilaterals are cut in two."""
    vertices, faces = solid.surface()
    corners = np.concatenate([vertices[faces[:, [0, 1, 2]]], vertices[faces[:, [0, 2, 3]]]])
    areas = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    return corners[areas > 1e-12]


def volume_and_second_moments(solid):
    """Volume and int x x^T dV of the drawn body, summed over tetrahedra from the origin (divergence theorem)."""
    volume, moments = 0.0, np.zeros((3, 3))
    for a, b, c in triangles(solid):
        part = np.linalg.det([a, b, c]) / 6.0
        s = a + b + c
        volume += part
        # int of x_i x_j over a tetrahedron with a corner in the origin
        moments += part / 20.0 * (np.outer(a, a) + np.outer(b, b) + np.outer(c, c) + np.outer(s, s))
    return volume, moments


@solids
def test_volume_and_gyration_are_integrals_over_the_surface(name, monkeypatch):
    monkeypatch.setattr(shape, "FACETS", 240)
    solid = SOLIDS[name]
    volume, moments = volume_and_second_moments(solid)
    # facets lie inside the curved surface: (pi / 240)^2 = 2e-4 of the radius, five times that in the moments; a box is exact
    near = 1e-12 if name == "box" else 1e-3
    assert volume == pytest.approx(solid.volume, rel=near)
    gyration = (np.trace(moments) * np.eye(3) - moments) / volume
    np.testing.assert_allclose(np.diag(gyration), solid.gyration, rtol=near)
    np.testing.assert_allclose(gyration - np.diag(np.diag(gyration)), 0.0, atol=1e-12)


@solids
def test_surface_is_closed_and_faces_point_outward(name):
    corners = triangles(SOLIDS[name])
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    np.testing.assert_allclose(normals.sum(axis=0), 0.0, atol=1e-12)
    outward = np.einsum("ij,ij->i", normals, corners.mean(axis=1))  # the solids are convex about the origin
    assert outward.min() > 0


@solids
def test_vertices_lie_on_the_solid(name):
    vertices, faces = SOLIDS[name].surface()
    assert faces.min() >= 0
    assert faces.max() == len(vertices) - 1
    sizes = {"box": (0.15, 0.25, 0.4), "cylinder": (0.4, 0.4, 0.55), "flat cylinder": (0.7, 0.7, 0.025), "sphere": 3 * (0.6,)}
    np.testing.assert_allclose(vertices.max(axis=0), sizes[name], rtol=1e-12)
    np.testing.assert_allclose(vertices.min(axis=0), -np.array(sizes[name]), rtol=1e-12)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: lm.Box((0.3, 0.0, 0.8)), r"Box.*size.*greater than 0"),
        (lambda: lm.Cylinder(radius=-0.1, length=1.0), r"Cylinder.*radius.*greater than 0"),
        (lambda: lm.Sphere(radius=0.0), r"Sphere.*radius.*greater than 0"),
    ],
)
def test_solids_without_extent_are_refused(make, message):
    with pytest.raises(DeclarationError, match=message):
        make()

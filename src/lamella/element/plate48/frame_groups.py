"""Groups of elements that share a frame: their coordinates, reference, stiffness and mean gradient."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from lamella.element.base import ElementSpec
from lamella.element.plate48.exact import ExactModel, reference_tangent
from lamella.element.plate48.section import Section
from lamella.element.plate48.shape import gauss_points
from lamella.element.plate48.surface import derivatives_at_points, reference_surface
from lamella.errors import LamellaError, ModelError
from lamella.math.gauss import gauss_rule
from lamella.math.rotation import polar
from lamella.roles import Bools, Floats, Ints

FramePlace = Literal["mean", "x-", "x+", "y-", "y+"]
"""Where the gradients are taken that turn the frame of a body: all over it, or along the edge of least or greatest x or y."""


@dataclass(frozen=True)
class FrameGroups:
    """Groups of n coordinate vectors each; what belongs to the reference is given in the axes of its frame.

    Args:
        coords: global coordinate of each component, shape (n_group, n, 3).
        is_position: True where a vector is a position, shape (n,).
        origin: number of the position from which all others are measured.
        weights: the mean gradients are f_i = sum_k weights[i, k] x_k, shape (n_group, 2, n).
        rest: vectors of the stress-free reference, positions from the origin, in the axes of its frame, shape (n_group, n, 3).
        stiffness: tangent K0 at the reference in the axes of its frame, shape (n_group, 3 n, 3 n).
        axes: axes of the reference's frames as columns, shape (n_group, 3, 3).
    """

    coords: Ints
    is_position: Bools
    origin: int
    weights: Floats
    rest: Floats
    stiffness: Floats
    axes: Floats


def element_groups(
    exact: ExactModel, name: str, coords: Ints, scale: Floats, reference: Floats, section: Section | Floats, n_gauss: int
) -> FrameGroups:
    """Each element a group. The arguments are those of :class:`CorotationalShellBlock`.

    Raises:
        ModelError: as :class:`ShellBlock`, or the mean gradient of an element's reference is singular.
    """
    shell, k = reference_tangent(exact, name, coords, scale, reference, section, n_gauss)
    integrals, area = _gradient_integrals(name, shell.element, scale, reference)
    coords, matrices = np.asarray(coords, np.int64).reshape(len(coords), -1, 3), shell.matrices(k)
    return _in_frames(name, coords, _is_position(shell.element, 1), integrals / area[:, None, None], reference, matrices)


def body_group(
    exact: ExactModel,
    name: str,
    coords: Ints,
    scale: Floats,
    reference: Floats,
    section: Section | Floats,
    n_gauss: int,
    frame_at: FramePlace,
) -> FrameGroups:
    """All elements one group. The arguments are those of :class:`FloatingShellBlock`.

    Raises:
        ModelError: as :class:`FloatingShellBlock`.
    """
    shell, k = reference_tangent(exact, name, coords, scale, reference, section, n_gauss)
    matrices, spec = shell.matrices(k), shell.element
    if frame_at == "mean":
        integrals, measure = _gradient_integrals(name, spec, scale, reference)
    else:
        integrals, measure = _edge_integrals(name, spec, np.asarray(coords), scale, reference, frame_at)
    coords = np.asarray(coords, np.int64).reshape(len(coords), -1, 3)
    _, first, place = np.unique(coords[..., 0], return_index=True, return_inverse=True)
    place, n = place.reshape(len(coords), -1), len(first)
    weights, K0 = np.zeros((2, n)), np.zeros((n, 3, n, 3))
    for at, integral, matrix in zip(place, integrals, matrices, strict=True):
        weights[:, at] += integral / measure.sum()
        K0[at[:, None], :, at[None, :], :] += matrix.reshape(len(at), 3, len(at), 3).swapaxes(1, 2)
    rest = np.asarray(reference, float).reshape(-1, 3)[first]
    own, is_position = coords.reshape(-1, 3)[first][None], _is_position(spec, len(coords))[first]
    return _in_frames(name, own, is_position, weights[None], rest[None], K0.reshape(1, 3 * n, 3 * n))


def _is_position(spec: ElementSpec, n_element: int) -> Bools:
    """Whether each vector of the elements is a position, shape (n_shape n_element,)."""
    return np.tile(spec.is_position, len(spec.nodes) * n_element)


def _in_frames(name: str, coords: Ints, is_position: Bools, weights: Floats, reference: Floats, matrices: Floats) -> FrameGroups:
    """Turn the reference and its stiffness from the inertial axes into those of the reference's frames."""
    rest = np.asarray(reference, float).reshape(coords.shape)
    origin = int(np.argmax(is_position))
    rest = rest - is_position[:, None] * rest[:, origin, None]
    try:
        R, _ = polar(np.swapaxes(weights @ rest, -1, -2))
    except LamellaError as error:
        raise ModelError(
            f"{name}: the mean of r_x and r_y over the reference has no direction, so no frame can follow it; accepted are "
            "surfaces that do not close on themselves, or the exact strain model"
        ) from error
    g, n = coords.shape[:2]
    turned = np.einsum("gba,gkblc->gkalc", R, matrices.reshape(g, n, 3, n, 3))
    turned = np.einsum("gkalb,gbc->gkalc", turned, R)
    stiffness = np.ascontiguousarray(turned).reshape(g, 3 * n, 3 * n)
    return FrameGroups(coords, is_position, origin, weights, rest @ R, stiffness, R)


def _gradient_integrals(name: str, spec: ElementSpec, scale: Floats, reference: Floats) -> tuple[Floats, Floats]:
    """Integrals of r_x and r_y over the reference area as sums over the vectors, shape (n_element, 2, n_shape), and the area."""
    xi, eta, weights = gauss_points(4)
    shape = spec.shape(xi, eta)
    points = derivatives_at_points(shape, np.asarray(reference, float) * scale)
    area = reference_surface(name, points).area * weights
    return _slope_integrals(spec, area, shape, scale), area.sum(axis=1)


def _edge_integrals(
    name: str, spec: ElementSpec, coords: Ints, scale: Floats, reference: Floats, side: str
) -> tuple[Floats, Floats]:
    """The same along an edge of the body, with the reference length in place of the area; zero for elements away from it."""
    fixed, value = "xy".index(side[0]), int(side[1] == "+")
    places, weights = gauss_rule(4)
    parameters = [places, places]
    parameters[fixed] = np.full_like(places, value)
    shape = spec.shape(*parameters)
    along = derivatives_at_points(shape, np.asarray(reference, float) * scale)[2 - fixed]
    length = np.linalg.norm(along, axis=-1) * weights
    length[~_on_edge(spec, coords, fixed, value)] = 0.0
    if not length.any():
        raise ModelError(f"{name}: the surface has no edge {side} for a frame; accepted are edges where the surface ends")
    return _slope_integrals(spec, length, shape, scale), length.sum(axis=1)


def _on_edge(spec: ElementSpec, coords: Ints, fixed: int, value: int) -> Bools:
    """Whether each element's side, where the parameter ``fixed`` has the value 0 or 1, is not the opposite side of another."""
    numbers = coords[:, :: coords.shape[1] // len(spec.nodes)]
    own, opposite = (numbers[:, [node[fixed] == at for node in spec.nodes]].tolist() for at in (value, 1 - value))
    inner = {frozenset(pair) for pair in opposite}
    return np.array([frozenset(pair) not in inner for pair in own])


def _slope_integrals(spec: ElementSpec, measure: Floats, shape: Floats, scale: Floats) -> Floats:
    """Integrals of r_x and r_y with the weights ``measure`` (n_element, n_point), shape (n_element, 2, n_shape)."""
    factors = np.asarray(scale, float)[:, ::3]
    lengths = factors[:, [spec.vector_names.index("r_x"), spec.vector_names.index("r_y")]]
    return np.einsum("eg,dgs->eds", measure, shape[1:3]) * factors[:, None, :] / lengths[:, :, None]

"""A closed belt at rest: rigid motion, dilation, ring frequencies and breathing."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

import lamella as lm
from lamella.model import Model
from lamella.roles import Floats
from lamella.verification import Evidence, Orders, References, Shape
from lamella.verification.belt import ELEMENTS, LENGTH, WAVES, belt, rayleigh

slow = True

MESHES = {"plate48": ((20, 1), (28, 1), (40, 1), (80, 1)), "plate36": ((20, 1), (40, 1), (80, 1), (40, 2), (40, 4))}
CHECKED = {(element, mesh) for element in ELEMENTS for mesh in MESHES[element] if mesh[0] >= 40}


def run() -> Iterator[Evidence]:
    """Yield the checks and pictures of this case."""
    references = References.beside(__file__)
    for element in ELEMENTS:
        for name, value in at_rest(belt((40, 1), nu=0.3, element=element).compile()).items():
            yield references.check(f"{name}, {element}", value)
    yield from frequencies(references)
    yield references.check("breathing frequency", breathing(belt((40, 1)).compile()))
    yield Shape("Modes of the belt", lm.modes(belt((40, 1)), 12), shapes=12)


def at_rest(model: Model) -> dict[str, float]:
    """Force and energy after a rigid motion, energy of a dilation, frequency of the sixth mode."""
    (shell,) = model.forces
    force = np.empty(len(shell.f_coords))
    turn = np.array([[0.36, 0.48, -0.8], [-0.8, 0.6, 0.0], [0.48, 0.64, 0.6]])  # a rotation by rational numbers
    moved = model.vectors(model.q0) @ turn.T
    moved[model.is_position] += (0.3, -2.0, 1.0)
    dilated = 1.001 * model.q0
    shell.force(0.0, dilated, model.v0, force)
    typical, size = shell.energy(0.0, dilated), np.abs(force).max()
    shell.force(0.0, moved.reshape(-1), model.v0, force)
    return {
        "force after a rigid motion over that of the dilation": float(np.abs(force).max() / size),
        "energy after a rigid motion over that of the dilation": shell.energy(0.0, moved.reshape(-1)) / typical,
        "energy of a dilation by 0.1 %": typical,
        "largest of the first six frequencies": float(np.abs(lm.modes(model, 6).frequencies).max()),
    }


def frequencies(references: References) -> Iterator[Evidence]:
    """Ring frequencies on several meshes against Rayleigh's."""
    errors = {}
    for element in ELEMENTS:
        for mesh in MESHES[element]:
            found = plane_frequencies(lm.modes(belt(mesh, element=element), 18))
            errors[element, mesh] = np.abs(found / rayleigh() - 1)
            if (element, mesh) in CHECKED:
                name = f"frequency over Rayleigh's, {element}, mesh {mesh[0]} x {mesh[1]}, waves"
                yield from references.checks(name, found / rayleigh())
    halved = errors["plate48", (20, 1)] / errors["plate48", (40, 1)]
    yield references.check("order of the frequency with 3 waves, plate48", float(np.log2(halved[1])))
    shown = {
        f"{element}, one element across": (
            [LENGTH / n for n, _ in MESHES[element][:3]],
            [errors[element, mesh][2] for mesh in MESHES[element][:3]],
        )
        for element in ELEMENTS
    }
    yield Orders("Frequency with four waves", "Length of an element [m]", shown, (4,))


def plane_frequencies(modes: lm.Modes) -> Floats:
    """Frequencies of the first three pairs of modes whose two edges move alike; the others tilt."""
    mesh = modes.model.plates[0]
    found = []
    for frequency, shape in zip(modes.frequencies[6:], modes.shapes.T[6:], strict=True):
        lower, upper = (modes.model.vectors(shape)[[mesh.vector(int(k), "r") for k in mesh.edge_nodes(s)]] for s in ("y-", "y+"))
        if np.linalg.norm(upper - lower) < 0.1 * np.linalg.norm(upper + lower):
            found.append(frequency)
    return np.array(found[0 : 2 * len(WAVES) : 2])


def breathing(model: Model) -> float:
    """Rayleigh's quotient of the uniform dilation [Hz], whose error is the square of what the mode differs from it."""
    (shell,) = model.forces
    shape = (model.vectors(model.q0) * (1.0, 1.0, 0.0)).reshape(-1)
    h = 1e-4
    curvature = sum(shell.energy(0.0, model.q0 + factor * shape) for factor in (h, -h)) / h**2
    return float(np.sqrt(curvature / (shape @ (model.mass @ shape))) / (2 * np.pi))

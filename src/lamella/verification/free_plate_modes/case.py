"""A free plate has six modes of frequency zero."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

import lamella as lm
from lamella.verification import Evidence, References, Shape

TURNS = {"at rest in the axes": (0.0, 0.0, 0.0), "turned in space": (0.6, -1.1, 0.4)}


def free(rotation: tuple[float, float, float]) -> lm.System:
    """A free [0/90] plate, whose membrane and bending are coupled."""
    ply = lm.Lamina(E1=181e9, E2=103e9, G12=7.7e9, nu12=0.28, rho=1560)
    layup = lm.Laminate(ply, angles=(0, 90), thickness=4e-3)
    system = lm.System()
    system.add(lm.Plate("plate", size=(0.6, 0.4), mesh=(4, 3), laminate=layup, rotation=rotation, position=(1.0, 2.0, -3.0)))
    return system


def rigid_part(modes: lm.Modes) -> float:
    """Smallest share of a rigid-body field (translations, small rotations) that the first six shapes represent."""
    model = modes.model
    x = model.q0.reshape(-1, 3)
    fields = [np.outer(model.is_position, axis).reshape(-1) for axis in np.eye(3)]
    fields += [np.cross(axis, x).reshape(-1) for axis in np.eye(3)]
    R, Phi = np.stack(fields, axis=1), modes.shapes[:, :6]
    R /= np.sqrt(np.sum(R * (model.mass @ R), axis=0))
    return float(np.min(np.sum((Phi.T @ (model.mass @ R)) ** 2, axis=0)))


def run() -> Iterator[Evidence]:
    """Yield the checks and pictures of this case."""
    references = References.beside(__file__)
    elastic, found = [], {}
    for where, rotation in TURNS.items():
        modes = lm.modes(free(rotation), 10)
        first, rigid = modes.frequencies[6], np.abs(modes.frequencies[:6]).max()
        found[where] = modes
        elastic.append(modes.frequencies[6:])
        yield references.check(f"largest rigid frequency / first elastic, {where}", rigid / first)
        yield references.check(f"share of rigid motion in six modes, {where}", rigid_part(modes))
    yield Shape("Six rigid modes and three elastic ones, turned in space", found["turned in space"], shapes=9)
    yield references.check("change of elastic frequencies by turning", np.abs(elastic[1] / elastic[0] - 1).max())

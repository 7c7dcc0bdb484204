"""Samples of many configurations at once are those of each by itself, whatever the plate."""

from __future__ import annotations

import numpy as np
import pytest

import lamella as lm
from lamella.viz.fields import FIELDS, HEAT, Snapshot

STRENGTHS = {"Xt": 1.5e9, "Xc": 1.2e9, "Yt": 4e7, "Yc": 2e8, "S12": 7e7}
HEATED = {"k1": 5.0, "k2": 1.0, "k3": 1.0, "c": 900.0, "alpha1": 1e-6, "alpha2": 3e-5}
PLY = lm.Lamina(E1=150e9, E2=10e9, nu12=0.3, G12=5e9, rho=1500.0, **STRENGTHS, **HEATED)
LAYUP = lm.Laminate(PLY, angles=(0, 30), thickness=0.01)
OPTIONS = {
    "exact": {},
    "tapered": {"thickness_factors": [[1.0, 0.5, 0.8], [0.7, 1.2, 0.9]], "prestrain": (2e-3, -1e-3, 1e-3)},
    "cubed": {"curvature": "cubed_normal"},
    "plate36": {"element": "plate36"},
    "linear": {"strain": "linear"},
    "floating": {"strain": "floating"},
    "corotational": {"strain": "corotational"},
}


COLD = {"tapered", "plate36"}
"""Plates that take no temperature field."""


@pytest.mark.parametrize(
    ("name", "heated"), [(name, heated) for name in OPTIONS for heated in (False, True) if not (heated and name in COLD)]
)
def test_fields_of_a_stack_are_those_of_each_configuration(name, heated):
    system = lm.System()
    plate = system.add(
        lm.Plate("plate", (1.0, 0.6), (3, 2), LAYUP, position=(1, 2, 3), rotation=(0.1, -0.4, 0.3), **OPTIONS[name])
    )
    if heated:
        system.add(lm.TemperatureField("heat", plate, reference=290.0))
    model = system.compile()
    random = np.random.default_rng(7)
    q = model.q0 + random.uniform(-0.02, 0.02, (2, 3, model.n_q))
    v = random.uniform(-1.0, 1.0, q.shape)
    mesh = model.plates[0]
    grid = mesh.grid(2)
    reference = grid.sample(model.q0)
    together = Snapshot(mesh, grid, q, v, reference)
    for field in (field for field in FIELDS.values() if heated or field.name not in HEAT):
        found = field.evaluate(together)
        assert found.shape[:2] == (2, 3)
        for place in np.ndindex(2, 3):
            alone = field.evaluate(Snapshot(mesh, grid, q[place], v[place], reference))
            # sums over shape functions in another order: rounding, of strains that are differences of numbers of order one
            np.testing.assert_allclose(found[place], alone, rtol=1e-10, atol=1e-13 * np.abs(alone).max(), err_msg=field.name)

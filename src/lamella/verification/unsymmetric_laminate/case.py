"""Two-ply [0/90] plate under edge forces and edge moments: stretching and bending are coupled, and B has a sign."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Literal

import lamella as lm
from lamella.body.mesh import PlateSample
from lamella.verification import Curves, Evidence, References

slow = False

PLY = lm.Lamina(E1=181e9, E2=103e9, G12=7.7e9, nu12=0.28, rho=1560)
LAMINATE = lm.Laminate(PLY, angles=(0, 90), thickness=1.5e-3)
SIZE, MESH = (0.4, 0.3), (4, 3)
PULL, MOMENT = 0.01, 1e-4
"""Edge force [N/m], whose moment over the arch it makes is N L^2 / (8 D) = 5e-6 of the coupling, and edge moment [N]."""


def run() -> Iterator[Evidence]:
    """Yield the checks and pictures of this case."""
    references = References.beside(__file__)
    for name, value in (
        ("A11", LAMINATE.A[0, 0]),
        ("B11", LAMINATE.B[0, 0]),
        ("B22", LAMINATE.B[1, 1]),
        ("D11", LAMINATE.D[0, 0]),
    ):
        yield references.check(name, value)
    arches, arc = {}, {}
    models: tuple[Literal["exact", "linear"], ...] = ("exact", "linear")
    for strain in models:
        pulled, bent = loaded(strain, pull=PULL), loaded(strain, moment=MOMENT)
        for name, sample in (("pull", pulled), ("moment", bent)):
            middle = sample.strains[len(sample.y) // 2, len(sample.x) // 2]
            for label, component in (("eps_x", 0), ("eps_y", 1), ("kap_x", 3), ("kap_y", 4)):
                check = references.check(f"{label} under {name}", middle[component])
                yield replace(check, quantity=f"{check.quantity}, strain = {strain}")
        z = pulled.r[len(pulled.y) // 2, :, 2]
        rise = z[len(z) // 2] - 0.5 * (z[0] + z[-1])
        arches[f"strain = {strain}"] = (pulled.x, z - 0.5 * (z[0] + z[-1]))
        height = references.value("rise of the middle over the ends under pull")
        arc["arc of the reference"] = (pulled.x, height * (1.0 - (2.0 * pulled.x / SIZE[0] - 1.0) ** 2))
        check = references.check("rise of the middle over the ends under pull", rise)
        yield replace(check, quantity=f"{check.quantity}, strain = {strain}")

    yield Curves("Arch of a plate that is pulled, along its middle", "x [m]", "Height over the ends [m]", arches, arc)


def loaded(strain: Literal["exact", "linear"], pull: float = 0.0, moment: float = 0.0) -> PlateSample:
    """The free plate under opposite forces or moments on the edges x- and x+, on isostatic supports."""
    system = lm.System()
    plate = system.add(lm.Plate("plate", SIZE, MESH, LAMINATE, strain=strain))
    system.add(lm.PointSupport("pin", plate.corner("x-y-")))
    system.add(lm.PointSupport("line", plate.corner("x+y-"), axes="yz"))
    system.add(lm.PointSupport("height", plate.corner("x-y+"), axes="z"))
    left, right = plate.edge("x-"), plate.edge("x+")
    if pull:
        system.add(lm.EdgeForce("pull right", right, (pull, 0.0, 0.0)))
        system.add(lm.EdgeForce("pull left", left, (-pull, 0.0, 0.0)))
    if moment:  # M_x works on kap_x: a rotation about -y on the right
        system.add(lm.EdgeMoment("bend right", right, bending=-moment))
        system.add(lm.EdgeMoment("bend left", left, bending=moment))
    result = lm.equilibrium(system, newton=lm.Newton(tolerance=1e-12, keep=0.0))
    return result.model.plates[0].sample(result.final.q)

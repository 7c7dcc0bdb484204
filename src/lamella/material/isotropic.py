"""An isotropic sheet, and the choice between the two kinds of ply material."""

from __future__ import annotations

import math
from typing import Annotated

from pydantic import Discriminator, Tag

from lamella.declaration import declaration
from lamella.material.lamina import Lamina
from lamella.units import Conductivity, Density, Expansion, Modulus, Number, SpecificHeat


@declaration
class Isotropic:
    """Isotropic, linearly elastic material: a ply without direction, ``G = E / (2 (1 + nu))``.

    Args:
        E: Young's modulus [Pa].
        nu: Poisson's ratio [-], -1 < nu <= 0.5.
        rho: density [kg/m^3].
        alpha: thermal expansion [1/K].
        strength: largest allowed von Mises stress [Pa].
        k: thermal conductivity [W/(m K)]; needed where heat is conducted.
        c: specific heat [J/(kg K)]; needed where heat is stored.

    Raises:
        DeclarationError: a value outside its range.
    """

    E: Modulus
    nu: Number
    rho: Density
    alpha: Expansion = 0.0
    strength: Modulus | None = None
    k: Conductivity | None = None
    c: SpecificHeat | None = None

    def __post_init__(self) -> None:
        """Refuse a Poisson's ratio with which the material would release energy."""
        if not -1.0 < self.nu <= 0.5:
            raise ValueError(f"nu = {self.nu:g}; accepted is a value greater than -1 and at most 0.5")

    @property
    def G(self) -> float:
        """Shear modulus [Pa]."""
        return self.E / (2.0 * (1.0 + self.nu))

    @property
    def lamina(self) -> Lamina:
        """The same material as a ply. Its shear strength is strength / sqrt(3), with which Tsai-Hill is von Mises."""
        X = self.strength
        S = None if X is None else X / math.sqrt(3.0)
        heat = {"k1": self.k, "k2": self.k, "k3": self.k, "c": self.c}
        return Lamina(self.E, self.E, self.G, self.nu, self.rho, self.alpha, self.alpha, X, X, X, X, S, **heat)


def _kind(value: object) -> str | None:
    if isinstance(value, Isotropic):
        return "isotropic"
    if isinstance(value, Lamina):
        return "lamina"
    if isinstance(value, dict):
        return "isotropic" if {"E", "nu"} & value.keys() else "lamina"
    return None


Material = Annotated[
    Annotated[Lamina, Tag("lamina")] | Annotated[Isotropic, Tag("isotropic")],
    Discriminator(
        _kind,
        custom_error_type="material",
        custom_error_message="accepted is a Lamina (E1, E2, G12, nu12, rho) or an Isotropic (E, nu, rho) material",
    ),
]
"""A ply's material. In a model file the keys decide: ``E`` or ``nu`` makes it Isotropic, anything else a Lamina."""

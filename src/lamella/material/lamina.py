"""A unidirectional ply: orthotropic, linearly elastic, in plane stress."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from lamella.declaration import declaration
from lamella.errors import DeclarationError
from lamella.roles import Floats
from lamella.units import Conductivity, Density, Expansion, Modulus, Number, SpecificHeat


@declaration
class Lamina:
    """Ply material with the fibres along axis 1.

    ``eps1 = sigma1 / E1 - nu12 sigma2 / E1``, ``eps2 = sigma2 / E2 - nu12 sigma1 / E1``, ``gamma12 = tau12 / G12``.

    Args:
        E1: Young's modulus along the fibres [Pa].
        E2: Young's modulus across the fibres [Pa].
        G12: shear modulus in the plane [Pa].
        nu12: Poisson's ratio, contraction along 2 under tension along 1 [-]; ``abs(nu12) < sqrt(E1 / E2)``.
        rho: density [kg/m^3].
        alpha1: thermal expansion along the fibres [1/K].
        alpha2: thermal expansion across the fibres [1/K].
        Xt: tensile strength along the fibres [Pa].
        Xc: compressive strength along the fibres, a positive number [Pa].
        Yt: tensile strength across the fibres [Pa].
        Yc: compressive strength across the fibres, a positive number [Pa].
        S12: shear strength in the plane [Pa].
        k1: thermal conductivity along the fibres [W/(m K)]; needed, with k2, where heat is conducted.
        k2: thermal conductivity across the fibres in the plane [W/(m K)].
        k3: thermal conductivity through the thickness [W/(m K)]; that of k2 when left out, as in a ply that is transversely
            isotropic.
        c: specific heat [J/(kg K)]; needed where heat is stored.

    Raises:
        DeclarationError: a modulus, density, strength, conductivity or specific heat that is not positive, one of k1 and k2
            without the other, or a Poisson's ratio with which straining the ply would release energy.

    Source: Jones, Mechanics of Composite Materials (2nd ed., 1999), sections 2.3 to 2.5.
    """

    E1: Modulus
    E2: Modulus
    G12: Modulus
    nu12: Number
    rho: Density
    alpha1: Expansion = 0.0
    alpha2: Expansion = 0.0
    Xt: Modulus | None = None
    Xc: Modulus | None = None
    Yt: Modulus | None = None
    Yc: Modulus | None = None
    S12: Modulus | None = None
    k1: Conductivity | None = None
    k2: Conductivity | None = None
    k3: Conductivity | None = None
    c: SpecificHeat | None = None

    def __post_init__(self) -> None:
        """Refuse a stiffness that is not positive definite, and conductivities of which some cannot be told."""
        limit = math.sqrt(self.E1 / self.E2)
        if abs(self.nu12) >= limit:
            raise ValueError(f"nu12 = {self.nu12:g}; accepted is abs(nu12) < sqrt(E1 / E2) = {limit:.4g}, else nu12 nu21 >= 1")
        if (self.k1 is None) != (self.k2 is None) or (self.k3 is not None and self.k1 is None):
            given = [f"{name} = {k:g}" for name, k in (("k1", self.k1), ("k2", self.k2), ("k3", self.k3)) if k is not None]
            raise ValueError(
                f"{' and '.join(given)} alone; accepted are k1 along and k2 across the fibres together, with or without k3"
            )

    @property
    def nu21(self) -> float:
        """The other Poisson's ratio, ``nu21 = nu12 E2 / E1`` [-]."""
        return self.nu12 * self.E2 / self.E1


class Strengths(NamedTuple):
    """Strengths of a ply, all positive [Pa]."""

    Xt: float
    Xc: float
    Yt: float
    Yc: float
    S12: float


def strengths(lamina: Lamina) -> Strengths:
    """The five strengths of a ply material.

    Raises:
        DeclarationError: some are not given; the message names them.
    """
    given = {name: getattr(lamina, name) for name in Strengths._fields}
    missing = [name for name, value in given.items() if value is None]
    if missing:
        raise DeclarationError(
            "Lamina",
            f"a failure criterion needs the strengths {', '.join(missing)}, which are not given",
            "accepted are positive stresses for all of Xt, Xc, Yt, Yc, S12 (for Isotropic: strength)",
        )
    return Strengths(**given)


class Conductivities(NamedTuple):
    """Thermal conductivities of a ply along and across the fibres and through the thickness [W/(m K)]."""

    k1: float
    k2: float
    k3: float


def conductivities(lamina: Lamina, item: str = "Lamina") -> Conductivities:
    """The three thermal conductivities of a ply material, k3 being k2 when it is not given.

    Args:
        lamina: ply material.
        item: what it is the material of, for the message.

    Raises:
        DeclarationError: k1 and k2 are not given.
    """
    if lamina.k1 is None or lamina.k2 is None:
        raise DeclarationError(
            item,
            "conduction of heat needs the thermal conductivity, which is not given",
            "accepted are positive k1 and k2 in W/(m*K) (for Isotropic: k)",
        )
    return Conductivities(lamina.k1, lamina.k2, lamina.k2 if lamina.k3 is None else lamina.k3)


def specific_heat(lamina: Lamina, item: str = "Lamina") -> float:
    """The specific heat of a ply material [J/(kg K)].

    Args:
        lamina: ply material.
        item: what it is the material of, for the message.

    Raises:
        DeclarationError: it is not given.
    """
    if lamina.c is None:
        raise DeclarationError(
            item, "storing heat needs the specific heat c, which is not given", "accepted is a positive c in J/(kg*K)"
        )
    return lamina.c


def reduced_stiffness(lamina: Lamina) -> Floats:
    """Plane-stress stiffness in the fibre axes.

    ``Q = 1/(1 - nu12 nu21) [[E1, nu21 E1, 0], [nu12 E2, E2, 0], [0, 0, (1 - nu12 nu21) G12]]``

    Returns:
        Q [Pa], shape (3, 3), for strains (eps1, eps2, gamma12).

    Source: Jones (1999), section 2.4.
    """
    nu12, nu21 = lamina.nu12, lamina.nu21
    det = 1.0 - nu12 * nu21
    coupling = nu12 * lamina.E2 / det  # equals nu21 E1 / det; written once so that Q is exactly symmetric
    return np.array([[lamina.E1 / det, coupling, 0.0], [coupling, lamina.E2 / det, 0.0], [0.0, 0.0, lamina.G12]])


def stress_transformation(angle: float) -> Floats:
    """The matrix T that turns stresses from the element axes to the fibre axes.

    ``sigma_12 = T sigma_xy`` with ``T = [[c^2, s^2, 2cs], [s^2, c^2, -2cs], [-cs, cs, c^2 - s^2]]``; strains with the engineering
    shear turn with the inverse transpose, ``eps_12 = T^-T eps_xy``.

    Args:
        angle: from the element x axis to the fibres, positive about the normal [deg].

    Returns:
        T [-], shape (3, 3).

    Source: Jones (1999), section 2.6.
    """
    c, s = math.cos(math.radians(angle)), math.sin(math.radians(angle))
    return np.array([[c * c, s * s, 2 * c * s], [s * s, c * c, -2 * c * s], [-c * s, c * s, c * c - s * s]])


def rotated_stiffness(lamina: Lamina, angle: float) -> Floats:
    """Plane-stress stiffness in the element axes, ``Dk = T^-1 Q T^-T``.

    Args:
        lamina: ply material.
        angle: from the element x axis to the fibres [deg].

    Returns:
        Dk [Pa], shape (3, 3), for strains (eps_x, eps_y, gamma_xy).
    """
    T_inv = stress_transformation(-angle)
    return T_inv @ reduced_stiffness(lamina) @ T_inv.T


def rotated_expansion(lamina: Lamina, angle: float) -> Floats:
    """Thermal expansion in the element axes, ``alpha_k = T^T (alpha1, alpha2, 0)``; it turns as a strain.

    Args:
        lamina: ply material.
        angle: from the element x axis to the fibres [deg].

    Returns:
        Expansion (eps_x, eps_y, gamma_xy) per kelvin [1/K], shape (3,).
    """
    return stress_transformation(angle).T @ np.array([lamina.alpha1, lamina.alpha2, 0.0])


def rotated_conductivity(along: float, across: float, angle: float) -> Floats:
    """Conductivity in the plane in the element axes, ``k = R diag(along, across) R^T``; it turns as a tensor of second order.

    Args:
        along: conductivity along the fibres [W/(m K)].
        across: conductivity across the fibres in the plane [W/(m K)].
        angle: from the element x axis to the fibres [deg].

    Returns:
        Conductivity of the heat flux ``-k grad T`` [W/(m K)], shape (2, 2).
    """
    c, s = math.cos(math.radians(angle)), math.sin(math.radians(angle))
    mixed = c * s * (along - across)
    return np.array([[c * c * along + s * s * across, mixed], [mixed, s * s * along + c * c * across]])

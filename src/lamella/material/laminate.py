"""A stack of plies: stiffness A, B, D, thermal resultants, conduction and storage of heat, and mass per area of the section.

Signs: the strain at height z above the reference surface is ``E(z) = eps - z kap`` with ``kap = r_xx . n0``, and the moments are
those that do work on kap. Hence ``M = -integral z sigma dz``, and B enters with a minus:

    N = A eps - B kap - N_T,     M = -B eps + D kap + M_T
    W = 1/2 eps.A eps - eps.B kap + 1/2 kap.D kap - eps.N_T + kap.M_T

The matrices A, B, D themselves are the usual ones of lamination theory (Jones 1999, chapter 4).
"""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING, Annotated

import numpy as np
from pydantic import BeforeValidator, Discriminator, Field, Tag

from lamella.declaration import declaration
from lamella.material.isotropic import Isotropic, Material
from lamella.material.lamina import (
    Lamina,
    conductivities,
    rotated_conductivity,
    rotated_expansion,
    rotated_stiffness,
    specific_heat,
)
from lamella.roles import Floats
from lamella.units import Length, Thickness, quantity

FARTHEST = 1e3
"""Offset over thickness: farther out bending about the mid-plane is lost in the digits of stretching."""

if TYPE_CHECKING:
    PlyAngle = float
    PlyAngles = tuple[float, ...]
    PlyThicknesses = float | tuple[float, ...]
else:
    PlyAngle = quantity("deg")
    PlyAngles = Annotated[
        tuple[PlyAngle, ...],
        BeforeValidator(lambda value: (value,) if isinstance(value, (int, float, str)) else value),
    ]
    PlyThicknesses = Annotated[
        Annotated[Thickness, Tag("total")] | Annotated[tuple[Thickness, ...], Tag("each")],
        Discriminator(lambda value: "each" if isinstance(value, (list, tuple)) else "total"),
    ]


@declaration
class Ply:
    """One layer of a laminate.

    Args:
        material: :class:`Lamina` or :class:`Isotropic`.
        angle: from the element x axis to the fibres, positive about the normal; a number is in degrees, text may carry a unit
            ("0.5 rad") [deg].
        thickness: [m].
    """

    material: Material
    angle: PlyAngle = 0.0
    thickness: Thickness = Field(kw_only=True)


@declaration
class Laminate:
    """A section made of plies, listed from the bottom (z < 0) to the top.

    Equal plies of one material: ``Laminate(ply, angles=(0, 90, 0), thickness=1.5e-3)``; a plain sheet is the same with one ply,
    ``Laminate(Isotropic(E, nu, rho), thickness=2e-3)``. Any other stack: ``Laminate(plies=(Ply(...), Ply(...)))``.

    Args:
        ply: material of all plies.
        angles: fibre angles from the element x axis; numbers are in degrees, text may carry a unit ("0.5 rad") [deg].
        thickness: total thickness, shared equally by the plies, or a sequence with the thickness of each ply [m].
        plies: the plies one by one, instead of ply, angles and thickness.
        offset: height of the laminate's mid-plane above the reference surface; positive to the side of the normal [m].

    Raises:
        DeclarationError: no ply, ply and plies both given, a thickness that is missing, not positive or of the wrong count.

    Source: Jones, Mechanics of Composite Materials (2nd ed., 1999), chapter 4.
    """

    ply: Material | None = None
    angles: PlyAngles = (0.0,)
    thickness: PlyThicknesses | None = None
    plies: tuple[Ply, ...] | None = None
    offset: Length = 0.0

    def __post_init__(self) -> None:
        """Refuse contradictory or incomplete stacks."""
        if self.plies is not None:
            if self.ply is not None or self.thickness is not None or self.angles != (0.0,):
                raise ValueError("'plies' stands alone; accepted is either plies or ply, angles and thickness")
            if not self.plies:
                raise ValueError("no ply in plies; accepted is at least one")
        elif self.ply is None:
            raise ValueError("no ply; accepted is ply with angles and thickness, or plies")
        elif self.thickness is None:
            raise ValueError("'thickness' is missing; accepted is the total thickness or that of each ply")
        elif not self.angles:
            raise ValueError("no ply in angles; accepted is at least one angle")
        elif isinstance(self.thickness, tuple) and len(self.thickness) != len(self.angles):
            raise ValueError(
                f"{len(self.thickness)} thicknesses for {len(self.angles)} angles; "
                "accepted is one thickness per angle, or the total"
            )
        if abs(self.offset) > FARTHEST * self.h:
            raise ValueError(f"offset = {self.offset:g} m; accepted is at most {FARTHEST:g} times the thickness of {self.h:g} m")

    @cached_property
    def layers(self) -> tuple[Ply, ...]:
        """The plies from bottom to top, in whichever way they were given."""
        if self.plies is not None:
            return self.plies
        assert self.ply is not None
        assert self.thickness is not None
        n = len(self.angles)
        each = self.thickness if isinstance(self.thickness, tuple) else (self.thickness / n,) * n
        return tuple(Ply(self.ply, angle, thickness=h) for angle, h in zip(self.angles, each, strict=True))

    @cached_property
    def laminas(self) -> tuple[Lamina, ...]:
        """The material of each ply, isotropic ones in the form of a lamina."""
        materials = (ply.material for ply in self.layers)
        return tuple(material.lamina if isinstance(material, Isotropic) else material for material in materials)

    @cached_property
    def h(self) -> float:
        """Total thickness [m]."""
        return sum(ply.thickness for ply in self.layers)

    @cached_property
    def z(self) -> Floats:
        """Heights of the plies' boundaries above the reference surface [m], shape (n_ply + 1,)."""
        from_bottom = np.cumsum([0.0, *(ply.thickness for ply in self.layers)])
        return _read_only(from_bottom - 0.5 * from_bottom[-1] + self.offset)

    @cached_property
    def Dk(self) -> Floats:
        """Plane-stress stiffness of each ply in the element axes [Pa], shape (n_ply, 3, 3)."""
        pairs = zip(self.laminas, self.layers, strict=True)
        return _read_only(np.array([rotated_stiffness(lamina, ply.angle) for lamina, ply in pairs]))

    @cached_property
    def alpha(self) -> Floats:
        """Thermal expansion of each ply in the element axes [1/K], shape (n_ply, 3)."""
        pairs = zip(self.laminas, self.layers, strict=True)
        return _read_only(np.array([rotated_expansion(lamina, ply.angle) for lamina, ply in pairs]))

    @cached_property
    def A(self) -> Floats:
        """Membrane stiffness ``sum Dk (z_k+1 - z_k)`` [N/m], shape (3, 3)."""
        return _read_only((self._z_moments(0) @ self.Dk.reshape(-1, 9)).reshape(3, 3))

    @cached_property
    def B(self) -> Floats:
        """Coupling stiffness ``sum Dk (z_k+1^2 - z_k^2) / 2`` [N], shape (3, 3)."""
        return _read_only((self._z_moments(1) @ self.Dk.reshape(-1, 9)).reshape(3, 3))

    @cached_property
    def D(self) -> Floats:
        """Bending stiffness ``sum Dk (z_k+1^3 - z_k^3) / 3`` [N m], shape (3, 3)."""
        return _read_only((self._z_moments(2) @ self.Dk.reshape(-1, 9)).reshape(3, 3))

    @cached_property
    def stiffness(self) -> Floats:
        """``[[A, -B], [-B, D]]``, the matrix of 2 W for the strain vector (eps, kap), shape (6, 6)."""
        whole = np.empty((6, 6))
        whole[:3, :3], whole[:3, 3:], whole[3:, :3], whole[3:, 3:] = self.A, -self.B, -self.B, self.D
        return _read_only(whole)

    @cached_property
    def mass_per_area(self) -> float:
        """``sum rho_k h_k`` [kg/m^2]. The section's rotary inertia, and the mass's distance by an offset, are neglected."""
        return sum(ply.material.rho * ply.thickness for ply in self.layers)

    @cached_property
    def thermal_moments(self) -> Floats:
        """``sum integral Dk alpha_k z^p dz`` for p = 0, 1, 2 [N/(m K), N/K, N m/K], shape (3, 3); row p."""
        stress = np.einsum("kij,kj->ki", self.Dk, self.alpha)
        return _read_only(np.array([self._z_moments(p) @ stress for p in range(3)]))

    @cached_property
    def heat_capacity(self) -> Floats:
        """``sum integral rho_k c_k z^p dz`` for p = 0, 1, 2 [J/(m^2 K), J/(m K), J/K], shape (3,).

        Raises:
            DeclarationError: a ply's specific heat is not given.
        """
        pairs = zip(self.laminas, self._items, strict=True)
        rho_c = np.array([lamina.rho * specific_heat(lamina, item) for lamina, item in pairs])
        return _read_only(np.array([self._z_moments(p) @ rho_c for p in range(3)]))

    @cached_property
    def conductivity(self) -> Floats:
        """``sum integral k z^p dz`` for p = 0, 1, 2 [W/K, W m/K, W m^2/K], shape (3, 2, 2), with the plies' tensors in the plane.

        Raises:
            DeclarationError: a ply's conductivity is not given.
        """
        found = [conductivities(lamina, item) for lamina, item in zip(self.laminas, self._items, strict=True)]
        plies = np.array([rotated_conductivity(k.k1, k.k2, ply.angle) for k, ply in zip(found, self.layers, strict=True)])
        return _read_only(np.array([np.tensordot(self._z_moments(p), plies, 1) for p in range(3)]))

    @cached_property
    def conductivity_through(self) -> float:
        """``sum integral k3 dz`` [W/K]: what conducts heat from side to side under a gradient T_M.

        With a temperature that is linear in z, the weak form's ``integral k3 (dT/dz)^2 dz = T_M^2 sum integral k3 dz`` takes the
        arithmetic mean of the plies' k3. Plies in series would have the harmonic mean, and a temperature with kinks.

        Raises:
            DeclarationError: a ply's conductivity is not given.
        """
        k3 = np.array([conductivities(lamina, item).k3 for lamina, item in zip(self.laminas, self._items, strict=True)])
        return float(self._z_moments(0) @ k3)

    @property
    def _items(self) -> tuple[str, ...]:
        """The plies' materials in messages."""
        return tuple(f"{type(ply.material).__name__} of ply {k} (0 at the bottom)" for k, ply in enumerate(self.layers))

    def _z_moments(self, p: int) -> Floats:
        """``integral z^p dz`` over each ply, shape (n_ply,)."""
        powers = self.z ** (p + 1)
        return (powers[1:] - powers[:-1]) / (p + 1)


def thermal_resultants(laminate: Laminate, T_N: Floats | float, T_M: Floats | float) -> tuple[Floats, Floats]:
    """Thermal membrane force and moment of the temperature change ``dT = T_N + z T_M``.

    ``N_T = sum integral Dk alpha_k dT dz``, ``M_T = sum integral Dk alpha_k dT z dz``

    Args:
        laminate: section.
        T_N: change of temperature at the reference surface [K], any shape (...).
        T_M: gradient of temperature through the thickness [K/m], the same shape.

    Returns:
        N_T [N/m] and M_T [N], shapes (..., 3).
    """
    T_N, T_M = np.asarray(T_N, float)[..., None], np.asarray(T_M, float)[..., None]
    a0, a1, a2 = laminate.thermal_moments
    return a0 * T_N + a1 * T_M, a1 * T_N + a2 * T_M


def _read_only(array: Floats) -> Floats:
    array.setflags(write=False)
    return array

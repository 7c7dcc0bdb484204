"""Section forces, ply stresses and failure indices from the strains of the reference surface."""

from __future__ import annotations

from typing import Literal, get_args

import numpy as np

from lamella.errors import DeclarationError
from lamella.material.failure import fibre_stress, tsai_hill, tsai_wu
from lamella.material.laminate import Laminate, thermal_resultants
from lamella.roles import Floats

Surface = Literal["bottom", "middle", "top"]
Axes = Literal["element", "fibre"]
Criterion = Literal["tsai-hill", "tsai-wu"]


def section_forces(laminate: Laminate, strains: Floats, T_N: Floats | float = 0.0, T_M: Floats | float = 0.0) -> Floats:
    """Membrane forces and moments, ``N = A eps - B kap - N_T``, ``M = -B eps + D kap + M_T``.

    Args:
        laminate: section.
        strains: (eps, kap) of the reference surface [-, 1/m], shape (..., 6).
        T_N: change of temperature at the reference surface [K], shape (...) or scalar.
        T_M: gradient of temperature through the thickness [K/m], shape (...) or scalar.

    Returns:
        (N, M) [N/m, N], shape (..., 6).
    """
    N_T, M_T = np.broadcast_arrays(*thermal_resultants(laminate, T_N, T_M))
    return strains @ laminate.stiffness + np.concatenate([-N_T, M_T], axis=-1)


def ply_stress(
    laminate: Laminate,
    strains: Floats,
    ply: int,
    surface: Surface = "middle",
    axes: Axes = "element",
    T_N: Floats | float = 0.0,
    T_M: Floats | float = 0.0,
) -> Floats:
    """Stress in one ply, ``sigma = Dk (eps - z kap - alpha_k (T_N + z T_M))``.

    Args:
        laminate: section.
        strains: (eps, kap) of the reference surface [-, 1/m], shape (..., 6).
        ply: number of the ply, 0 at the bottom; -1 is the topmost.
        surface: height within the ply.
        axes: ``element`` for (sigma_x, sigma_y, tau_xy), ``fibre`` for (sigma_1, sigma_2, tau_12).
        T_N: change of temperature at the reference surface [K], shape (...) or scalar.
        T_M: gradient of temperature through the thickness [K/m], shape (...) or scalar.

    Returns:
        Stress [Pa], shape (..., 3).

    Raises:
        DeclarationError: no such ply, surface or axes.
    """
    _accept("axes", axes, Axes)
    k = _ply_number(laminate, ply)
    z = _height(laminate, k, surface)
    dT = np.asarray(T_N, float) + z * np.asarray(T_M, float)
    stress = strains @ np.vstack([laminate.Dk[k], -z * laminate.Dk[k]]) - dT[..., None] * (laminate.alpha[k] @ laminate.Dk[k])
    return fibre_stress(stress, laminate.layers[k].angle) if axes == "fibre" else stress


def failure_index(
    laminate: Laminate,
    strains: Floats,
    ply: int,
    surface: Surface = "middle",
    criterion: Criterion = "tsai-wu",
    T_N: Floats | float = 0.0,
    T_M: Floats | float = 0.0,
) -> Floats:
    """Failure index of one ply; 1 is failure.

    Args:
        laminate: section whose plies have strengths.
        strains: (eps, kap) of the reference surface [-, 1/m], shape (..., 6).
        ply: number of the ply, 0 at the bottom; -1 is the topmost.
        surface: height within the ply.
        criterion: see :mod:`lamella.material.failure`.
        T_N: change of temperature at the reference surface [K], shape (...) or scalar.
        T_M: gradient of temperature through the thickness [K/m], shape (...) or scalar.

    Returns:
        Index [-], shape (...).

    Raises:
        DeclarationError: no such ply, surface or criterion, or strengths that are not given.
    """
    _accept("criterion", criterion, Criterion)
    stress = ply_stress(laminate, strains, ply, surface, "fibre", T_N, T_M)
    lamina = laminate.laminas[_ply_number(laminate, ply)]
    return tsai_wu(stress, lamina) if criterion == "tsai-wu" else tsai_hill(stress, lamina)


def _height(laminate: Laminate, ply: int, surface: Surface) -> float:
    _accept("surface", surface, Surface)
    share = {"bottom": 0.0, "middle": 0.5, "top": 1.0}[surface]
    return float((1.0 - share) * laminate.z[ply] + share * laminate.z[ply + 1])


def _ply_number(laminate: Laminate, ply: int) -> int:
    n = len(laminate.layers)
    if not -n <= ply < n:
        raise DeclarationError("Laminate", f"ply = {ply}", f"accepted is 0 (bottom) to {n - 1} (top)")
    return ply % n


def _accept(what: str, value: object, accepted: object) -> None:
    if value not in get_args(accepted):
        raise DeclarationError("Laminate", f"{what} = {value!r}", f"accepted is {', '.join(get_args(accepted))}")

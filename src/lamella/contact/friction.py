"""Laws of friction."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

from lamella.declaration import declaration
from lamella.units import quantity

if TYPE_CHECKING:
    Speed = BristleStiffness = BristleDamping = float
else:
    Speed = quantity("m/s", gt=0)
    BristleStiffness = quantity("N/m^3", gt=0)
    BristleDamping = quantity("N*s/m^3", ge=0)


@declaration
class RegularisedFriction:
    """Friction in proportion to slow slip: mu N v / sqrt(v.v + v_d^2). Smooth, but what is at rest under a force creeps.

    Args:
        velocity: v_d, the slip at which 71 % of mu N is reached [m/s]; creep is v_d T / (mu N) for a small force T.
    """

    velocity: Speed = 1e-3
    kind: Literal["regularised"] = "regularised"


@declaration
class BristleFriction:
    """Friction that holds: a spring from each point to where it sticks, which slides rather than pull more than mu N.

    Args:
        stiffness: k_t per area [N/m^3].
        damping: c_t per area [N s/m^3]; without it a body that has come to rest rings on its bristles.
    """

    stiffness: BristleStiffness
    damping: BristleDamping = 0.0
    kind: Literal["bristle"] = "bristle"


Friction = RegularisedFriction | BristleFriction

"""Forces that events switch on and off, and that controllers hold at a level."""

from __future__ import annotations

from typing import ClassVar

from lamella.roles import Floats, ForceBlock


class SwitchedForce(ForceBlock):
    """A force block that acts only while it is switched on.

    Args:
        block: the block.
        on: whether it acts at the start of a run.
    """

    remembered: ClassVar[tuple[str, ...]] = ("on", "block")

    def __init__(self, block: ForceBlock, *, on: bool) -> None:
        self.block, self.on, self._at_start = block, on, on
        self.name, self.symmetry, self.depends_on_velocity = block.name, block.symmetry, block.depends_on_velocity
        self.varies, self.first_order = block.varies, block.first_order
        self.f_coords, self.f_scale = block.f_coords, block.f_scale
        self.k_rows, self.k_cols, self.k_scale = block.k_rows, block.k_cols, block.k_scale

    @property
    def depends_on_time_alone(self) -> bool:
        """False: at the moment of switching the force has two values."""
        return False

    def force(self, t: float, q: Floats, v: Floats, f: Floats) -> None:
        if self.on:
            self.block.force(t, q, v, f)
        else:
            f[:] = 0.0

    def force_tangent(
        self, t: float, q: Floats, v: Floats, alpha_q: float, alpha_v: float, q_previous: Floats, f: Floats, k: Floats
    ) -> None:
        if self.on:
            self.block.force_tangent(t, q, v, alpha_q, alpha_v, q_previous, f, k)
        else:
            f[:], k[:] = 0.0, 0.0

    def energy(self, t: float, q: Floats) -> float:
        return self.block.energy(t, q) if self.on else 0.0

    def dissipation(self, t: float, q: Floats, v: Floats) -> float:
        return self.block.dissipation(t, q, v) if self.on else 0.0

    def settle(self, t: float, q: Floats) -> None:
        self.block.settle(t, q)

    def settled_heat(self) -> float:
        return self.block.settled_heat()

    def reset(self) -> None:
        self.on = self._at_start
        self.block.reset()


class HeldForce(SwitchedForce):
    """A force block that is multiplied by a level which stays the same for a while; it is off at the start of a run.

    Args:
        block: the block.
    """

    remembered: ClassVar[tuple[str, ...]] = ("on", "block", "level")
    level: float = 0.0

    def __init__(self, block: ForceBlock) -> None:
        super().__init__(block, on=True)

    def force(self, t: float, q: Floats, v: Floats, f: Floats) -> None:
        super().force(t, q, v, f)
        f *= self.level

    def force_tangent(
        self, t: float, q: Floats, v: Floats, alpha_q: float, alpha_v: float, q_previous: Floats, f: Floats, k: Floats
    ) -> None:
        super().force_tangent(t, q, v, alpha_q, alpha_v, q_previous, f, k)
        f *= self.level
        k *= self.level

    def energy(self, t: float, q: Floats) -> float:
        return self.level * super().energy(t, q)

    def dissipation(self, t: float, q: Floats, v: Floats) -> float:
        return self.level * super().dissipation(t, q, v)

    def reset(self) -> None:
        super().reset()
        self.level = 0.0

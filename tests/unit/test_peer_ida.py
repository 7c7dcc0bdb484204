"""BDF beside IDA of SUNDIALS (Hindmarsh and others 2005) on the same equations; needs the extra ``peers`` (scikit-sundae)."""

from __future__ import annotations

import numpy as np
import pytest
from test_stabilised import double_pendulum

import lamella as lm
from lamella.assembly.equations import Equations
from lamella.assembly.point import Point
from lamella.solve.initial import make_consistent
from lamella.solve.linear import linear_solver

sun = pytest.importorskip("sksundae")


def plate_on_a_rod():
    """A stiff plate, one element, that hangs on a rod and swings: its own vibrations are fast, and hardly excited."""
    section = lm.Laminate(lm.Isotropic(E=2e7, nu=0.3, rho=1200.0), thickness=0.04)
    system, ground = lm.System(), lm.Ground()
    system.add(ground)
    plate = system.add(lm.Plate("plate", (0.4, 0.6), (1, 1), section, rotation=(np.pi / 2, 0, 0)))
    system.add(lm.DistanceJoint("rod", ground.marker("peg", 0.2, 0.5, 1.0), plate.marker("hook", 0.2, 0.6)))
    system.add(lm.Gravity("weight", (0, 0, -9.81), lm.SmoothStep(t_end=0.2)))
    return system


class StabilisedResidual:
    """u' - v + W Phi_q^T mu, r(u, v, v', lam), Phi and Phi_q v + Phi_t of the unknown y = (u, v, lam, mu), for IDA."""

    def __init__(self, system):
        self.equations = Equations(system.compile())
        start = self.equations.start()
        make_consistent(self.equations, start, linear_solver(self.equations.matrix.pattern, "auto"))
        n, m = self.equations.n_u, self.equations.n_lam
        self.cuts, self.algebraic = [n, 2 * n, 2 * n + m], np.arange(2 * n, 2 * n + 2 * m)
        self.y = np.concatenate([start.u, start.ud, start.lam, np.zeros(m)])
        self.yp = np.concatenate([start.ud, start.udd, np.zeros(2 * m)])
        self.calls = 0

    def __call__(self, t, y, yp, res):
        self.calls += 1
        u, v, lam, mu = np.split(np.asarray(y), self.cuts)
        du, dv = np.split(np.asarray(yp), self.cuts)[:2]
        point = Point(t, u.copy(), v.copy(), dv.copy(), lam.copy())
        W = self.equations.magnitude**2
        r, phi = self.equations.residual(point)
        psi = self.equations.velocity_violation(point)
        res[:] = np.concatenate([du - v + W * (self.equations.jacobian(point).T @ mu), r, phi, psi])

    def solve(self, t_end, tolerance):
        """u at the end."""
        n, m = self.cuts[0], len(self.algebraic) // 2
        loose = np.full(2 * m, 1e3)  # multipliers follow, they have no say in the error
        size = np.concatenate([self.equations.magnitude, self.equations.magnitude])
        solver = sun.ida.IDA(
            self,
            rtol=1e-13,
            atol=np.concatenate([tolerance * size, loose]),
            algebraic_idx=self.algebraic,
            max_num_steps=100000,
        )
        found = solver.solve(np.array([0.0, t_end]), self.y, self.yp)
        assert found.success, found.message
        return found.y[-1][:n], found


@pytest.mark.parametrize(("make", "t_end", "tolerance"), [(double_pendulum, 0.5, 1e-8), (plate_on_a_rod, 0.1, 1e-10)])
def test_the_same_motion_within_the_tolerances(make, t_end, tolerance):
    peer = StabilisedResidual(make())
    u, found = peer.solve(t_end, tolerance)
    result = lm.simulate(make(), t_end, lm.BDF(dt=1e-3, tolerance=tolerance, max_order=5))
    equations = peer.equations
    own = result.final.q[equations.elimination.independent]
    counts = result.statistics
    print(f"{make.__name__}: residuals: IDA {found.nfev} and {peer.calls - found.nfev} for Jacobians, lamella {counts.residuals}")
    positions = equations.model.is_position[equations.elimination.independent // 3]
    # both keep local errors of the tolerance in some hundred steps, which the motion stretches less than tenfold
    assert np.abs((own - u) / equations.magnitude)[positions].max() < tolerance * 10 * counts.steps
    assert np.abs(own - equations.start().u).max() > 1e3 * np.abs(own - u).max()  # it moves

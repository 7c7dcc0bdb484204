"""A closed belt that spins: hoop strain and ring frequencies in its frame, set free in motion, and spun up at once."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy.optimize import minimize_scalar

import lamella as lm
from lamella.model import Model
from lamella.result import Result
from lamella.roles import Floats
from lamella.state import State
from lamella.verification import Curves, Evidence, References
from lamella.verification.belt import E_X, LENGTH, RADIUS, RHO, WAVES, belt, rayleigh

slow = True

SPIN = 50.0
MESH = (40, 1)
PERIOD = 2 * np.pi * RADIUS * np.sqrt(RHO / E_X)
"""Of breathing [s]."""


def run() -> Iterator[Evidence]:
    """Yield the checks and pictures of this case."""
    references = References.beside(__file__)
    result = spun(SPIN)
    yield references.check("hoop strain of steady spin", hoop_strain(result.model, result.final.q))
    yield references.check("spread of the radius over the nodes", spread(result))
    yield from frequencies(references)
    yield from set_free(references, result.final.q)
    yield from spun_up(references)


def spun(rate: float) -> Result:
    """The ring in the frame that spins about z, held where its growth moves nothing."""
    system = belt(MESH)
    (shell,) = system.declarations
    assert isinstance(shell, lm.Shell)
    for k, axes in enumerate(("yz", "xz", "yz")):
        system.add(lm.PointSupport(f"hold {k}", shell.marker(f"held {k}", k * LENGTH / 4, 0.0), axes))
    system.add(lm.SteadySpin("spin", (0.0, 0.0, rate)))
    return lm.equilibrium(system)


def hoop_strain(model: Model, q: Floats) -> float:
    """Mean Green strain along the belt."""
    return float(model.plates[0].sample(q, 8).strains[:, :-1, 0].mean())


def radii(model: Model, q: Floats) -> Floats:
    """Distances of the nodes from the axis [m]."""
    x, y, _ = model.vectors(q)[model.is_position].T
    return np.hypot(x, y)


def spread(result: Result) -> float:
    """Largest difference of the nodes' distances from the axis [m]."""
    return float(np.ptp(radii(result.model, result.final.q)))


def frequencies(references: References) -> Iterator[Evidence]:
    """Travelling waves seen from the frame, at several rates."""
    rates, found = np.array([5.0, 15.0, 30.0, SPIN]), []
    for rate in rates:
        system = belt(MESH)
        system.add(lm.SteadySpin("spin", (0.0, 0.0, rate)))
        found.append(waves(lm.modes(system, 36, state=spun(rate).final)))
        for k, way in enumerate(("forward", "backward")):
            name = f"{way} waves at {rate:g} rad/s over the closed form, number"
            yield from references.checks(name, found[-1][:, k] / travelling(rate)[:, k])
    many = np.linspace(0.0, SPIN, 26)
    exact = np.array([travelling(rate) for rate in many])
    labels = [(i, k, f"{n} waves {way}") for i, n in enumerate(WAVES) for k, way in enumerate(("forward", "backward"))]
    yield Curves(
        "Waves seen from the ring",
        "Spin [rad/s]",
        "Frequency [Hz]",
        {label: (many, exact[:, i, k]) for i, k, label in labels},
        {f"lamella, {label}": (rates, [f[i, k] for f in found]) for i, k, label in labels},
    )


def travelling(rate: float) -> Floats:
    """Frequencies [Hz] of the inextensible spinning ring, seen from it; rows are 2, 3, 4 waves, columns forward and backward."""
    n = WAVES
    root = np.sqrt((n * (n**2 - 1) / (n**2 + 1) * rate) ** 2 + (2 * np.pi * rayleigh()) ** 2)
    drag = 2 * n * rate / (n**2 + 1)
    return np.stack([root - drag, root + drag], axis=1) / (2 * np.pi)


def waves(modes: lm.Modes) -> Floats:
    """Frequencies [Hz] of the modes with the largest part of exp(i (omega t -+ n theta)), forward and backward, shape (3, 2)."""
    assert modes.quadrature is not None
    mesh, r = modes.model.plates[0], modes.model.vectors(modes.state)
    lower, upper = ([mesh.vector(int(k), "r") for k in mesh.edge_nodes(side)] for side in ("y-", "y+"))
    shapes = (modes.shapes + 1j * modes.quadrature).reshape(-1, 3, modes.shapes.shape[1])
    mean = 0.5 * (shapes[lower] + shapes[upper])  # over the width, which leaves out the modes that tilt
    angle = np.arctan2(r[lower, 1], r[lower, 0])
    radial = np.cos(angle)[:, None] * mean[:, 0] + np.sin(angle)[:, None] * mean[:, 1]
    parts = [np.abs(np.exp(sign * 1j * np.outer(WAVES, angle)) @ radial) for sign in (1, -1)]
    share = np.stack(parts, axis=1) / np.linalg.norm(shapes, axis=(0, 1))
    return modes.frequencies[share.argmax(axis=2)]


def set_free(references: References, q: Floats) -> Iterator[Evidence]:
    """The state of steady spin in the inertial frame, without supports, for one turn."""
    model = belt(MESH).compile()
    start = turning(model, q)
    turn = lm.simulate(model, 2 * np.pi / SPIN, lm.GeneralizedAlpha(dt=5e-4, rho_inf=0.9), initial=start)
    yield references.check("set free: hoop strain after a turn", hoop_strain(model, turn.final.q))
    yield references.check("set free: spread of the radius over the nodes after a turn", spread(turn))
    energy = turn.samples("energy.kinetic") + turn.samples("energy.strain")
    yield references.check("set free: energy lost", float(np.abs(energy / energy[0] - 1).max()))
    before, after = (spin_momentum(model, state) for state in (start, turn.final))
    yield references.check("set free: angular momentum lost", abs(after / before - 1))


def turning(model: Model, q: Floats) -> State:
    """The coordinates q turning about z."""
    v = np.cross((0.0, 0.0, SPIN), model.vectors(q)).reshape(-1)
    return State(0.0, q, v, np.zeros_like(q), np.zeros(model.n_lam), np.zeros(0))


def spin_momentum(model: Model, state: State) -> float:
    """Angular momentum about z [kg m^2/s]."""
    x, p = model.vectors(state.q), model.vectors(model.mass @ state.v)
    return float(np.sum(x[:, 0] * p[:, 1] - x[:, 1] * p[:, 0]))


def spun_up(references: References) -> Iterator[Evidence]:
    """The unstretched ring that turns all at once: it breathes about the strain of steady spin."""
    model = belt((20, 1)).compile()
    integrator = lm.GeneralizedAlpha(dt=PERIOD / 120, rho_inf=1.0)
    result = lm.simulate(model, 3 * PERIOD, integrator, initial=turning(model, model.q0))
    t, r = result.at, np.hypot(*result.samples("node.position")[:, :2].T)
    strain = 0.5 * ((r / RADIUS) ** 2 - 1)

    def fitted(frequency: float) -> tuple[float, float]:
        """Constant part and square of the misfit of a harmonic."""
        columns = np.stack([np.ones_like(t), np.cos(2 * np.pi * frequency * t), np.sin(2 * np.pi * frequency * t)], axis=1)
        parts = np.linalg.lstsq(columns, strain)[0]
        return float(parts[0]), float(np.sum((columns @ parts - strain) ** 2))

    frequency = minimize_scalar(lambda f: fitted(f)[1], bounds=(0.8 / PERIOD, 1.2 / PERIOD), method="bounded").x
    yield references.check("spun up: mean hoop strain", fitted(frequency)[0])
    yield references.check("spun up: breathing frequency", frequency)
    steady = RHO * (SPIN * RADIUS) ** 2 / E_X
    yield Curves(
        "Spun up all at once",
        "Time [s]",
        "Hoop strain [–]",
        {"lamella": (t, strain)},
        {"rho v^2/E (1 - cos omega t)": (t[::12], steady * (1 - np.cos(2 * np.pi * t[::12] / PERIOD)))},
    )

"""Balanced truncation, responses and files of first-order models."""

from __future__ import annotations

import numpy as np
import pytest
from linear_systems import cantilever, hub, pendulum
from scipy import linalg, signal
from scipy.io import loadmat

import lamella as lm
from lamella.errors import DeclarationError, ModelError, ResultFileError
from lamella.study.linear_outputs import describe


@pytest.fixture(scope="module")
def plate():
    system = cantilever(damping=3e-4)
    return lm.linearise(system, ("load",), ("tip.position.z", "tip.velocity.z")).state_space(10)


def largest_error(model, reduced):
    """Largest singular value of the difference of the transfer matrices, over frequencies dense at the vibrations."""
    poles = model.poles()
    f = np.concatenate([np.logspace(-2, 5, 400), poles.imag[poles.imag > 0.0] / (2 * np.pi)])
    difference = model.frequency_response(f) - reduced.frequency_response(f)
    return np.linalg.norm(difference, ord=2, axis=(1, 2)).max()


@pytest.mark.parametrize("order", [2, 4, 7])
def test_error_of_balanced_truncation_lies_within_its_bounds(plate, order):
    reduced = plate.balanced(order)
    assert reduced.n_states == order
    assert reduced.is_stable
    error = largest_error(plate, reduced)
    # at most twice the sum of the singular values left out; no model of this order errs by less than the first of them (Glover)
    assert reduced.hankel[order] * (1 - 1e-6) < error < reduced.error_bound * (1 + 1e-6)
    assert reduced.error_bound == pytest.approx(2 * reduced.hankel[order:].sum())


def test_a_model_without_states_that_nothing_drives_or_sees_says_so(plate):
    """A plate that is pushed at its middle neither twists nor bends sideways: there are fewer states than asked for."""
    whole, told = plate.balanced(20), "; no further states are both reached by inputs and seen in outputs"
    assert whole.n_states == 14
    assert describe(whole) == f"14 states, 1 input, 2 outputs, stable{told}"
    assert largest_error(plate, whole) < 1e-11 * whole.hankel[0]
    assert not any(told in describe(model) for model in (plate, plate.balanced(12)))


def test_hankel_singular_values_of_a_first_order_system():
    """b c / (s + a) has the one value b c / 2a."""
    model = lm.StateSpace(
        *(np.array([[x]]) for x in (-2.0, 3.0, 5.0, 0.0)), ("u",), ("y",), ("1",), ("1",), np.zeros(1), np.zeros(1)
    )
    found = model.balanced(1)
    assert found.hankel == pytest.approx([3.0 * 5.0 / 4.0])
    assert found.error_bound == 0.0
    assert found.dc_gain()[0, 0] == pytest.approx(7.5)


def test_rigid_body_motion_is_kept_and_what_is_damped_is_reduced():
    undamped = lm.linearise(hub(), ("motor",), ("pin.angle",)).state_space(3)
    with pytest.raises(ModelError, match=r"8 of 8 poles are not stable .* more than order = 4"):
        undamped.balanced(4)
    damped = lm.linearise(hub(damping=1e-4), ("motor",), ("pin.angle",)).state_space(3)
    reduced = damped.balanced(4)
    # the double integrator is there as it was
    slow = np.array([1e-3])
    assert reduced.frequency_response(slow)[0, 0, 0] == pytest.approx(damped.frequency_response(slow)[0, 0, 0], rel=1e-6)
    assert np.sort(np.abs(reduced.poles()))[1] < 1e-6
    assert largest_error(damped, reduced) < reduced.error_bound * (1 + 1e-6)


def test_a_growing_pole_is_kept():
    model = lm.linearise(pendulum(angle=np.pi), ("motor",), ("pin.angle",)).state_space()
    reduced = model.balanced(1)
    assert reduced.poles().real == pytest.approx([model.poles().real.max()])
    with pytest.raises(DeclarationError, match="order = 3; accepted is 1 to 2"):
        model.balanced(3)


def test_bounds_of_two_reductions_add(plate):
    first = plate.balanced(8)
    second = first.balanced(4)
    assert second.error_bound > first.error_bound
    assert largest_error(plate, second) < second.error_bound


def test_scaled_inputs_and_outputs(plate):
    model = plate.scaled([10.0], [1e-3, 1e-2])
    np.testing.assert_allclose(model.dc_gain(), plate.dc_gain() * 10.0 / [[1e-3], [1e-2]])
    assert model.output_units == ("1", "1")
    with pytest.raises(DeclarationError, match="a positive one for each"):
        plate.scaled([10.0], [1e-3, -1.0])
    with pytest.raises(DeclarationError, match=r"scaled: inputs = \[inf\]; accepted is a positive one for each of load"):
        plate.scaled([np.inf], [1e-3, 1.0])
    with pytest.raises(DeclarationError, match=r"scaled: inputs = \{'load': 1.0\}; accepted is a list of numbers"):
        plate.scaled({"load": 1.0}, [1e-3, 1.0])


def test_response_is_exact_for_inputs_that_are_linear_between_the_times(plate):
    t = np.linspace(0.0, 0.2, 101)
    u = np.sin(40.0 * t)[:, None]
    _, expected, _ = signal.lsim((plate.A, plate.B, plate.C, plate.D), u, t)
    np.testing.assert_allclose(plate.response(t, u), expected, rtol=1e-8, atol=1e-12)
    for times, inputs, said in (
        (t**2, u, "equally spaced"),
        (t[::-1], u, "two, ascending and equally spaced"),
        (t, u[:5], r"accepted are 1 for each of 101 times"),
        (t, u * np.nan, r"response: inputs = \[\[nan\], .*; accepted are finite numbers"),
        (t, "sine", r"response: inputs = 'sine'; accepted is a list of numbers"),
    ):
        with pytest.raises(DeclarationError, match=said):
            plate.response(times, inputs)
    with pytest.raises(DeclarationError, match="there is no input 'lod'; accepted are load"):
        plate.step_response(t, "lod")
    for times, said in (
        (5.0, "at least two"),
        (None, "at least two"),
        ("1 s", "times = '1 s'; accepted is a list of"),
    ):
        with pytest.raises(DeclarationError, match=said):
            plate.step_response(times, "load")


def test_a_model_with_a_pole_at_zero_has_no_gain():
    with pytest.raises(ModelError, match="a pole at zero"):
        lm.linearise(hub(), ("motor",), ("pin.angle",)).state_space(3).dc_gain()


def blocks(*parts):
    """A model whose matrix has these blocks on its diagonal, with an input and an output for all states."""
    A = linalg.block_diag(*parts)
    one = np.ones((len(A), 1))
    return lm.StateSpace(A, one, one.T, np.zeros((1, 1)), ("u",), ("y",), ("1",), ("1",), np.zeros(1), np.zeros(1))


def oscillator(frequency, damping):
    return np.array([[0.0, 1.0], [-(frequency**2), -2.0 * damping * frequency]])


def test_slow_poles_that_decay_beside_fast_ones_are_stable():
    """Stiff damping has poles a million of millions times faster than a temperature; real parts are known better than by that."""
    model = blocks([[-5e8]], [[-1e-3]], oscillator(1.7, 4e-4))
    assert model.is_stable
    assert model.dc_gain()[0, 0] == pytest.approx(1000.0 + 2.0 * 4e-4 / 1.7 + 1.0 / 1.7**2 - 1.0, rel=1e-9)
    assert model.balanced(3).n_states == 3
    assert not blocks([[-5e8]], oscillator(1.7, 0.0)).is_stable
    assert not blocks([[-5e8]], oscillator(1e5, 0.0)).is_stable


@pytest.mark.parametrize("stiffness", [4.8e-12, -4.8e-12, 0.0])
def test_what_rounding_makes_of_a_free_motion_are_poles_at_zero(stiffness):
    """The pair of poles is real or imaginary, by the sign of what is left of the stiffness."""
    model = blocks([[0.0, 1.0], [-stiffness, 0.0]], oscillator(2e4, 1e-3))
    with pytest.raises(ModelError, match="a pole at zero"):
        model.dc_gain()
    with pytest.raises(ModelError, match="2 of 4 poles are not stable"):
        model.balanced(1)


def test_a_frequency_at_a_pole_is_refused():
    model = lm.linearise(hub(), ("motor",), ("pin.angle",)).state_space(3)
    with pytest.raises(ModelError, match=r"at 0 Hz is a pole"):
        model.frequency_response(np.array([1.0, 0.0]))


def test_models_are_saved_and_read(plate, tmp_path):
    reduced = plate.balanced(4)
    for model in (plate, reduced):
        again = lm.StateSpace.load(model.save(tmp_path / "model.npz"))
        for name in ("A", "B", "C", "D", "input_values", "output_values"):
            np.testing.assert_array_equal(getattr(again, name), getattr(model, name))
        assert (again.inputs, again.outputs, again.input_units, again.output_units) == (
            ("load",),
            ("tip.position.z", "tip.velocity.z"),
            ("1",),
            ("m", "m/s"),
        )
        assert again.error_bound == model.error_bound
    found = loadmat(reduced.save(tmp_path / "model.mat"))
    np.testing.assert_array_equal(found["A"], reduced.A)
    assert [str(name[0]) for name in found["outputs"].ravel()] == ["tip.position.z", "tip.velocity.z"]
    with pytest.raises(ResultFileError, match=r"unknown suffix '.txt'; accepted are .npz and .mat"):
        plate.save(tmp_path / "model.txt")
    (tmp_path / "other.npz").write_text("nothing")
    np.save(tmp_path / "array.npy", np.eye(2))
    for name in ("other.npz", "array.npy", "model.mat"):
        with pytest.raises(ResultFileError, match=rf"{name}' is no linear model; accepted is a .npz that save wrote"):
            lm.StateSpace.load(tmp_path / name)
    with pytest.raises(ResultFileError, match=r"none.npz' cannot be read: No such file"):
        lm.StateSpace.load(tmp_path / "none.npz")
    for suffix in (".npz", ".mat"):
        with pytest.raises(ResultFileError, match=rf"model{suffix}' cannot be written: No such file or directory; accepted"):
            plate.save(tmp_path / "none" / f"model{suffix}")


def test_model_for_python_control(plate):
    control = pytest.importorskip("control")
    model = plate.to_control()
    assert model.input_labels == ["load"]
    assert model.output_labels == ["tip_position_z", "tip_velocity_z"]
    np.testing.assert_allclose(control.dcgain(model), plate.dc_gain(), atol=1e-12)


def test_missing_python_control_is_told(plate, monkeypatch):
    import sys

    from lamella.errors import MissingExtraError

    monkeypatch.setitem(sys.modules, "control", None)
    with pytest.raises(MissingExtraError, match=r"pip install 'lamella\[control\]'"):
        plate.to_control()


@pytest.mark.parametrize("frequencies", [[], [1.0, float("nan")], 5.0, "5 Hz"])
def test_frequencies_that_are_none_are_refused(plate, frequencies):
    with pytest.raises(DeclarationError, match=r"frequency_response: frequencies = .*; accepted is "):
        plate.frequency_response(frequencies)


@pytest.mark.parametrize("damping", [-1.5e-14, 0.0, 1e-16, 1.5e-14])
def test_what_rounding_leaves_of_a_rigid_body_motion_counts_as_zero(damping):
    """x'' = u beside a vibration of 1216 rad/s, with a damping of either sign that is less than its last digit."""
    A = np.zeros((4, 4))
    A[:2, :2], A[2:, 2:] = [[0.0, 1.0], [0.0, -damping]], [[0.0, 1.0], [-(1216.0**2), -100.0]]
    B, C = np.array([[0.0], [1.0], [0.0], [1.0]]), np.array([[1.0, 0.0, 1.0, 0.0]])
    model = lm.StateSpace(A, B, C, np.zeros((1, 1)), ("u",), ("y",), ("1",), ("1",), np.zeros(1), np.zeros(1))
    reduced = model.balanced(2)
    assert np.abs(reduced.poles()).max() < 1e-6
    slow = np.array([1e-3])
    assert reduced.frequency_response(slow)[0, 0, 0] == pytest.approx(-1.0 / (2e-3 * np.pi) ** 2, rel=1e-6)

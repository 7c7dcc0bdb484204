"""Functions of time: one conformance test over all of them, values of each, files, coercion and messages."""

from __future__ import annotations

import math
import pickle
from dataclasses import FrozenInstanceError
from itertools import pairwise
from pathlib import Path
from typing import get_args

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lamella.declaration import declaration
from lamella.errors import DeclarationError
from lamella.math.profile import (
    AnyProfile,
    Constant,
    Cycloid,
    Harmonic,
    Integral,
    LengthProfile,
    Polynomial,
    Profile,
    Ramp,
    SmoothStep,
    Step,
    Table,
    TimeFunction,
    TrapezoidalSpeed,
)
from lamella.math.time_function import Integrable

TIMES, VALUES = (0.0, 0.3, 0.5, 1.2), (1.0, 3.0, 2.0, 2.5)
# Where the third derivatives of the catalogue jump: points of tables, ends, and corners of the accelerations.
KNOTS = (*TIMES, 0.2, 0.9, 0.3, 0.45, 0.65, 0.8, 0.25, 0.395, 0.445, 0.655, 0.705, 0.85)
CATALOGUE: list[TimeFunction] = [
    Constant(2.5),
    Step(3.0, at=0.4),
    Ramp(0.2, t_end=0.9, start=-1, end=2),
    SmoothStep(0.2, t_end=0.9, start=-1, end=2),
    Cycloid(0.2, t_end=0.9, start=2, end=-3),
    TrapezoidalSpeed(0.2, t_end=0.9, start=2, end=-3, ramp=0.1),
    TrapezoidalSpeed(0.2, t_end=0.9, start=2, end=-3, ramp=0.05, cruise=0.3),
    TrapezoidalSpeed(0.2, t_end=0.9, cruise=0.5),
    Polynomial((1.0, -2.0, 0.5, 3.0), 0.2, t_end=0.9),
    Harmonic(2.0, 1.5, phase=0.3, mean=-1),
    Table(TIMES, VALUES),
    Table(TIMES, VALUES, "pchip"),
    Table(TIMES, VALUES, "cubic"),
    Integral(Harmonic(2.0, 1.5, phase=0.3, mean=-1), start=0.4),
    Integral(SmoothStep(0.2, t_end=0.9, start=-1, end=2)),
]


@declaration
class Load:
    """Something with a profile, as the loads have."""

    profile: Profile = Constant(1.0)


@declaration
class Way:
    """Something with a profile that has a unit, as drives have."""

    way: LengthProfile = Constant(0.0)


def test_a_text_with_a_unit_stands_for_a_constant() -> None:
    assert Way("3 mm").way == Constant(3e-3)  # type: ignore[arg-type]


def test_every_kind_is_in_the_catalogue() -> None:
    assert {type(profile) for profile in CATALOGUE} == set(get_args(AnyProfile))


@pytest.mark.parametrize("profile", CATALOGUE, ids=str)
@given(t=st.floats(-0.5, 2.0))
def test_derivatives_match_differences(profile: TimeFunction, t: float) -> None:
    d = 1e-4
    if any(abs(t - jump) < 2 * d for jump in profile.breakpoints):
        return
    # Central differences of the value err by d^2/6 times the third derivative, at most some 2000 here (sine, quintic).
    tolerance = 2000 * d**2
    assert profile.rate(t) == pytest.approx((profile.value(t + d) - profile.value(t - d)) / (2 * d), abs=tolerance)
    if all(abs(t - knot) > 2 * d for knot in KNOTS):
        assert profile.acceleration(t) == pytest.approx((profile.rate(t + d) - profile.rate(t - d)) / (2 * d), abs=10 * tolerance)


@pytest.mark.parametrize("profile", CATALOGUE, ids=str)
def test_breakpoints_are_all_the_jumps(profile: TimeFunction) -> None:
    d = 1e-9
    derivatives = (profile.value, profile.rate, profile.acceleration)
    breakpoints = profile.breakpoints
    assert list(breakpoints) == sorted(set(breakpoints))
    for t in {*TIMES, 0.2, 0.4, 0.9, *breakpoints}:
        jumps = any(abs(f(t + d) - f(t - d)) > 1e-4 for f in derivatives)  # 1e-4: far above the change over 2 ns
        assert jumps == (t in breakpoints), t
        assert [f(t) for f in derivatives] == pytest.approx([f(t + d) for f in derivatives], abs=1e-5)  # the value after the jump


@pytest.mark.parametrize("profile", CATALOGUE, ids=str)
def test_profiles_are_frozen_portable_and_give_plain_floats(profile: TimeFunction) -> None:
    assert all(type(f(0.31)) is float for f in (profile.value, profile.rate, profile.acceleration))
    assert pickle.loads(pickle.dumps(profile)) == profile  # noqa: S301  # workers of a parallel study receive profiles so
    with pytest.raises(FrozenInstanceError):
        profile.kind = "other"  # type: ignore[attr-defined]


@pytest.mark.parametrize("cls", [Ramp, SmoothStep, Cycloid])
def test_transitions_run_from_start_to_end(cls) -> None:
    profile = cls(1.0, t_end=3.0, start=2.0, end=6.0)
    assert [profile.value(t) for t in (-5.0, 1.0, 2.0, 3.0, 9.0)] == pytest.approx([2.0, 2.0, 4.0, 6.0, 6.0])


@pytest.mark.parametrize("cls", [Ramp, SmoothStep, Cycloid])
def test_a_transition_of_almost_no_duration_is_a_jump(cls) -> None:
    jump = cls(t_end=1e-200, end=3.0)
    assert [jump.value(t) for t in (-1.0, 0.0, 1.0)] == [0.0, 0.0, 3.0]
    assert [jump.acceleration(t) for t in (-1.0, 0.0, 1.0)] == [0.0, 0.0, 0.0]


def test_peaks_of_the_smooth_transitions() -> None:
    """Known factors over 1 s: quintic 15/8 and 10/sqrt(3), cycloid 2 and 2 pi."""
    smooth, cycloid = SmoothStep(t_end=1.0), Cycloid(t_end=1.0)
    assert smooth.rate(0.5) == pytest.approx(15 / 8)
    assert smooth.acceleration(0.5 - 1 / np.sqrt(12)) == pytest.approx(10 / np.sqrt(3))
    assert cycloid.rate(0.5) == pytest.approx(2.0)
    assert cycloid.acceleration(0.25) == pytest.approx(2 * np.pi)


def test_harmonic_has_its_period_in_hertz() -> None:
    wave = Harmonic(2.0, "4 Hz", phase="90 deg", mean=1.0)  # type: ignore[arg-type]
    assert [wave.value(t) for t in (0.0, 0.125, 0.25)] == pytest.approx([3.0, -1.0, 3.0])


@given(st.lists(st.floats(-100, 100), min_size=3, max_size=8), st.floats(0, 1))
def test_pchip_does_not_overshoot(values: list[float], share: float) -> None:
    table = Table(tuple(range(len(values))), tuple(values), "pchip")
    t = share * (len(values) - 1)
    k = min(int(t), len(values) - 2)
    low, high = sorted(values[k : k + 2])
    assert low - 1e-12 * 100 <= table.value(t) <= high + 1e-12 * 100  # rounding of values of at most 100


@pytest.mark.parametrize("interpolation", ["linear", "pchip", "cubic"])
def test_tables_pass_their_points_and_stay_constant_outside(interpolation) -> None:
    table = Table(TIMES, VALUES, interpolation)
    assert [table.value(t) for t in TIMES] == pytest.approx(VALUES, rel=1e-14)
    assert [table.value(t) for t in (-1.0, 7.0)] == [1.0, 2.5]
    assert [table.rate(t) for t in (-1.0, 1.2, 7.0)] == [0.0, 0.0, 0.0]


def test_linear_table_gives_slopes() -> None:
    table = Table((0, 1, 3), (0, 2, 0))
    assert [table.rate(t) for t in (0.0, 0.5, 1.0, 2.9)] == [2.0, 2.0, -1.0, -1.0]


def test_spline_reproduces_a_cubic() -> None:
    times = np.linspace(0, 2, 5)
    table = Table(tuple(times), tuple(times**3 - times), "cubic")
    assert table.value(0.7) == pytest.approx(0.7**3 - 0.7, rel=1e-12)
    assert table.acceleration(0.7) == pytest.approx(6 * 0.7, rel=1e-12)


def test_table_from_file(tmp_path: Path) -> None:
    path = tmp_path / "load.csv"
    path.write_text("\ufefftime [s], load\n# measured\n0, 1\n0.5, -2e-3  # last\n\n", encoding="utf-8")
    table = Table.from_csv(path, "pchip")
    assert (table.times, table.values, table.interpolation) == ((0.0, 0.5), (1.0, -2e-3), "pchip")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("0,1\n1,2,3\n", "line 2 has 3 columns; accepted is a text file with two columns"),
        ("0;1\n1;2\n", "line 1 has 1 columns"),
        ("t,f\n0,1\nx,2\n", "line 3 holds 'x,2'"),
        ("t,f\nu,v\n0,1\n", "line 2 holds 'u,v'"),
        ("0,1\n1,nan\n", "line 2 holds '1,nan', which is not finite"),
        ("0,1\n1,2\n1,3\n", "times 2 and 3 are 1 and 1; accepted are strictly increasing times"),
        ("0,1\n", "1 points; accepted are at least two"),
        ("", "0 points; accepted are at least two"),
    ],
)
def test_bad_files_are_refused(tmp_path: Path, text: str, message: str) -> None:
    path = tmp_path / "load.csv"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(DeclarationError, match=rf"Table '.*load\.csv': {message}"):
        Table.from_csv(path)


def test_missing_and_binary_files_are_refused(tmp_path: Path) -> None:
    with pytest.raises(DeclarationError, match="cannot be read: No such file or directory; accepted is a text file"):
        Table.from_csv(tmp_path / "absent.csv")
    (tmp_path / "binary.csv").write_bytes(b"\xff\xfe\x00\x81")
    with pytest.raises(DeclarationError, match="cannot be read: it is not text"):
        Table.from_csv(tmp_path / "binary.csv")


@pytest.mark.parametrize("number", [3, 3.0, np.float64(3.0), np.int64(3)])
def test_numbers_stand_for_constants(number) -> None:
    assert Load(profile=number).profile == Constant(3.0)


def test_profiles_from_a_file() -> None:
    assert Load({"kind": "ramp", "t_end": "500 ms"}).profile == Ramp(0, t_end=0.5)  # type: ignore[arg-type]
    assert Load({"kind": "table", "times": [0, "1 s"], "values": [0, 2]}).profile == Table((0, 1), (0, 2))  # type: ignore[arg-type]
    profile = Ramp(t_end=1)
    assert Load(profile).profile is profile


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Ramp(2, t_end=1), "Ramp: t_end = 1; accepted is a time later than t_start = 2"),
        (lambda: SmoothStep(t_end=0), "SmoothStep: t_end = 0; accepted is a time later than t_start = 0"),
        (lambda: Ramp(), "Ramp: 't_end' is missing"),  # type: ignore[call-arg]
        (lambda: Harmonic(1, 0), "Harmonic: frequency = 0; accepted is a value greater than 0"),
        (lambda: Harmonic(1, "60 rpm"), "'60 rpm' is an angular velocity; accepted is a number of periods per second"),  # type: ignore[arg-type]
        (lambda: Table((0, 1), (1,)), "Table: 2 times and 1 values; accepted is one value for each time"),
        (lambda: Table((0, 0), (1, 2)), "times 1 and 2 are 0 and 0; accepted are strictly increasing"),
        (lambda: Table((0, float("nan")), (1, 2)), r"times\.1 = nan; nan is not finite"),
        (lambda: Table((0, 1), (1, 2), "spline"), "interpolation = 'spline'; accepted is 'linear', 'pchip' or 'cubic'"),  # type: ignore[arg-type]
        (
            lambda: Load({"kind": "sine"}),
            "Load: profile = .*; accepted is a number, or a profile whose kind is one of constant, step",
        ),  # type: ignore[arg-type]
        (lambda: Load({"t_end": 1}), "a profile whose kind is one of"),  # type: ignore[arg-type]
        (lambda: Load(True), "profile = True; accepted is a number"),
        (lambda: Load(float("nan")), "profile = nan; .*nan is not finite"),  # type: ignore[arg-type]
        (lambda: Load({"kind": "step", "att": 1}), r"unknown argument 'profile\.step\.att'"),  # type: ignore[arg-type]
        (
            lambda: Integral({"kind": "rampp"}),
            "Integral: of = .*; accepted is a number, or a profile whose kind is one of constant, step",
        ),  # type: ignore[arg-type]
        (lambda: Integral({"kind": "ramp"}), r"Integral: 'of\.ramp\.t_end' is missing"),  # type: ignore[arg-type]
        (lambda: Integral(Integral(1.0)), "Integral: of = .*; accepted is a number, or a profile whose kind"),  # type: ignore[arg-type]
        (lambda: Load("fast"), "Load: profile = 'fast'; accepted is a number, or a profile whose kind is one of constant, step"),  # type: ignore[arg-type]
        (lambda: Load("3 mm"), "'3 mm' has the unit mm, which does not convert to a pure number"),  # type: ignore[arg-type]
        (lambda: Way("3 kg"), "'3 kg' has the unit kg, which does not convert to m"),  # type: ignore[arg-type]
        (lambda: Way("far"), "Way: way = 'far'; accepted is a number in m such as '1.5 m', or a profile whose kind"),  # type: ignore[arg-type]
    ],
)
def test_impossible_profiles_are_refused(make, message: str) -> None:
    with pytest.raises(DeclarationError, match=message):
        make()


def test_a_misspelt_method_is_refused() -> None:
    class Drift(TimeFunction):
        def valu(self, t: float) -> float:
            return t

    with pytest.raises(TypeError, match="abstract"):
        Drift()  # type: ignore[abstract]


def test_stretches_between_breakpoints_are_smooth() -> None:
    """Gauss integration of the rate over each stretch gives the change of the value, so nothing jumps inside."""
    nodes, weights = np.polynomial.legendre.leggauss(12)
    for profile in CATALOGUE:
        for a, b in pairwise(profile.breakpoints):
            change = (
                sum(w * profile.rate((a + b) / 2 + x * (b - a) / 2) for x, w in zip(nodes, weights, strict=True)) * (b - a) / 2
            )
            before = profile.value(b - 1e-12)  # just before a possible jump
            # 12 points are exact for each polynomial; a cubic table has knots inside, where only its third derivative jumps
            assert change == pytest.approx(before - profile.value(a), abs=2e-3)


INTEGRABLE = [profile for profile in CATALOGUE if isinstance(profile, Integrable)]


@pytest.mark.parametrize("profile", INTEGRABLE, ids=str)
@pytest.mark.parametrize("t", [-0.3, 0.1, 0.37, 0.55, 0.8, 1.7])
def test_integral_matches_quadrature(profile: Integrable, t: float) -> None:
    stops = sorted({0.0, t, *(b for b in (*profile.breakpoints, 0.2, 0.25, 0.3, 0.55, 0.9) if min(0.0, t) < b < max(0.0, t))})
    points, weights = np.polynomial.legendre.leggauss(40)
    total = 0.0
    for lo, hi in pairwise(stops):
        total += (
            0.5
            * (hi - lo)
            * sum(w * profile.value(0.5 * (lo + hi) + 0.5 * (hi - lo) * x) for x, w in zip(points, weights, strict=True))
        )
    assert profile.integral(t) == pytest.approx(total if t > 0 else -total, abs=2e-7)  # jerk jumps inside: 40 points leave 1e-8


@pytest.mark.parametrize("frequency", [1e-3, 1e-7, 1e-11])
def test_integral_of_a_slow_wave_keeps_its_digits(frequency: float) -> None:
    wave = Harmonic(2.0, frequency, phase=0.5)
    middle = math.sin(math.pi * frequency * 3.0 + 0.5)  # of the interval; the wave bends by (2 pi f t)^2/24 at the most
    assert wave.integral(3.0) == pytest.approx(6.0 * middle, rel=max(1e-14, (6.0 * math.pi * frequency) ** 2))


def test_trapezoidal_speed_has_the_shape_it_says() -> None:
    law = TrapezoidalSpeed(1.0, t_end=6.0, start=2.0, end=5.0, ramp=0.1)
    assert law.value(3.5) == pytest.approx(3.5)  # half the way at half the time
    assert (law.rate(1.0), law.acceleration(1.0)) == (0.0, 0.0)
    assert law.acceleration(2.0) == pytest.approx(law.acceleration(3.2))
    assert law.acceleration(2.0) == pytest.approx(-law.acceleration(5.0))
    assert law.acceleration(1.05) == pytest.approx(0.5 * law.acceleration(2.0))
    assert law.acceleration(3.41) == pytest.approx(0.9 * law.acceleration(2.0))  # the same jerk as at the start: two ramps to -a
    assert law.acceleration(3.5) == pytest.approx(0.0, abs=1e-12)
    assert law.acceleration(3.59) == pytest.approx(-0.9 * law.acceleration(2.0))
    cruising = TrapezoidalSpeed(0.0, t_end=4.0, cruise=0.5)
    assert cruising.rate(1.5) == cruising.rate(2.5) == pytest.approx(1 / 3)
    assert cruising.breakpoints == (0.0, 1.0, 3.0, 4.0)


def test_ramps_that_do_not_fit_are_refused() -> None:
    with pytest.raises(DeclarationError, match="ramp = 3 s; accepted is at most"):
        TrapezoidalSpeed(0.0, t_end=4.0, ramp=3.0)
    with pytest.raises(DeclarationError, match="at least one"):
        Polynomial((), t_end=1.0)

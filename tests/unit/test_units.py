"""Quantities: conversion of numbers and texts, and the messages for what is none."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import TypeAdapter, ValidationError

from lamella import units
from lamella.errors import LamellaError, UnitError
from lamella.remembered import Remembered
from lamella.units import Length, NonNegative, Thickness, Unit, quantity, to_si


@pytest.mark.parametrize(
    ("value", "unit", "expected"),
    [
        ("1.5 mm", "m", 1.5e-3),
        ("181 GPa", "Pa", 181e9),
        ("181GPa", "Pa", 181e9),
        ("2 kN/m", "N/m", 2e3),
        ("3 N*m", "N*m", 3.0),
        ("1560 kg/m^3", "kg/m^3", 1560.0),
        ("1.56 g/cm**3", "kg/m^3", 1560.0),
        ("90 deg", "rad", math.pi / 2),
        ("0.5 rad", "deg", math.degrees(0.5)),
        ("60 rpm", "rad/s", 2 * math.pi),
        ("2 ms", "s", 2e-3),
        ("12 ppm", "", 12e-6),
        ("50 percent", "", 0.5),
        ("1 mm/m", "", 1e-3),
        ("22.5e-6 1/K", "1/K", 22.5e-6),
        ("7", "m", 7.0),
        ("-1e-3", "N", -1e-3),
        (3, "m", 3.0),
        (np.float32(0.5), "m", 0.5),
        (np.int64(4), "m", 4.0),
        (np.array(2.0), "m", 2.0),
    ],
)
def test_conversion(value: object, unit: str, expected: float) -> None:
    converted = to_si(value, unit)
    assert type(converted) is float
    assert converted == pytest.approx(expected, rel=1e-14)


@given(st.floats(allow_nan=False, allow_infinity=False))
def test_numbers_are_si_and_unchanged(value: float) -> None:
    assert to_si(value, "m") == value


@given(st.floats(1e-6, 1e6))
def test_text_and_number_agree(value: float) -> None:
    assert to_si(f"{value!r} mm", "m") == pytest.approx(1e-3 * value, rel=1e-14)


@pytest.mark.parametrize(
    ("value", "unit", "message"),
    [
        (
            "1.5 kg",
            "m",
            "'1.5 kg' has the unit kg, which does not convert to m; accepted is a number in m or text such as '1.5 m'",
        ),
        ("1 m", "", "does not convert to a pure number; accepted is a plain number"),
        ("3 furlongz", "m", "'3 furlongz' is not a number with a known unit"),
        ("wide", "m", "'wide' is not a number with a known unit"),
        ("1 +", "m", "is not a number with a known unit"),
        (None, "m", "None is not a number; accepted is a number in m"),
        (True, "m", "True is not a number"),
        ("50 percent", "m", "does not convert to m"),
        ([1.0], "m", "is not a number"),
        (np.array([1.0, 2.0, 3.0]), "m", r"array\(\[1., 2., 3.\]\) is not a number; accepted is a number in m"),
        (math.nan, "m", "nan is not finite"),
        (math.inf, "m", "inf is not finite"),
        ("nan m", "m", "nan is not finite"),
    ],
)
def test_what_is_no_quantity_is_refused(value: object, unit: str, message: str) -> None:
    with pytest.raises(UnitError, match=message) as caught:
        to_si(value, unit)
    assert isinstance(caught.value, LamellaError)


def test_types_convert_and_hold_their_limits() -> None:
    assert TypeAdapter(Length).validate_python("-2 cm") == pytest.approx(-0.02)
    assert TypeAdapter(NonNegative).validate_python(0) == 0.0
    for wrong in (0, "-1 mm"):
        with pytest.raises(ValidationError, match="greater than 0"):
            TypeAdapter(Thickness).validate_python(wrong)
    with pytest.raises(ValidationError, match="less than 2"):
        TypeAdapter(quantity("m", lt=2)).validate_python(2)
    for kind, large in ((Length, -1e13), (quantity("Pa"), "1e12 GPa"), (NonNegative, 1e100)):
        with pytest.raises(ValidationError, match=r"is too large to compute with; accepted is at most 1e\+"):
            TypeAdapter(kind).validate_python(large)


def test_types_tell_their_unit() -> None:
    assert Unit("m") in Length.__metadata__  # type: ignore[attr-defined]
    assert TypeAdapter(Length).json_schema()["unit"] == "m"


@pytest.fixture(autouse=True)
def nothing_is_remembered(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Each test has Pint read its quantities, whatever an earlier run has left in the cache."""
    known = Remembered(tmp_path / "empty.json")
    monkeypatch.setattr(known, "write", lambda: None)
    monkeypatch.setattr(units, "_remembered", lambda: known)
    units._parse.cache_clear()


@pytest.mark.parametrize("spoiled", [False, True])
def test_the_cache_of_units_is_never_needed(spoiled: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(units, "user_cache_path", lambda name: tmp_path / name)
    if spoiled:
        units._registry.__wrapped__()
        for path in tmp_path.rglob("*.pickle"):
            path.write_bytes(b"cut of")
    else:
        (tmp_path / "lamella").write_text("a file where the folder should be")
    assert units._registry.__wrapped__().Quantity("1.5 mm").to("m").magnitude == 1.5e-3


def test_quantities_are_remembered_from_one_process_to_the_next(tmp_path: Path) -> None:
    path = tmp_path / "new" / "quantities.json"
    first = Remembered(path)
    assert first.get("1.5 mm", "m") is None
    assert first.put("1.5 mm", "m", 1.5e-3) == 1.5e-3
    first.put("1.5 mm", "km", 1.5e-6)
    first.write()
    later = Remembered(path)
    assert (later.get("1.5 mm", "m"), later.get("1.5 mm", "km")) == (1.5e-3, 1.5e-6)
    assert [file.name for file in path.parent.iterdir()] == ["quantities.json"]


@pytest.mark.parametrize("spoiled", ["", "cut o", "[1.0]", '{"1 mm\\nm": "1e-3"}', "\x00"])
def test_a_spoiled_memory_of_quantities_is_never_used(spoiled: str, tmp_path: Path) -> None:
    path = tmp_path / "quantities.json"
    path.write_text(spoiled)
    known = Remembered(path)
    assert known.get("1 mm", "m") is None
    known.put("1 mm", "m", 1e-3)
    known.write()
    assert Remembered(path).get("1 mm", "m") == 1e-3


def test_quantities_that_cannot_be_kept_are_read_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "folder").write_text("a file where the folder should be")
    known = Remembered(tmp_path / "folder" / "quantities.json")
    known.put("1 mm", "m", 1e-3)
    known.write()
    kept = Remembered(tmp_path / "quantities.json")
    kept.put("1 mm", "m", 1e-3)
    monkeypatch.setattr("os.replace", lambda *paths: (_ for _ in ()).throw(OSError("no space left on device")))
    kept.write()
    assert [file.name for file in tmp_path.iterdir()] == ["folder"]


def test_other_sources_remember_other_quantities(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A mistake that is mended must not live on in the cache."""
    monkeypatch.undo()
    now = units._remembered.__wrapped__().path
    copy = tmp_path / "units.py"
    copy.write_bytes(Path(units.__file__).read_bytes() + b"\n")
    monkeypatch.setattr(units, "__file__", str(copy))
    assert units._remembered.__wrapped__().path != now
    monkeypatch.setattr(units, "version", lambda name: "0.0")
    monkeypatch.setattr(units, "__file__", units.__spec__.origin)
    assert units._remembered.__wrapped__().path != now

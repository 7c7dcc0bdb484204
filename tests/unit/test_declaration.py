"""Declarations: frozen, checked when made, with one clear message for each way to be wrong."""

from __future__ import annotations

from dataclasses import FrozenInstanceError, replace
from typing import Literal

import pytest
from pydantic import TypeAdapter

from lamella import Clamp, Ground, Isotropic, Laminate, MeanPosition, Plate, PointForce, Pressure, SphereContact
from lamella.declaration import declaration
from lamella.errors import DeclarationError, LamellaError
from lamella.units import Length, Thickness, quantity


@declaration
class Sheet:
    """A declaration for these tests."""

    name: str
    thickness: Thickness
    offset: Length = 0.0
    side: Literal["left", "right"] = "left"
    share: quantity("", ge=0, le=1) = 0.5  # type: ignore[valid-type]

    def __post_init__(self) -> None:
        if abs(self.offset) > self.thickness:
            raise ValueError(f"offset = {self.offset:g}; accepted is at most the thickness {self.thickness:g}")


@declaration
class Stack:
    """A declaration that holds others."""

    sheets: tuple[Sheet, ...]


def test_arguments_by_place_and_by_name() -> None:
    assert Sheet("a", 1e-3) == Sheet(thickness="1 mm", name="a")  # type: ignore[arg-type]
    assert hash(Sheet("a", 1e-3)) == hash(Sheet("a", 1e-3))


def test_declarations_are_frozen() -> None:
    sheet = Sheet("a", 1e-3)
    with pytest.raises(FrozenInstanceError):
        sheet.thickness = 2.0  # type: ignore[misc]
    assert replace(sheet, thickness=2e-3).thickness == 2e-3


def test_mappings_become_declarations() -> None:
    stack = Stack([{"name": "a", "thickness": "2 mm"}, Sheet("b", 1)])  # type: ignore[arg-type]
    assert stack.sheets == (Sheet("a", 2e-3), Sheet("b", 1))
    assert TypeAdapter(Stack).validate_python({"sheets": [{"name": "a", "thickness": 1}]}) == Stack((Sheet("a", 1),))


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"thickness": 0}, "Sheet 'wing': thickness = 0; accepted is a value greater than 0"),
        ({"thickness": "2 kg"}, "Sheet 'wing': thickness = '2 kg'; '2 kg' has the unit kg, which does not convert to m"),
        ({"thickness": 1, "side": "top"}, "Sheet 'wing': side = 'top'; accepted is 'left' or 'right'"),
        ({"thickness": 1, "share": 2}, "Sheet 'wing': share = 2; accepted is a value at most 1"),
        ({"thickness": 1, "share": -1}, "Sheet 'wing': share = -1; accepted is a value at least 0"),
        ({"thickness": 1, "widht": 2}, "Sheet 'wing': unknown argument 'widht'"),
        ({}, "Sheet 'wing': 'thickness' is missing"),
        ({"thickness": 1, "offset": 3}, "Sheet 'wing': offset = 3; accepted is at most the thickness 1"),
    ],
)
def test_messages_name_item_value_and_what_is_accepted(arguments: dict, message: str) -> None:
    with pytest.raises(DeclarationError, match=message) as caught:
        Sheet("wing", **arguments)
    assert isinstance(caught.value, LamellaError)
    assert isinstance(caught.value, ValueError)
    assert "\n" not in str(caught.value)


def test_messages_name_the_place_within_other_declarations() -> None:
    with pytest.raises(DeclarationError, match=r"Stack: sheets\.1\.thickness = -1; accepted is a value greater than 0"):
        Stack([{"name": "a", "thickness": 1}, {"name": "b", "thickness": -1}])  # type: ignore[arg-type]
    with pytest.raises(DeclarationError, match=r"Stack: unknown argument 'sheets\.0\.colour'"):
        Stack([{"name": "a", "thickness": 1, "colour": 1}])  # type: ignore[arg-type]


def test_too_many_arguments() -> None:
    with pytest.raises(DeclarationError, match="Sheet: 6 arguments given; accepted are name, thickness, offset, side, share"):
        Sheet("a", 1, 0, "left", 0.5, 7)  # type: ignore[call-arg]


def test_a_name_that_is_no_text() -> None:
    with pytest.raises(DeclarationError, match="Sheet: name = 5; accepted is a text"):
        Sheet(5, 1)  # type: ignore[arg-type]


def test_values_of_another_kind_are_told_with_what_is_accepted() -> None:
    with pytest.raises(DeclarationError, match="Stack: sheets = 5; accepted is a list"):
        Stack(5)  # type: ignore[arg-type]
    plate = Plate("wing", (1, 1), (1, 1), Laminate(Isotropic(7e10, 0.3, 2700), thickness=1e-3))
    with pytest.raises(DeclarationError, match="Clamp 'root': on = Plate 'wing'; accepted is an Edge or a Marker"):
        Clamp("root", plate)  # type: ignore[arg-type]
    with pytest.raises(DeclarationError, match=r"PointForce 'load': on = <Edge wing\.x->; accepted is a Marker"):
        PointForce("load", plate.edge("x-"), (0, 0, 1))  # type: ignore[arg-type]


@pytest.mark.parametrize("given", [{}, {"name": "wing", "mesh": (1, 1)}], ids=["empty", "filled"])
def test_a_mapping_makes_no_body_of_any_kind(given: dict) -> None:
    with pytest.raises(DeclarationError, match=r"MeanPosition 'middle': on = {.*}; accepted is a ShellBody"):
        MeanPosition("middle", given)  # type: ignore[arg-type]
    with pytest.raises(DeclarationError, match=r"Pressure 'wind': on = {.*}; accepted is a ShellBody"):
        Pressure("wind", given, 1.0)  # type: ignore[arg-type]
    with pytest.raises(DeclarationError, match=r"SphereContact 'ball': shell = {.*}; accepted is a ShellBody"):
        SphereContact("ball", given, Ground().origin, 0.1, stiffness=1e8)  # type: ignore[arg-type]

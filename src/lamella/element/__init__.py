"""Finite elements: one folder each, and one line here for each."""

from __future__ import annotations

from lamella.element.base import ELEMENTS
from lamella.element.plate36.shape import Plate36
from lamella.element.plate48.shape import Plate48

for _element in (Plate48(), Plate36()):
    ELEMENTS[_element.name] = _element

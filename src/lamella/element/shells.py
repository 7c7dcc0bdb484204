"""The blocks of each finite element, one line for each; the one place that knows which element uses which."""

from __future__ import annotations

from lamella.element.models import ShellModels
from lamella.element.plate36 import block as plate36
from lamella.element.plate48 import block as plate48

SHELLS: dict[str, ShellModels] = {shell.element.name: shell for shell in (plate48.SHELL, plate36.SHELL)}
"""What shells are made of, by the element's name; the names are those of :data:`lamella.element.base.ELEMENTS`."""

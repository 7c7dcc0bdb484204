"""Other codes that run the same cases: which are installed, and how to install those that are not."""

from __future__ import annotations

import importlib.util
import re
import shutil
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass
from importlib import metadata

from lamella.bench.row import Row


@dataclass(frozen=True)
class Peer:
    """Another code.

    Args:
        name: as it stands in the table.
        install: how to get it.
        find: gives its version, None when it is not installed.
    """

    name: str
    install: str
    find: Callable[[], str | None]

    def missing(self, case: str, code: str = "") -> Row:
        """The row that stands in the table instead of its numbers."""
        return Row(case=case, code=code or self.name, note=f"not installed; {self.install}")


def _exudyn() -> str | None:
    return metadata.version("exudyn") if importlib.util.find_spec("exudyn") else None


KRATOS_PACKAGES = ("Multiphysics", "StructuralMechanicsApplication", "ConstitutiveLawsApplication", "LinearSolversApplication")
"""What the plate needs, each a package of its own whose name begins with Kratos."""


def _kratos() -> str | None:
    if not importlib.util.find_spec("KratosMultiphysics"):
        return None
    try:
        versions = {name: metadata.version(f"Kratos{name}") for name in KRATOS_PACKAGES}
    except metadata.PackageNotFoundError:
        return None
    return versions["Multiphysics"]


def _calculix() -> str | None:
    program = shutil.which("ccx")
    if program is None or sys.platform == "win32":  # where the CPU time of another program is not known
        return None
    said = subprocess.run([program, "-v"], capture_output=True, text=True, check=False).stdout
    found = re.search(r"[Vv]ersion (\S+)", said)
    return found.group(1) if found else "unknown"


EXUDYN = Peer("Exudyn", "pip install 'lamella[bench]'", _exudyn)
CALCULIX = Peer("CalculiX", "apt install calculix-ccx, or put its program ccx on the PATH (not on Windows)", _calculix)
KRATOS = Peer("Kratos", "pip install 'lamella[bench]' (not on macOS)", _kratos)
PEERS = (EXUDYN, CALCULIX, KRATOS)

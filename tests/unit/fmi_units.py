"""Units of FMI at work in another program, for both versions of the standard."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

fmpy: Any = pytest.importorskip("fmpy")
fmi2: Any = pytest.importorskip("fmpy.fmi2")
fmi3: Any = pytest.importorskip("fmpy.fmi3")
validate_fmu: Any = pytest.importorskip("fmpy.validation").validate_fmu
pytest.importorskip("pythonfmu")
pytest.importorskip("pythonfmu3")

VERSIONS = [2, 3]


def instantiated(path: Path, fmi: int, folder: Path) -> Any:
    """An instance of a unit that is unpacked in ``folder``, which logs what it has to say."""
    description = fmpy.read_model_description(path)
    if not folder.exists() or not any(folder.iterdir()):  # a binary that is loaded must not be written again
        fmpy.extract(path, folder)
    cls, key = (fmi2.FMU2Slave, description.guid) if fmi == 2 else (fmi3.FMU3Slave, description.instantiationToken)
    identifier = description.coSimulation.modelIdentifier
    slave = cls(guid=key, unzipDirectory=str(folder), modelIdentifier=identifier, instanceName="unit")
    slave.instantiate(loggingOn=True)
    return slave

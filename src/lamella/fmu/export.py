"""Write a model file as a functional mock-up unit for co-simulation."""

from __future__ import annotations

import re
import shutil
import sys
from collections.abc import Mapping, Sequence
from importlib import import_module
from keyword import iskeyword
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any
from uuid import uuid4

import numpy as np

from lamella.arguments import NAMED, NAMES, NUMBER, accepts, optional
from lamella.errors import DeclarationError, MissingExtraError, ModelError, ResultFileError
from lamella.fmu.plant import Interface, Variable, stepping, write_resources
from lamella.io.analysis import Analysis, Computed, Motion, result_of
from lamella.io.linear_analysis import Linear
from lamella.io.model_file import ModelFile, read_model
from lamella.linear.inputs import Inputs
from lamella.state import State
from lamella.stepping.run import Stepping
from lamella.whole import replaced

PACKAGES = {2: "pythonfmu", 3: "pythonfmu3"}
"""Package that makes a unit, by version of FMI."""
SCRIPT = """\"\"\"The unit of a lamella model: where it is run, Python needs lamella.\"\"\"

from {package} import Fmi{fmi}Slave

try:
    from lamella.fmu.fmi{fmi} import Fmi{fmi}Unit
except Exception as error:  # the binary of FMI 3 ends the process when this text cannot be run
    said = "the unit '{name}' cannot be run without lamella: " + str(error)

    class Fmi{fmi}Unit:
        def __new__(cls, **options):
            raise ImportError(said)
{before}

class {name}(Fmi{fmi}Unit, Fmi{fmi}Slave):
    pass
"""
REFERENCE = """import ctypes

# The binary of pythonfmu runs this text for each instance and then gives up a reference to its globals that it does not own.
ctypes.pythonapi.Py_IncRef(ctypes.py_object(globals()))
"""
BEFORE = {2: REFERENCE, 3: ""}
"""What the script of a unit needs besides, by version of FMI."""
ITEM = "export_fmu"
TIME = "time"
"""A variable that every unit of FMI 3 has."""


@accepts(inputs=optional(NAMED), outputs=optional(NAMES), step=optional(NUMBER))
def export_fmu(
    model: str | Path,
    out: str | Path,
    *,
    fmi: int = 2,
    inputs: Inputs | None = None,
    outputs: Sequence[str] | None = None,
    step: float | None = None,
    motion: str | None = None,
    overrides: Sequence[str] = (),
    overwrite: bool = False,
    name: str | None = None,
) -> Path:
    """Write a model file as a unit for co-simulation, which carries the model and is run by lamella.

    Args:
        model: the model file. It needs a motion, whose integrator, times and start the unit takes.
        out: the unit to write, ``*.fmu``.
        fmi: version of the standard, 2 or 3.
        inputs: as in :class:`~lamella.stepping.run.Stepping`; those of the file's linear analysis when left out.
        outputs: as there.
        step: communication step that the unit proposes [s]; the integrator's when left out.
        motion: name of the motion; the only one, when left out.
        overrides: ``key=value`` texts that replace values of the file.
        overwrite: replace the file.
        name: of the model in the unit; that of the file when left out.

    Returns:
        The unit.

    Raises:
        DeclarationError: another version, an input or output that does not exist.
        ModelError: no motion, or neither inputs nor outputs.
        MissingExtraError: the package that makes units is not installed.
        ResultFileError: the unit cannot be written.
    """
    if fmi not in PACKAGES:
        raise DeclarationError(ITEM, f"fmi = {fmi}", "accepted is 2 or 3")
    target = Path(out)
    if target.suffix != ".fmu":
        raise DeclarationError(ITEM, f"out = '{target}'", "accepted is a file name that ends in .fmu")
    if step is not None and not 0.0 < step < np.inf:
        raise DeclarationError(ITEM, f"step = {step}", "accepted is a positive, finite communication step [s]")
    if target.exists() and not overwrite:
        raise ResultFileError(f"'{target}' exists already; overwrite it, or choose another name")
    builder = _builder(fmi)
    file = read_model(model, overrides)
    chosen = _motion(file, motion)
    inputs, outputs = _channels(file, inputs, outputs)
    with TemporaryDirectory(prefix="lamella_fmu_") as folder:
        resources = Path(folder) / "resources"
        resources.mkdir()
        state, imperfection = _start(file, chosen)
        channels = dict(inputs) if isinstance(inputs, Mapping) else {item: item for item in inputs}
        if fmi == 3 and TIME in channels:
            other = f"accepted is another name, {{'name': '{channels[TIME]}'}}"
            raise DeclarationError(ITEM, f"an input is called '{TIME}', as the time of FMI 3", other)
        variables = tuple(Variable(item, "1", "", 0.0) for item in outputs)
        draft = Interface(
            _identifier(name or Path(model).stem),
            file.title,
            chosen.name,
            step or chosen.integrator.dt,
            chosen.t_start,
            chosen.t_end,
            channels,
            (),
            variables,
        )
        write_resources(resources, draft, file.text(), state, imperfection)
        interface = _described(draft, stepping(resources, draft, chosen.t_start))
        files = write_resources(resources, interface, file.text(), state, imperfection)
        made = _build(builder, fmi, interface.name, files, Path(folder))
        return _put(made, target)


def _identifier(name: str) -> str:
    """A name of a class and of a file: of letters, digits and underscores, without a digit at first, and no word of Python."""
    found = re.sub(r"\W", "_", name, flags=re.ASCII)
    return found if found.isidentifier() and not iskeyword(found) else f"_{found}"


def _builder(fmi: int) -> Any:
    try:
        return import_module(PACKAGES[fmi]).FmuBuilder
    except ImportError as error:
        raise MissingExtraError(f"a unit of FMI {fmi} needs {PACKAGES[fmi]}: pip install 'lamella[fmu]'") from error


def _motion(file: ModelFile, name: str | None) -> Motion:
    """The motion whose integrator is taken."""
    motions = [item for item in file.analyses if isinstance(item, Motion)]
    found = [item for item in motions if name in (None, item.name)]
    if len(found) != 1:
        there = ", ".join(item.name for item in motions) or "none"
        missing = "several motions" if motions else "no motion, whose integrator a unit takes"
        asked = f"no motion '{name}'" if name else missing
        raise ModelError(f"{ITEM}: '{file.name}' has {asked}; there are: {there}")
    return found[0]


def _channels(file: ModelFile, inputs: Inputs | None, outputs: Sequence[str] | None) -> tuple[Inputs, Sequence[str]]:
    """What is given, and of the rest what the linear analyses of the file name, each once."""
    linear = [item for item in file.analyses if isinstance(item, Linear)]
    if inputs is None:
        inputs = tuple(dict.fromkeys(name for item in linear for name in item.inputs))
    if outputs is None:
        outputs = tuple(dict.fromkeys(name for item in linear for name in item.outputs))
    if not inputs and not outputs:
        raise ModelError(
            f"{ITEM}: '{file.name}' names neither inputs nor outputs; accepted is an analysis "
            "{type: linear, inputs: [...], outputs: [...]}, or inputs and outputs given here"
        )
    return inputs, outputs


def _start(file: ModelFile, motion: Motion) -> tuple[State | None, object]:
    """The state from which the motion starts, and the imperfection of its model."""
    if motion.start is None:
        return None, None
    earlier: dict[str, Computed] = {}
    whole = file.system.compile()
    for item in _needed(file, motion):
        earlier[item.name] = item.run(item.prepared(whole, earlier), earlier, 1, ())
    return result_of(motion, motion.start, earlier).final, motion.prepared(whole, earlier).imperfection


def _needed(file: ModelFile, motion: Motion) -> list[Analysis]:
    """The analyses before a motion that states or shapes come from; linear models give neither."""
    names = [item.name for item in file.analyses]
    return [item for item in file.analyses[: names.index(motion.name)] if not isinstance(item, Linear)]


def _described(draft: Interface, run: Stepping) -> Interface:
    """The interface with units, descriptions and values at the start."""

    def variables(values: Mapping[str, float]) -> tuple[Variable, ...]:
        return tuple(
            Variable(name, run.units[name], run.descriptions[name].replace("'", ""), value) for name, value in values.items()
        )

    return Interface(**{**vars(draft), "inputs": variables(run.inputs), "outputs": variables(run.outputs)})


def _build(builder: Any, fmi: int, name: str, files: Sequence[Path], folder: Path) -> Path:
    """Let the package make the unit in ``folder``, and take its traces out of this process."""
    module = f"{name}_{uuid4().hex}"  # in one process every unit has a module of its own
    script, before = folder / f"{module}.py", list(sys.path)
    script.write_text(SCRIPT.format(fmi=fmi, package=PACKAGES[fmi], before=BEFORE[fmi], name=name), encoding="utf-8")
    saved = {2: ("canGetAndSetFMUstate", "canSerializeFMUstate"), 3: ("canGetAndSetFMUState", "canSerializeFMUState")}[fmi]
    options = {**dict.fromkeys(saved, True), "canHandleVariableCommunicationStepSize": True}
    try:
        return Path(builder.build_FMU(script, dest=folder, project_files=files, **options))
    finally:
        sys.path[:] = before
        sys.modules.pop(module, None)


def _put(made: Path, target: Path) -> Path:
    """Move the whole unit to where it is wanted."""
    with replaced(target) as partial:
        shutil.copyfile(made, partial)
    return target

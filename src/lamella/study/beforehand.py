"""What a run would tell only at its end: names in a model file that its system does not have."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from lamella.assembly.equations import Equations
from lamella.dofs import Signal
from lamella.errors import DeclarationError
from lamella.io.analysis import Output
from lamella.io.model_file import ModelFile
from lamella.io.reader import suggestion
from lamella.model import Model


def refuse_unknown(model_file: ModelFile, model: Model, *, pictures: bool) -> None:
    """Look for what analyses and outputs name before anything is computed.

    Args:
        model_file: the analyses, and what is written.
        model: its compiled system.
        pictures: whether pictures are drawn.

    Raises:
        DeclarationError: there is no such signal, input or field; those that there are are listed.
    """
    equations, output = Equations(model), model_file.output
    for analysis in model_file.analyses:
        analysis.check(equations)
    known = {signal.name: signal for item in model_file.analyses if item.axis for signal in item.signals(equations)}
    unknown = [name for name in output.signals or () if not recorded([name], known)]
    if known and unknown:
        raise DeclarationError("output", f"signals: there is no signal '{unknown[0]}'{suggestion(unknown[0], known)}")
    if known and pictures and (output.pictures or output.animation):
        _refuse_field(output, model)


def recorded(names: Sequence[str], signals: Mapping[str, Signal]) -> list[str]:
    """Those of the names that are signals, or components of signals."""

    def known(name: str) -> bool:
        stem, _, label = name.rpartition(".")
        return name in signals or (stem in signals and label in signals[stem].labels)

    return [name for name in names if known(name)]


def _refuse_field(output: Output, model: Model) -> None:
    """Evaluate what colours the pictures on the coarsest grid, in the reference configuration."""
    from lamella.viz.fields import Snapshot, scalar, select

    field, component = select(output.field)
    for plate in model.plates:
        grid = plate.grid(1)
        scalar(field, component, Snapshot(plate, grid, model.q0, np.zeros_like(model.q0), grid.sample(model.q0)))

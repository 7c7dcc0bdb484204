"""What a run writes of a linear model: files of its matrices, Bode diagram, step responses, report."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from lamella.io.model_file import ModelFile
from lamella.linear.state_space import StateSpace
from lamella.model import Model
from lamella.study.folder import PICTURES
from lamella.study.outputs import make_folder, system_section

if TYPE_CHECKING:
    from lamella.viz.report import Table

FILES = ("linear.npz", "linear.mat")
MOST_POLES = 40
"""Poles listed in a report."""


def write_linear_outputs(model_file: ModelFile, linear: StateSpace, model: Model, folder: Path, pictures: bool) -> list[Path]:
    """Write a linear model as files for NumPy and MATLAB, draw it, and write the report.

    Raises:
        ResultFileError: a file cannot be written.
    """
    files, drawn = [linear.save(folder / file) for file in FILES], []
    output = model_file.output
    if pictures and output.pictures:
        from lamella.viz.linear import plot_bode, plot_step
        from lamella.viz.style import save_figure

        make_folder(folder / PICTURES)
        drawn = [
            (save_figure(plot_bode(linear), folder / PICTURES / "bode.png"), "Magnitude and phase over the frequency"),
            (save_figure(plot_step(linear), folder / PICTURES / "step.png"), "Changes of the outputs after a unit step"),
        ]
        files += [path for path, _ in drawn]
    if pictures and output.report:
        from lamella.viz.report import Figure, Section, write_report

        section = Section("Linear model", _summary(linear), [Figure(path, caption) for path, caption in drawn], _tables(linear))
        title = model_file.title or "Linear model"
        sections = [section, system_section(model_file, model)]
        files.append(
            write_report(folder / "report.html", title, sections, summary=model_file.description, model_text=model_file.text())
        )
    return files


def describe(linear: StateSpace) -> str:
    """A linear model in a line."""
    counts = [(linear.n_states, "state"), (len(linear.inputs), "input"), (len(linear.outputs), "output")]
    text = ", ".join(f"{n} {word}{'s' * (n != 1)}" for n, word in counts)
    text += f", {'stable' if linear.is_stable else 'not asymptotically stable'}"
    return f"{text}; no further states are both reached by inputs and seen in outputs" if _is_whole(linear) else text


def _is_whole(linear: StateSpace) -> bool:
    """Whether balancing has left out only states whose singular values are rounding, also where more were asked for."""
    if linear.hankel is None or linear.error_bound is None:
        return False
    return bool(0.0 < linear.error_bound <= 2.0 * len(linear.hankel) ** 2 * np.finfo(float).eps * linear.hankel[0])


def _summary(linear: StateSpace) -> str:
    text = f"{describe(linear)}.".capitalize()
    if linear.error_bound is not None:
        text += (
            "\n\nBalanced truncation: the largest singular value of the transfer matrix errs by at most "
            f"{linear.error_bound:.3g} at any frequency, in the units of the inputs and outputs."
        )
    return text


def _tables(linear: StateSpace) -> list[Table]:
    from lamella.viz.report import Table

    poles = [pole for pole in linear.poles() if pole.imag >= 0.0]
    size = [abs(pole) for pole in poles]
    rows = [
        [k, s / (2.0 * np.pi), -pole.real / s if s else 0.0, pole.real, pole.imag]
        for k, (pole, s) in enumerate(zip(poles, size, strict=True), start=1)
    ]
    caption = "" if len(rows) <= MOST_POLES else f"The first {MOST_POLES} of {len(rows)} poles"
    found = [
        Table(
            ["Number", "Frequency [Hz]", "Damping ratio", "Real part [1/s]", "Imaginary part [1/s]"], rows[:MOST_POLES], caption
        )
    ]
    for kind in ("input", "output"):
        names, units, values = (getattr(linear, f"{kind}{part}") for part in ("s", "_units", "_values"))
        found.append(Table([kind.capitalize(), "Unit", "In the steady state"], list(zip(names, units, values, strict=True))))
    return found

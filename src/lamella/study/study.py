"""A study: variants of one model run one after another and compared, with findings."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

from lamella.errors import DeclarationError
from lamella.io.analysis import Computed
from lamella.io.model_file import ModelFile, read_model
from lamella.result import Result
from lamella.study.findings import Finding, write_findings
from lamella.study.folder import PICTURES
from lamella.study.run import Finished, Say, run_model, silent

if TYPE_CHECKING:
    from matplotlib.figure import Figure as MatplotlibFigure


@dataclass
class Study:
    """What a study function works with.

    Args:
        model: the model file.
        folder: where everything is written; each variant has a folder of its own in it.
        overrides: ``key=value`` texts of the user, applied after those of each variant.
        draw: write plots, pictures and reports.
        progress: show progress bars.
        say: takes messages.
        finished: what has been run, by the variant's name.
        files: files written by the study itself.
        captions: pictures of the study for its report, with their captions.
    """

    model: Path
    folder: Path
    overrides: Sequence[str] = ()
    draw: bool = True
    progress: bool = False
    say: Say = silent
    finished: dict[str, list[Finished]] = field(default_factory=dict)
    files: list[Path] = field(default_factory=list)
    captions: dict[Path, str] = field(default_factory=dict)

    def run(self, name: str, overrides: Sequence[str] = (), *, pictures: bool = False) -> dict[str, Computed]:
        """Run a variant of the model and return what each analysis computed, by the analysis's name.

        Args:
            name: name of the variant; also of its folder.
            overrides: ``key=value`` texts that make the variant, such as ``system.plate.mesh=[8, 8]``.
            pictures: write the variant's own plots, pictures and report, if pictures are wanted at all.
        """
        if name in self.finished:
            raise DeclarationError("study", f"the variant '{name}' has been run already", "every variant has its own name")
        self.say(f"variant {name}: {', '.join(overrides) or 'as in the model file'}")
        drawn = pictures and self.draw
        self.finished[name] = run_model(
            self.read(overrides), self.folder / name, pictures=drawn, progress=self.progress, say=self.say
        )
        return {item.analysis.name: item.computed for item in self.finished[name]}

    def read(self, overrides: Sequence[str] = ()) -> ModelFile:
        """The model with overrides, without running it."""
        return read_model(self.model, (*overrides, *self.overrides))

    def show(self, figure: MatplotlibFigure, name: str, caption: str) -> Path | None:
        """Save a figure as ``pictures/name.png`` and show it in the report; None when no pictures are wanted."""
        from lamella.viz.style import save_figure

        if not self.draw:
            return None
        folder = self.folder / PICTURES
        folder.mkdir(exist_ok=True)
        path = save_figure(figure, folder / f"{name}.png")
        self.captions[path] = caption
        self.files.append(path)
        return path


def run_study(function: Callable[[Study], Iterable[Finding]], study: Study) -> list[Finding]:
    """Run a study function and write what it found to ``findings.json``."""
    findings = list(function(study))
    study.files.append(write_findings(findings, study.folder / "findings.json"))
    if study.draw:
        study.files.append(_write_report(study, findings))
    return findings


def _write_report(study: Study, findings: Sequence[Finding]) -> Path:
    from lamella.viz.report import Figure, Section, write_report

    model = study.read()
    figures = [Figure(path, caption) for path, caption in study.captions.items()]
    runs = {f"{variant} {item.analysis.name}": item.computed for variant, items in study.finished.items() for item in items}
    return write_report(
        study.folder / "report.html",
        model.title,
        [Section("Comparison", figures=figures)] if figures else [],
        findings,
        summary=model.description,
        model_text=study.model.read_text(encoding="utf-8"),
        results={name: computed for name, computed in runs.items() if isinstance(computed, Result)},
    )

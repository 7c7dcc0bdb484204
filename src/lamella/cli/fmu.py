"""The command ``lamella fmu``."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from lamella.examples import Example, find_model


def fmu_command(
    model: str,
    out: Path | None,
    fmi: int,
    inputs: Sequence[str] | None,
    outputs: Sequence[str] | None,
    *,
    step: float | None,
    settings: Sequence[str],
    overwrite: bool,
) -> None:
    """Write a model file or an example as a unit."""
    from lamella.fmu.export import export_fmu

    found = find_model(model)
    path = found.model if isinstance(found, Example) else found
    name = found.name if isinstance(found, Example) else found.stem
    target = export_fmu(
        path,
        out or Path(f"{name}.fmu"),
        fmi=fmi,
        inputs=inputs or None,
        outputs=outputs or None,
        step=step,
        overrides=settings,
        overwrite=overwrite,
        name=name,
    )
    print(f"wrote {target} (FMI {fmi}, co-simulation); where it is run, Python needs lamella as well")

"""Declarations are imported when a model needs them, and found as if all were there."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

import lamella as lm
from lamella.io.annotation import tag_of
from lamella.io.catalogue import USERS
from lamella.io.sections import SECTIONS

MODEL = """
lamella: 1
system:
  plate: {type: plate, size: [1, 1], mesh: [1, 1], laminate: {ply: {E: 1e9, nu: 0.3, rho: 1000}, thickness: 1e-3}}
  load: {type: gravity}
analysis:
  swing: {type: motion, t_end: 1, integrator: {type: bdf, dt: 1e-3}}
"""
READ = f"""
import sys
from lamella.io.model_file import loads
model = loads('''{MODEL}''')
print(type(model.analyses[0].integrator).__name__, *(name for name in sys.modules if name.startswith("lamella.")))
"""
COMPARE = """
from typing import get_args
from lamella.io.annotation import concrete, field_specs
from lamella.io.sections import SECTIONS
import lamella.body.plate, lamella.io.analysis, lamella.load.controller
from lamella.declaration import KINDS

def classes(annotation):
    return [annotation, *(found for part in get_args(annotation) for found in classes(part))]

def bases():
    mentioned = [found for kind in KINDS for spec in field_specs(kind).values() for found in classes(spec.annotation)]
    return dict.fromkeys(found for found in mentioned if isinstance(found, type) and found.__module__.startswith("lamella."))

early = {base: set(concrete(base)) for base in bases()}
SECTIONS["system"].classes()
assert len(bases()) > len(early) > 10
for base, found in early.items():
    assert found == set(concrete(base)), base
"""


def run(text: str) -> list[str]:
    environment = {**os.environ, "PYTHONPATH": str(Path(lm.__file__).parents[1])}
    found = subprocess.run([sys.executable, "-c", text], env=environment, capture_output=True, text=True)
    assert found.returncode == 0, found.stderr
    return found.stdout.split()


def test_a_model_imports_what_it_holds() -> None:
    integrator, *imported = run(READ)
    assert integrator == "BDF"
    assert "lamella.load.gravity" in imported
    assert not {"lamella.contact.obstacles", "lamella.thermal.field", "lamella.linear.model"} & set(imported)


def test_an_annotation_accepts_the_same_before_and_after_all_are_imported() -> None:
    run(COMPARE)


@pytest.mark.parametrize("section", ["system", "analysis"])
def test_a_tag_means_the_same_alone_and_among_all(section: str) -> None:
    for cls in SECTIONS[section].classes():
        assert cls in SECTIONS[section].classes_of(tag_of(cls)[1])


def test_declarations_of_a_system_are_found_by_their_public_names() -> None:
    for cls in SECTIONS["system"].classes():
        if (
            cls.__module__.split(".")[0] == "lamella" and cls.__module__.split(".")[1] not in USERS
        ):  # cases and tests declare some
            assert SECTIONS["system"].classes_of(tag_of(cls)[1]) == (cls,)


@pytest.mark.parametrize("tag", ["gravty", None, 3, "user_force", "motion", "simulate"])
def test_any_other_tag_leaves_the_choice_among_all(tag: object) -> None:
    assert SECTIONS["system"].classes_of(tag) == SECTIONS["system"].classes()

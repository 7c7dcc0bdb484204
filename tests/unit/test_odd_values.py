"""Whatever stands in a file, reading it succeeds or ends in an error that is meant for the user."""

from __future__ import annotations

import json
from collections.abc import Iterator
from copy import deepcopy
from pathlib import Path
from typing import Any

import pytest

from lamella import examples
from lamella.errors import LamellaError
from lamella.io.document import Document
from lamella.io.model_file import read_model
from lamella.optimisation.problem import Optimisation
from lamella.sweep.file import read_declaration
from lamella.sweep.study import ParameterStudy

FOLDER = Path(examples.__file__).parent
FILES = {
    "cantilever_plate/model.yaml": read_model,
    "satellite_thermal/model.yaml": read_model,
    "belt_drive/model.yaml": read_model,
    "attitude_control/model.yaml": read_model,
    "corrugator_study/study.yaml": lambda path: read_declaration(path, ParameterStudy, "study"),
    "layup_optimisation/optimize.yaml": lambda path: read_declaration(path, Optimisation, "optimize"),
}
ODD = [None, "x", "", -1, 0, 1e100, float("nan"), float("inf"), [], {}, [1], {"a": 1}, True, "1 m", "-3 kg", 10**400, [[1], [2]]]


def places(data: Any, above: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """The place of every value."""
    for key, value in data.items() if isinstance(data, dict) else enumerate(data):
        yield (*above, key)
        if isinstance(value, (dict, list)):
            yield from places(value, (*above, key))


@pytest.mark.parametrize("name", FILES)
def test_odd_values_are_refused_with_words(name: str, tmp_path: Path) -> None:
    """At every place one of the odd values, each of which has its turn, or nothing at all."""
    data = Document.read(FOLDER / name).data
    if "model" in data:
        data["model"] = str(FOLDER / name / "../model.yaml")
    path, refused = tmp_path / "odd.yaml", 0
    for turn, place in enumerate(places(data)):
        changed = deepcopy(data)
        holder = changed
        for key in place[:-1]:
            holder = holder[key]
        if turn % (len(ODD) + 1) == len(ODD):
            del holder[place[-1]]
        else:
            holder[place[-1]] = ODD[turn % (len(ODD) + 1)]
        path.write_text(json.dumps(changed).replace("NaN", ".nan").replace("Infinity", ".inf"), "utf-8")
        try:
            FILES[name](path)
        except LamellaError:
            refused += 1
    assert refused > 0.5 * turn

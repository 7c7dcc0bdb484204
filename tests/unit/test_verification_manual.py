"""The verification manual: what it shows, that it stands alone, and that it is written whole or not at all."""

from __future__ import annotations

import base64
import io
import os
import sys
from pathlib import Path

import numpy as np
import pytest
import stand_in
from html_page import Page
from PIL import Image

from lamella.cli import verify
from lamella.errors import DeclarationError, ResultFileError
from lamella.verification import Curves, Orders, Shape, find_cases, run_cases
from lamella.viz import manual
from lamella.viz.case_pictures import drawn
from lamella.viz.manual import Manual, markdown
from lamella.viz.plots import MOST_MARKERS, plot_curves

README = """\
# Sag of a <strip>

| compared | with |
|---|---|
| sag | table 1 |

## Equations

    w = F L^3 / (3 E I)

<script>alert(1)</script> and ![a picture](https://example.org/a.png), see [a file](other.md).
"""
TOML = """\
source = "Somebody (1999), table 1"
[quantities."path"]
at = [0.5, 1.0]
value = [1.0, 2.0]
tolerance = 0.1
unit = "m"
reason = "read from a figure"
[quantities."order"]
value = 2.0
tolerance = 0.0
kind = "at least"
reason = "it is of second order"
"""
CASES = {
    "good": "    refs = References.beside(__file__)\n"
    "    yield from refs.checks('path', [1.01, 2.0])\n"
    "    yield refs.check('order', 2.1)\n"
    "    lines, points = {'computed': ([0.0, 1.0], [0.0, 2.0])}, {'published': refs.points('path')}\n"
    "    yield Curves('Path', 'Load [N]', 'Sag [m]', lines, points)\n"
    "    yield Orders('Errors', 'Step [s]', {'sag': ([0.1, 0.05], [4e-2, 1e-2])}, (2,))\n",
    "missed": "    yield References.beside(__file__).check('order', 1.25)\n",
    "stopped": "    yield Check('first', 1.0, 1.0, 0.1)\n    raise ValueError('no <convergence>')\n",
    "strange": "    yield 'a text'\n",
}


@pytest.fixture
def cases(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """Cases that pass, miss a tolerance, stop, and yield what is no check."""
    folder = tmp_path / "manual_cases"
    for name, body in CASES.items():
        (folder / name).mkdir(parents=True)
        heading = "from lamella.verification import Check, Curves, Orders, References\n"
        (folder / name / "case.py").write_text(f"{heading}def run():\n{body}")
        (folder / name / "reference.toml").write_text(TOML)
        (folder / name / "README.md").write_text(README.replace("Sag", f"{name.capitalize()} sag"))
    monkeypatch.syspath_prepend(tmp_path)
    yield find_cases(folder=folder, package="manual_cases")
    for module in [name for name in sys.modules if name.startswith("manual_cases")]:
        del sys.modules[module]


def page_of(outcomes, path: Path) -> tuple[Page, str]:
    book = Manual(path, "lamella verify --report manual.html")
    for outcome in outcomes:
        book.add(outcome)
    text = book.write().read_text(encoding="utf-8")
    return Page(text), text


def test_manual_holds_every_case_check_and_picture(cases, tmp_path: Path) -> None:
    outcomes = list(run_cases(cases))
    page, text = page_of(outcomes, tmp_path / "manual.html")
    for outcome in outcomes:
        assert f'<section id="{outcome.case.name}"' in text
        assert f"#{outcome.case.name}" in page.links
        assert outcome.case.title in page.text
        for check in outcome.checks:
            assert check.quantity in page.text
    for told in ("path at 0.5 [m]", "1.01", "≥ 2", "1 %", "10 %", "read from a figure", "Somebody (1999), table 1"):
        assert told in page.text
    assert text.count("read from a figure") == 1  # the same reason of two checks stands once, over both rows
    assert [image["alt"] for image in page.images] == ["Path", "Errors"]
    assert f"numpy {np.__version__}" in page.text
    assert "lamella verify --report manual.html" in page.text


def test_manual_loads_nothing_and_runs_nothing(cases, tmp_path: Path) -> None:
    page, text = page_of(run_cases(cases[:1]), tmp_path / "manual.html")
    assert all((image["src"] or "").startswith("data:image/") for image in page.images)
    assert {link for link in page.links if link and not link.startswith(("data:image/", "#"))} == {"https://example.org/a.png"}
    for tag in ("<script", "<link", "<iframe", "@import", "url("):
        assert tag not in text


def test_failures_stand_out(cases, tmp_path: Path) -> None:
    page, text = page_of(run_cases(cases), tmp_path / "manual.html")
    assert "Failed: missed, stopped, strange." in page.text
    assert "4 of 7 checks in 4 cases hold" in page.text
    for name in ("missed", "stopped", "strange"):
        assert f'<section id="{name}" class="failed">' in text
    assert '<section id="good">' in text
    assert "stopped by ValueError: no <convergence> (case.py, line 4)" in page.text
    assert "run() gave 'a text'; accepted are Check, Curves, Orders and Shape" in page.text
    calm, _ = page_of(run_cases(cases[:1]), tmp_path / "calm.html")
    assert "FAILED" in page.text
    assert "FAILED" not in calm.text


def test_text_of_a_case_is_shown_without_foreign_content() -> None:
    shown = markdown(README)
    assert "<td>sag</td>" in shown
    assert "<h3>Equations</h3>" in shown
    assert "<pre><code>w = F L^3 / (3 E I)" in shown
    assert "[a file](other.md)" in shown
    assert '<a href="https://example.org/a.png">a picture</a>' in shown
    for absent in ("<h1", "Sag of", "<script", "<img"):
        assert absent not in shown


def test_nothing_is_drawn_unless_a_manual_is_asked_for(cases, tmp_path: Path, monkeypatch, capsys) -> None:
    def refuse(_: object) -> str:
        raise AssertionError("drawn")

    monkeypatch.setattr(manual, "drawn", refuse)
    monkeypatch.setattr(verify, "find_cases", lambda names: cases[:1])
    assert verify.verify_command([], as_json=False, fast=False, report=None) == 0
    assert "3 of 3 checks in 1 cases passed" in capsys.readouterr().out
    with pytest.raises(AssertionError, match="drawn"):
        verify.verify_command([], as_json=False, fast=False, report=tmp_path / "manual.html")


@pytest.mark.parametrize(("place", "message"), [("nowhere/m.html", "there is no folder"), ("taken", "it is a folder")])
def test_a_place_that_cannot_be_written_is_refused_before_the_run(
    cases, tmp_path: Path, monkeypatch, place: str, message: str
) -> None:
    def refuse(_: object) -> None:
        raise AssertionError("run")

    (tmp_path / "taken").mkdir()
    before = sorted(tmp_path.rglob("*"))
    monkeypatch.setattr(verify, "find_cases", lambda names: cases)
    monkeypatch.setattr(verify, "run_cases", refuse)
    with pytest.raises(ResultFileError, match=f"cannot be written: {message}"):
        verify.verify_command([], as_json=False, fast=False, report=tmp_path / place)
    assert sorted(tmp_path.rglob("*")) == before


def test_a_page_that_fails_leaves_the_old_one(cases, tmp_path: Path, monkeypatch) -> None:
    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    folder = tmp_path / "out"
    folder.mkdir()
    (folder / "manual.html").write_text("old")
    book = Manual(folder / "manual.html")
    monkeypatch.setattr(os, "replace", full)
    with pytest.raises(ResultFileError, match="No space left on device"):
        book.write()
    assert [path.name for path in folder.iterdir()] == ["manual.html"]
    assert (folder / "manual.html").read_text() == "old"


def test_shapes_are_small_pictures_and_wrong_ones_are_told(cases, tmp_path: Path) -> None:
    source = drawn(Shape("A plate", stand_in.result()))
    assert source.startswith("data:image/webp;base64,")
    with Image.open(io.BytesIO(base64.b64decode(source.partition("base64,")[2]))) as image:
        assert image.width == 960
        assert len(image.convert("RGB").getcolors(2**24) or []) > 20  # not an empty sheet
    (outcome,) = run_cases(cases[:1])
    wrong = Shape("A plate", stand_in.result(), field="colour")
    object.__setattr__(outcome, "pictures", (wrong,))
    page, _ = page_of([outcome], tmp_path / "manual.html")
    assert "A plate: not drawn, picture: no field 'colour'; accepted are displacement" in page.text


def test_curves_and_orders_refuse_what_cannot_be_drawn() -> None:
    with pytest.raises(DeclarationError, match=r"Curves 'c': 'a' has x of shape \(2,\) and y of shape \(3,\)"):
        Curves("c", "x", "y", {"a": ([1, 2], [1, 2, 3])})
    with pytest.raises(DeclarationError, match="Curves 'c': nothing to draw"):
        Curves("c", "x", "y", {})
    with pytest.raises(DeclarationError, match="Orders 'o': 'a' is not above zero"):
        Orders("o", "x", {"a": ([1, 2], [0.0, 1.0])})


def test_many_reference_points_are_thinned_out() -> None:
    x = np.linspace(0.0, 1.0, 1001)
    figure = plot_curves({"a": (x, x)}, "x", "y", points={"many": (x, x), "few": (x[:5], x[:5])}, log="x")
    _, many, few = figure.axes[0].lines
    assert 1001 / MOST_MARKERS <= many.get_markevery() <= 1001 / MOST_MARKERS + 1
    assert few.get_markevery() == 1
    assert figure.axes[0].get_xscale() == "log"


@pytest.mark.parametrize(
    ("name", "written"), [("manual", "manual.html"), ("manual.v2", "manual.v2.html"), ("page.htm", "page.htm")]
)
def test_a_manual_is_a_page_whatever_it_is_called(tmp_path: Path, name: str, written: str) -> None:
    verify._manual(["beam"], fast=False, path=tmp_path / name).write()
    assert [path.name for path in tmp_path.iterdir()] == [written]

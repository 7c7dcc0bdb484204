"""Curved shells that cannot be, and paths that cannot go on: one clear message, and what was computed is kept."""

from __future__ import annotations

from pathlib import Path

import pytest
from test_bad_input import one_message

from lamella.io.results import read_result

ROOF = """\
lamella: 1
system:
  roof:
    type: shell
    surface: {kind: cylinder, radius: 2.54, length: 0.254, angle: [84.27042 deg, 90 deg]}
    mesh: [4, 4]
    laminate: {ply: {E: 3.10275 GPa, nu: 0.3, rho: 1000}, thickness: 6.35 mm}
    markers: {crown: [0.254, 0]}
  hinge: {type: edge_support, on: roof.x-}
  middle: {type: symmetry, on: roof.x+, normal: x}
  front: {type: symmetry, on: roof.y-, normal: z}
  load: {type: point_force, on: roof.crown, force: [0, -250 N, 0]}
analysis:
  path: {type: path, arc: {largest: 0.004}}
"""

CORNER = "points: [[[0,0,0],[1,0,0],[0.5,0,0.001]],[[0,1,0],[1,1,0],[0.5,1,0.001]]]"


@pytest.fixture
def roof(tmp_path: Path) -> Path:
    path = tmp_path / "roof.yaml"
    path.write_text(ROOF)
    return path


@pytest.mark.parametrize(
    ("override", "said"),
    [
        ("surface={kind: tube, length: 1}", "there is no kind 'tube'; accepted are points, pulleys, cylinder, belt"),
        ("markers.crown=[0.26, 0]", "marker 'crown' lies outside the shell at x = 0.26 m"),
        ("surface={kind: cylinder, radius: 1, length: 1, angle: [0, 6], closed: true}", "its ends do not meet: the angle spans"),
        ("surface={kind: points, " + CORNER + "}", "the surface folds: its normal turns over at x = "),
        ("surface={kind: belt, length: 1, width: 1}", "no edge 'x-': it is closed along x; its edges are y- and y+"),
        ("ply_direction=[0, 1, 0]", "the ply direction (0, 1, 0) is normal to the surface near ("),
        ("thickness_factors=[[1, 2]]", "accepted are 4 rows of 4 numbers"),
        ("strain=rigid", "is a RigidBody"),
    ],
)
def test_shell_that_cannot_be(here, roof: Path, override: str, said: str) -> None:
    assert said in one_message(here("run", roof, "--out", "out", "--no-pictures", "--set", f"system.roof.{override}"))


def test_path_that_cannot_go_on_keeps_its_points(here, roof: Path, tmp_path: Path) -> None:
    done = here("run", roof, "--out", "out", "--no-pictures", "--set", "analysis.path.arc={largest: 0.004, max_steps: 6}")
    assert done.returncode != 0
    assert "6 steps; raise max_steps of the arc length" in done.stderr
    kept = read_result(tmp_path / "out" / "run.h5")
    assert len(kept.at) == 7
    assert not kept.outcome.completed
    assert kept.outcome.reached == pytest.approx(float(kept.history("load_factor")[-1]))


def test_arc_length_that_gives_up_says_where(here, roof: Path, tmp_path: Path) -> None:
    done = here(
        "run",
        roof,
        "--out",
        "out",
        "--no-pictures",
        "--set",
        "analysis.path={type: path, newton: {max_iterations: 1}, arc: {smallest: 0.5}}",
    )
    assert done.returncode != 0
    assert "the arc length cannot go on: its step fell to" in done.stderr
    assert len(read_result(tmp_path / "out" / "run.h5").at) == 1  # the unloaded state

"""Model files: what is read, what is refused and with which words, and the way back."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest

import lamella as lm
from lamella.declaration import declaration
from lamella.errors import DeclarationError, ModelFileError
from lamella.io.analysis import Motion
from lamella.io.annotation import concrete
from lamella.io.document import Document
from lamella.io.model_file import dumps, loads, read_model
from lamella.io.schema import QUANTITY, arguments, declaration_schema, json_schema
from lamella.io.sections import SECTIONS
from lamella.io.static_analysis import NaturalModes, Statics
from lamella.optimisation.problem import Optimisation
from lamella.roles import Declaration
from lamella.sweep.study import ParameterStudy
from lamella.templates import template, templates

MODEL = """\
lamella: 1
title: Test
materials:
  carbon: {E1: 181 GPa, E2: 10.3 GPa, G12: 7.17 GPa, nu12: 0.28, rho: 1600}
laminates:
  cross: {ply: carbon, angles: [0, 90, 0], thickness: 1.5 mm}
profiles:
  slowly: {kind: ramp, t_end: 1 s}
system:
  root: {type: clamp, on: plate.x-}
  plate:
    type: plate
    size: [1.5 m, 200 cm]
    mesh: [2, 3]
    laminate: cross
    markers: {tip: [1500 mm, 1]}
  load: {type: point_force, on: plate.tip, force: [0, 0, -0.01 kN], profile: slowly}
  corner: {type: point_force, on: plate.x+y+, force: [1, 0, 0], profile: 2}
  frame: {type: ground, markers: {hook: [1.5, 1, 1]}}
  rod: {type: distance_joint, a: plate.tip, b: frame.hook}
analysis:
  still: {type: statics, steps: [0.5, 1]}
  swing: {type: motion, t_end: 2 s, integrator: {dt: 1 ms, rho_inf: 0.8}, start: still}
  modes: {type: natural_modes, count: 5, about: still}
output: {frames: 20}
"""

BODIES = """\
lamella: 1
redundant: drop
system:
  lock: {type: gauge, on: pin, others: [ball]}
  pin: {type: revolute_joint, a: frame.hook, b: hub.origin, axis: [0, 1, 0]}
  frame: {type: ground, markers: {hook: [0, 0, 1]}}
  hub:
    type: rigid_body
    shape: {kind: box, size: [20 cm, 0.2, 0.3]}
    density: 2700
    position: [0, 0, 1]
    markers: {rim: [0.1, 0, 0]}
  panel:
    type: plate
    size: [1, 0.2]
    mesh: [2, 1]
    laminate: {ply: {type: isotropic, E: 70 GPa, nu: 0.3, rho: 2700}, thickness: 2 mm}
    position: [0.1, -0.1, 1]
  root: {type: fixed_joint, a: hub.rim, b: panel.x-}
  end: {type: rigid_body, mass: 2, inertia: [1, 1, 1], position: [1.1, 0, 1]}
  ball: {type: spherical_joint, a: panel.x+y-, b: end.origin}
"""
"""Bodies and joints; the ball is not where its markers are, which only compiling finds."""


@declaration
class Gauge(Declaration):
    """Something that refers to joints.

    Args:
        name: unique name.
        on: a joint.
        others: further joints.
    """

    name: str
    on: lm.RevoluteJoint | lm.EdgeHinge
    others: tuple[lm.SphericalJoint, ...] = ()

    def contribute(self, build) -> None:
        """Nothing."""


def refused(text: str, *overrides: str) -> str:
    with pytest.raises(ModelFileError) as caught:
        loads(text, overrides, "model.yaml")
    return str(caught.value)


def changed(old: str, new: str) -> str:
    assert MODEL.count(old) == 1
    return MODEL.replace(old, new)


def line_of(text: str) -> int:
    return MODEL[: MODEL.index(text)].count("\n") + 1


def test_declarations_are_those_of_python() -> None:
    model = loads(MODEL)
    root, plate, load, corner, frame, rod = model.system.declarations
    ply = lm.Lamina(181e9, 10.3e9, 7.17e9, 0.28, 1600)
    layup = lm.Laminate(ply, angles=(0, 90, 0), thickness=1.5e-3)
    assert plate == lm.Plate("plate", (1.5, 2.0), (2, 3), layup, markers={"tip": (1.5, 1.0)})
    assert (root.on.body, root.on.side) == (plate, "x-")
    assert load == lm.PointForce("load", plate.marker("tip", 1.5, 1.0), (0, 0, -10), lm.Ramp(t_end=1.0))
    assert corner == lm.PointForce("corner", plate.corner("x+y+"), (1, 0, 0), lm.Constant(2.0))
    assert rod == lm.DistanceJoint("rod", plate.marker("tip", 1.5, 1.0), frame.marker("hook", 1.5, 1, 1))
    still, swing, modes = model.analyses
    assert still == Statics("still", steps=(0.5, 1.0))
    assert swing == Motion("swing", 2.0, lm.GeneralizedAlpha(1e-3, 0.8), start="still")
    assert modes == NaturalModes("modes", 5, about="still")
    assert model.output.frames == 20


def test_bodies_joints_and_references_to_joints_are_read_and_written() -> None:
    system = loads(BODIES).system
    lock, pin, frame, hub, panel, root, end, ball = system.declarations
    assert hub == lm.RigidBody(
        "hub", shape=lm.Box((0.2, 0.2, 0.3)), density=2700, position=(0, 0, 1), markers={"rim": (0.1, 0, 0)}
    )
    assert pin == lm.RevoluteJoint("pin", frame.marker("hook", 0, 0, 1), hub.origin, (0, 1, 0))
    assert root.a == hub.marker("rim", 0.1, 0, 0)
    assert (root.b.body, root.b.side) == (panel, "x-")
    assert ball == lm.SphericalJoint("ball", panel.corner("x+y-"), end.origin)
    assert (lock.on, lock.others) == (pin, (ball,))
    assert system.redundant == "drop"
    text = dumps(system)
    assert loads(text).text() == text
    assert "redundant: drop" in text
    assert "on: pin\n    others: [ball]\n" in text
    assert loads(BODIES, ["redundant=raise"]).system.redundant == "raise"


def test_the_kind_of_a_clamp_is_a_key_beside_its_type() -> None:
    text = changed("{type: clamp, on: plate.x-}", "{type: clamp, on: plate.x-, kind: sliding}")
    system = loads(text).system
    assert system.declarations[0].kind == "sliding"
    assert "kind: sliding" in dumps(system)
    assert loads(dumps(system)).system.declarations[0].kind == "sliding"
    with pytest.raises(ModelFileError, match=r"system\.root\.kind: found 'loose'; accepted are full, restrained, sliding"):
        loads(changed("{type: clamp, on: plate.x-}", "{type: clamp, on: plate.x-, kind: loose}"))


SUPPORTS = """\
lamella: 1
system:
  ground: {type: ground}
  hub: {type: rigid_body, mass: 2, inertia: [1, 1, 1], position: [0, 0, 1], markers: {face: [0.1, 0, 0]}}
  panel:
    type: plate
    size: [1, 0.2]
    mesh: [2, 1]
    laminate: {ply: {type: isotropic, E: 70 GPa, nu: 0.3, rho: 2700}, thickness: 2 mm}
    markers: {tip: [0.7, 0.1]}
  middle: {type: symmetry, on: panel.y+, normal: y}
  end: {type: diaphragm, on: panel.x+, normal: [1, 0, 0.5]}
  foot: {type: edge_support, on: panel.y-, axes: xz, rotation: [0, 0, 30 deg], motion: {z: {kind: ramp, t_end: 1 s, end: 0.1}}}
  mean: {type: edge_average, on: panel.x-, rotations: yz, to: hub.face}
  space: {type: edge_average, on: panel.x-, axes: x, motion: {x: 0.5}}
  lever:
    type: linear_constraint
    terms:
      - {on: panel.tip, axis: z, factor: 2}
      - {on: panel.x+y+, axis: [0, 1, 1], factor: -0.5, of: slope_x}
      - {on: hub.origin, axis: x}
    value: 0.25
    absolute: true
"""


def test_supports_of_edges_and_linear_constraints_are_read_and_written() -> None:
    system = loads(SUPPORTS).system
    items = {item.name: item for item in system.declarations}
    panel, hub = items["panel"], items["hub"]
    assert (items["middle"].on.body, items["middle"].on.side, items["middle"].normal) == (panel, "y+", "y")
    assert items["end"].normal == (1.0, 0.0, 0.5)
    assert items["foot"].rotation == pytest.approx((0.0, 0.0, 0.5235987755982988))
    assert items["foot"].motion == {"z": lm.Ramp(t_end=1.0, end=0.1)}
    assert (items["mean"].axes, items["mean"].rotations, items["mean"].to) == ("xyz", "yz", hub.marker("face", 0.1, 0, 0))
    assert (items["space"].to, items["space"].motion) == (None, {"x": lm.Constant(0.5)})
    tip, corner = panel.marker("tip", 0.7, 0.1), panel.corner("x+y+")
    assert items["lever"] == lm.LinearConstraint(
        "lever",
        (
            lm.Component(tip, "z", 2.0),
            lm.Component(corner, (0.0, 1.0, 1.0), -0.5, "slope_x"),
            lm.Component(hub.origin, "x"),
        ),
        lm.Constant(0.25),
        absolute=True,
    )
    text = dumps(system)
    assert loads(text).text() == text
    again = {item.name: item for item in loads(text).system.declarations}
    assert again["lever"] == items["lever"]
    assert again["foot"].motion == items["foot"].motion


DRIVEN = """\
lamella: 1
profiles:
  push: {kind: table, times: [0, 500 ms], values: [0 mm, 10 mm]}
  turn: {kind: smooth_step, t_end: 1 s, end: 90 deg}
  share: {kind: ramp, t_end: 1 s, end: 50 percent}
  unused: {kind: ramp, t_end: 1 s, end: 3 km}
system:
  ground: {type: ground}
  crank: {type: rigid_body, mass: 1, inertia: [1, 1, 1]}
  pin: {type: revolute_joint, a: ground.origin, b: crank.origin}
  motor: {type: angle_drive, on: pin, speed: {kind: ramp, t_end: 2 s, start: 30 rpm, end: 60 rpm}}
  spring: {type: torsion_spring, on: pin, stiffness: 1, rest_angle: turn, preload: 3 N*cm}
  slider: {type: rigid_body, mass: 1, inertia: [1, 1, 1]}
  rail: {type: prismatic_joint, a: ground.origin, b: slider.origin}
  feed:
    type: slide_drive
    on: rail
    displacement: {kind: integral, start: 5 mm, of: {kind: polynomial, t_end: 1 s, coefficients: [1 mm/s, 2 mm/s^2]}}
  stop: {type: slide_spring, on: rail, stiffness: 1, rest: push, preload: {kind: harmonic, amplitude: 2 kN, frequency: 1 Hz}}
  winch: {type: distance_joint, a: ground.origin, b: slider.origin, length: 1 m, change: {kind: integral, of: -5 mm/s}}
  push: {type: gravity, profile: share}
"""


def test_profiles_have_the_unit_of_what_they_stand_for() -> None:
    found = {item.name: item for item in loads(DRIVEN).system.declarations}
    assert found["motor"].speed == lm.Ramp(t_end=2.0, start=np.pi, end=2 * np.pi)
    assert found["spring"].rest_angle == lm.SmoothStep(t_end=1.0, end=np.pi / 2)
    assert found["spring"].preload == lm.Constant(0.03)
    assert found["feed"].displacement == lm.Integral(lm.Polynomial((1e-3, 2e-3), t_end=1.0), start=5e-3)
    assert found["stop"].rest == lm.Table((0.0, 0.5), (0.0, 0.01))
    assert found["stop"].preload == lm.Harmonic(2000.0, 1.0)
    assert found["winch"].change == lm.Integral(-5e-3)
    assert found["push"].profile == lm.Ramp(t_end=1.0, end=0.5)
    again = {item.name: item for item in loads(loads(DRIVEN).text()).system.declarations}
    assert again == found


@pytest.mark.parametrize(
    ("old", "new", "place", "said"),
    [
        ("end: 60 rpm", "end: 60 mm", "system.motor.speed.end", "'60 mm' has the unit mm, which does not convert to rad/s"),
        ("[0 mm, 10 mm]", "[0 mm, 10 kg]", "profiles.push.values[1]", "'10 kg' has the unit kg, which does not convert to m;"),
        ("[0 mm, 10 mm]", "10 mm", "profiles.push.values", "found '10 mm'; accepted is a list"),
        ("rest: push", "rest: turn", "profiles.turn.end", "'90 deg' has the unit deg, which does not convert to m;"),
        ("start: 5 mm", "start: 5 mm/s", "system.feed.displacement.start", "which does not convert to m;"),
        ("2 mm/s^2", "2 mm/s", "system.feed.displacement.of.coefficients[1]", "which does not convert to m/s^2;"),
        ("of: -5 mm/s", "of: -5 mm", "system.winch.change.of", "'-5 mm' has the unit mm, which does not convert to m/s;"),
        ("preload: 3 N*cm", "preload: 3 N", "system.spring.preload", "'3 N' has the unit N, which does not convert to N m;"),
        ("preload: 3 N*cm", "preload: 3e40", "system.spring.preload", "too large to compute with; accepted is at most 1e+30"),
        ("end: 3 km", "end: 3 kmx", "profiles.unused.end", "'3 kmx' is not a number with a known unit"),
        ("profile: share", "profile: push", "profiles.push.values[1]", "which does not convert to a pure number"),
        (
            "change: {kind: integral, of: -5 mm/s}",
            "change: far",
            "system.winch.change",
            "nothing is defined under the name 'far'",
        ),
        (
            "change: {kind: integral, of: -5 mm/s}",
            "change: true",
            "system.winch.change",
            "accepted is a number in m such as '1.5 m'",
        ),
    ],
)
def test_message_about_the_unit_of_a_profile(old: str, new: str, place: str, said: str) -> None:
    assert DRIVEN.count(old) == 1
    message = refused(DRIVEN.replace(old, new))
    assert f", {place}: " in message
    assert said in message


@pytest.mark.parametrize(
    ("old", "new", "key", "said"),
    [
        ("normal: y}", "normal: w}", "system.middle.normal", "x, y, z"),
        ("normal: y}", "normal: [0, 1]}", "system.middle.normal", "the list has 2 items; accepted are 3"),
        ("on: panel.y+,", "on: panel.tip,", "system.middle.on", "'panel.tip' is a marker; accepted is an edge"),
        ("to: hub.face", "to: panel.y-", "system.mean.to", "'panel.y-' is an edge; accepted is a marker"),
        ("axes: xz", "axes: xw", "system.foot.axes", "axes 'xw'; accepted are distinct letters"),
        ("axes: xz", "axes: xy", "system.foot.motion", "a motion along z of an edge held along x, y"),
        ("on: panel.tip, axis: z", "on: panle.tip, axis: z", "system.lever.terms[0].on", "did you mean 'panel'?"),
        ("factor: 2}", "factr: 2}", "system.lever.terms[0].factr", "did you mean 'factor'?"),
        ("of: slope_x", "of: slope", "system.lever.terms[1].of", "accepted are position, slope_x, slope_y"),
        ("axis: x}", "axis: r}", "system.lever.terms[2].axis", "x, y, z"),
    ],
)
def test_message_about_supports_and_constraints(old: str, new: str, key: str, said: str) -> None:
    assert SUPPORTS.count(old) == 1
    message = refused(SUPPORTS.replace(old, new))
    assert f", {key}: " in message
    assert said in message


def test_constraint_without_terms_is_refused() -> None:
    first = SUPPORTS.index("    terms:")
    message = refused(SUPPORTS[:first] + "    terms: []\n")
    assert "system.lever" in message
    assert "terms" in message


@pytest.mark.parametrize(
    ("old", "new", "key", "said"),
    [
        ("on: pin", "on: pni", "system.lock.on", "there is no revolute_joint or edge_hinge 'pni'; did you mean 'pin'?"),
        ("on: pin", "on: ball", "system.lock.on", "'ball' has the type spherical_joint; accepted are pin"),
        ("on: pin", "on: [pin]", "system.lock.on", "accepted is the name of an item (revolute_joint, edge_hinge)"),
        ("[ball]", "[bal]", "system.lock.others[0]", "there is no spherical_joint 'bal'; did you mean 'ball'?"),
        ("on: pin", "on: lock", "system.lock", "'lock' refers to itself"),
        ("kind: box", "kind: bax", "system.hub.shape.kind", "there is no kind 'bax'; did you mean 'box'?"),
        (
            "{kind: box, size: [20 cm, 0.2, 0.3]}",
            "{radius: 1}",
            "system.hub.shape",
            "'kind' is missing; accepted are box, cylinder",
        ),
        ("{kind: box, size: [20 cm, 0.2, 0.3]}", "box", "system.hub.shape", "found 'box'; accepted is a mapping (box, cylinder"),
        ("{kind: box, size: [20 cm, 0.2, 0.3]}", "3", "system.hub.shape", "found 3; accepted is a mapping (box, cylinder"),
        ("size: [20 cm, 0.2, 0.3]", "size: [20 kg, 0.2, 0.3]", "system.hub.shape.size[0]", "does not convert to m"),
        ("density: 2700", "denisty: 2700", "system.hub.denisty", "did you mean 'density'?"),
        (
            "b: hub.origin",
            "b: hub.rin",
            "system.pin.b",
            "'hub' has no marker or edge 'rin'; did you mean 'rim'? accepted are rim, origin",
        ),
        ("b: hub.origin", "b: hub.x-", "system.pin.b", "'hub' has no marker or edge 'x-'; accepted are rim, origin"),
        ("b: hub.origin", "b: hub", "system.pin.b", "found 'hub'; accepted is a marker such as plate.tip"),
        ("b: panel.x-", "b: pin.x-", "system.root.b", "'pin' has the type revolute_joint; accepted are frame, hub, panel, end"),
        ("axis: [0, 1, 0]", "axes: [0, 1, 0]", "system.pin.axes", "revolute_joint has no key 'axes'; did you mean 'axis'?"),
        ("redundant: drop", "redundant: dorp", "redundant", "found 'dorp'; did you mean 'drop'? accepted are raise, drop"),
    ],
)
def test_message_about_bodies_and_joints(old: str, new: str, key: str, said: str) -> None:
    assert BODIES.count(old) == 1
    message = refused(BODIES.replace(old, new))
    line = BODIES[: BODIES.index(old)].count("\n") + 1
    assert f"line {line}, {key}: " in message
    assert said in message
    assert "error" not in message


def test_ground_that_was_not_added_is_written() -> None:
    system, hub = lm.System(), lm.RigidBody("hub", 1.0, (1, 1, 1))
    system.add(hub)
    system.add(lm.RevoluteJoint("pin", lm.Ground().marker("hook", 0, 0, 0), hub.origin))
    system.add(lm.PointInPlaneJoint("plane", lm.Ground().marker("floor", 0, 0, -1), hub.marker("foot", 0, 0, -1)))
    again = {item.name: item for item in loads(dumps(system)).system.declarations}
    assert again["ground"] == lm.Ground(markers={"hook": (0, 0, 0), "floor": (0, 0, -1)})
    assert again["pin"].a.at == (0, 0, 0)
    system.add(lm.SphericalJoint("ball", lm.Ground().marker("floor", 0, 0, -2), hub.origin))
    with pytest.raises(DeclarationError, match=r"Ground 'ground': marker 'floor' is at \(0\.0, 0\.0, -1\.0\) and"):
        dumps(system)
    with pytest.raises(DeclarationError, match=r"Ground 'ground': marker 'hook' is already at"):
        lm.Ground(markers={"hook": (0, 0, 0)}).marker("hook", 1, 0, 0)


def test_every_public_declaration_can_be_written_in_a_file() -> None:
    accepted = SECTIONS["system"].classes()
    public = [item for name in lm.__all__ if isinstance(item := getattr(lm, name), type) and issubclass(item, Declaration)]
    assert public
    in_python = {cls for cls in concrete(Declaration) if cls.python_only}
    assert set(public) - in_python <= set(accepted) == set(concrete(Declaration)) - in_python
    assert {cls.__name__ for cls in in_python} == {"Controller", "UserForce"}


def test_text_written_reads_as_the_same_model() -> None:
    text = loads(MODEL).text()
    assert loads(text).text() == text
    assert loads(text).analyses == loads(MODEL).analyses
    plates = [loads(t).system.declarations[1] for t in (text, MODEL)]
    assert plates[0] == plates[1]


def test_system_built_in_python_can_be_written() -> None:
    system = lm.System()
    sheet = lm.Laminate(lm.Isotropic(70e9, 0.3, 2700), thickness=1e-3)
    plate = system.add(lm.Plate("p", (1, 1), (2, 2), sheet))
    tip = plate.marker("tip", 1, 0.5)
    system.add(lm.Clamp("c", plate.edge("x-"), {"z": lm.Harmonic(0.1, 2.0)}))
    system.add(lm.PointForce("f", tip, (0, 0, 1), lm.Table((0, 1), (0, 1))))
    again = loads(dumps(system, title="Mine")).system.declarations
    assert again[0] == plate
    assert again[2] == system.declarations[2]
    assert again[1].motion == system.declarations[1].motion


def test_marker_that_is_not_of_its_body_cannot_be_written() -> None:
    system = lm.System()
    plate = lm.Plate("p", (1, 1), (2, 2), lm.Laminate(lm.Isotropic(70e9, 0.3, 2700), thickness=1e-3))
    other = lm.Plate("p", (1, 1), (2, 2), plate.laminate)
    system.add(plate)
    system.add(lm.PointForce("f", other.marker("far", 1, 1), (0, 0, 1)))
    plate.markers.clear()
    other.markers.clear()
    with pytest.raises(DeclarationError, match=r"PointForce 'f': on: the marker p\.far is not one of its body"):
        dumps(system)


@pytest.mark.parametrize("name", templates())
def test_templates_are_valid(name: str) -> None:
    model = loads(template(name), name=name)
    assert model.title
    assert model.analyses


@pytest.mark.parametrize(
    ("old", "new", "key", "said"),
    [
        (
            "size: [1.5 m, 200 cm]",
            "size: [1.5 m, 200 kg]",
            "system.plate.size[1]",
            "'200 kg' has the unit kg, which does not convert to m",
        ),
        ("mesh: [2, 3]", "mesh: [0, 3]", "system.plate.mesh[0]", "found 0; accepted is a value at least 1"),
        ("mesh: [2, 3]", "mesh: [2, 3, 4]", "system.plate.mesh", "the list has 3 items; accepted are 2"),
        ("mesh: [2, 3]", "mesh: many", "system.plate.mesh", "found 'many'"),
        ("type: plate\n", "membrane_gauss: 2\n    type: plate\n", "system.plate.membrane_gauss", "found 2; accepted are 3, 4"),
        ("type: plate\n", "curvature: cubed\n    type: plate\n", "system.plate.curvature", "unit_normal"),
        ("mesh: [2, 3]", "mesh: 2", "system.plate.mesh", "found 2; accepted is a list of 2"),
        ("mesh: [2, 3]", "mesh: [2, x]", "system.plate.mesh[1]", "found 'x'; accepted is a whole number"),
        ("tip: [1500 mm, 1]", "tip: [1]", "system.plate.markers.tip", "the list has 1 items; accepted are 2"),
        ("{frames: 20}", "{csv: perhaps}", "output.csv", "found 'perhaps'; accepted is true or false"),
        ("on: plate.x-", "on: plate.x-, motion: 1 mm", "system.root.motion", "found '1 mm'; accepted is a mapping"),
        ("mesh: [2, 3]", "mash: [2, 3]", "system.plate.mash", "did you mean 'mesh'?"),
        ("laminate: cross\n", "laminate: crossed\n", "system.plate.laminate", "did you mean 'cross'?"),
        ("tip: [1500 mm, 1]", "tip: [1600 mm, 1]", "system.plate.markers.tip", "marker 'tip' lies outside the plate"),
        ("thickness: 1.5 mm", "thickness: -1.5 mm", "laminates.cross.thickness", "accepted is a value greater than 0"),
        ("thickness: 1.5 mm", "thickness: 0", "laminates.cross.thickness", "accepted is a value greater than 0"),
        ("rho: 1600", "rho: .nan", "materials.carbon.rho", "nan is not finite"),
        ("nu12: 0.28", "nu12: 9", "materials.carbon.nu12", "nu12 = 9; accepted is abs(nu12)"),
        (
            "type: clamp, on: plate.x-",
            "type: clmp, on: plate.x-",
            "system.root.type",
            "there is no type 'clmp'; did you mean 'clamp'?",
        ),
        ("type: clamp, on: plate.x-", "on: plate.x-", "system.root", "'type' is missing; accepted are angle_coupling, "),
        ("on: plate.x-", "onn: plate.x-", "system.root.onn", "clamp has no key 'onn'; did you mean 'on'?"),
        ("type: clamp, on: plate.x-", "type: clamp", "system.root", "clamp needs 'on'"),
        ("on: plate.x-", "on: plat.x-", "system.root.on", "there is no body 'plat'; did you mean 'plate'?"),
        ("on: plate.x-", "on: plate.z-", "system.root.on", "'plate' has no marker or edge 'z-'; accepted are tip, "),
        ("on: plate.x-", "on: plate", "system.root.on", "found 'plate'; accepted is an edge such as plate.x- or a marker"),
        (
            "on: plate.x-",
            "on: 7",
            "system.root.on",
            "found 7; accepted is an edge such as plate.x- or a marker such as plate.tip",
        ),
        ("on: plate.tip", "on: plate.x+", "system.load.on", "'plate.x+' is an edge; accepted is a marker"),
        ("profile: slowly", "profile: slow", "system.load.profile", "did you mean 'slowly'?"),
        ("profile: slowly", "profile: {kind: stp}", "system.load.profile.kind", "there is no kind 'stp'; did you mean 'step'?"),
        ("profile: slowly", "profile: {kind: {}}", "system.load.profile.kind", "found a mapping; accepted are constant, step"),
        (
            "type: clamp, on: plate.x-",
            "type: true, on: plate.x-",
            "system.root.type",
            "found true; accepted are ground, rigid_body",
        ),
        ("profile: slowly", "profile: [1]", "system.load.profile", "found [1]; accepted is a number or a mapping"),
        ("t_end: 2 s", "t_end: 0", "analysis.swing.t_end", "t_end = 0 s; accepted is a time later than"),
        ("{frames: 20}", "{frames: 0}", "output.frames", "accepted is a value at least 1"),
        ("title: Test", "tilte: Test", "tilte", "there is no section 'tilte'; did you mean 'title'?"),
        ("lamella: 1", "lamella: 7", "lamella", "found version 7 of the model file; accepted is 1"),
        (
            "{frames: 20}",
            "!!python/object/apply:os.getcwd []",
            "output",
            "the tag tag:yaml.org,2002:python/object/apply:os.getcwd is not",
        ),
        ("corner: {", "load: {", "system.load", "the key 'load' is already given in line"),
        ("corner: {", "plate.a: {", "system.plate.a", "the name 'plate.a' is not accepted"),
        ("corner: {type", "corner: {name: x, type", "system.corner.name", "the name is the key 'corner' and is not repeated"),
    ],
)
def test_message_names_line_key_and_what_is_accepted(old: str, new: str, key: str, said: str) -> None:
    message = refused(changed(old, new))
    assert f"line {line_of(old)}, {key}: " in message
    assert said in message
    assert "error" not in message  # one cause gives one message, without others that only follow from it


def test_all_errors_are_told_in_the_order_of_lines() -> None:
    text = changed("mesh: [2, 3]", "mesh: [0, 3]").replace("-0.01 kN", "-0.01 kg").replace("rho: 1600", "rho: -1")
    lines = refused(text).splitlines()
    assert lines[0] == "model.yaml: 3 errors"
    assert [line.split(",")[0] for line in lines[1:]] == [f"  line {line_of(part)}" for part in ("rho", "mesh", "-0.01 kN")]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "model.yaml is empty; 'lamella new' writes a template"),
        ("# nothing\n", "model.yaml is empty"),
        ("just words", "expected 'key: value' lines, found 'just words'"),
        (
            "lamella: 1\nsystem:\n\tplate: 1",
            "line 3, column 1: not valid YAML: a tab is used to indent; accepted are spaces only",
        ),
        ("a: [1, 2", "line 1, column 9: not valid YAML"),
        ("a: b: c", "line 1, column 5: not valid YAML: a ':' is not allowed here"),
        ("a: \x00", "is not a text file of a model"),
        ("lamella: 1", "no body, joint or load is given"),
        ("system: {}", "the line 'lamella: 1' is missing"),
        ("lamella: 1\nsystem: [1]", "line 2, system: found [1]; accepted are 'name: {...}' entries"),
        ("lamella: 1\nsystem: &a {p: *a}", "an alias refers to the item it is part of"),
        ("a: *b", "found undefined alias 'b'"),
    ],
)
def test_what_is_no_model_is_refused(text: str, said: str) -> None:
    assert said in refused(text)


def test_aliases_cannot_explode() -> None:
    levels = [
        f"l{k}: &l{k} [{', '.join([f'*l{k - 1}'] * 9)}]" for k in range(1, 9)
    ]  # 9^8 values, of which only a small part is made
    assert "once its aliases are expanded" in refused("l0: &l0 [1]\n" + "\n".join(levels))


def test_anchors_and_merge_keys_spare_repetition() -> None:
    text = changed(
        "corner: {type: point_force, on: plate.x+y+, force: [1, 0, 0], profile: 2}", "corner: {<<: *load, force: [1, 0, 0]}"
    )
    load, corner = loads(text.replace("load: {", "load: &load {")).system.declarations[2:4]
    assert corner == lm.PointForce("corner", load.on, (1, 0, 0), load.profile)


def test_overrides_replace_and_add_values() -> None:
    model = loads(
        MODEL,
        ["system.plate.mesh=[8, 8]", "analysis.swing.integrator.dt=0.5ms", "system.plate.size[0]=1600 mm", "output.csv=false"],
    )
    plate, swing = model.system.declarations[1], model.analyses[1]
    assert plate.mesh == (8, 8)
    assert plate.size == (1.6, 2.0)
    assert swing.integrator.dt == 5e-4
    assert model.output.csv is False
    assert loads(MODEL, ["description=New words"]).description == "New words"


@pytest.mark.parametrize(
    ("override", "said"),
    [
        ("system.plate.mesh=[0, 2]", "model.yaml, --set system.plate.mesh=[0, 2]: found 0; accepted is a value at least 1"),
        ("system.plat.mesh=[2, 2]", "system has no key 'plat'; did you mean 'plate'?"),
        ("sytem.plate.mesh=[2, 2]", "has no key 'sytem'; did you mean 'system'?"),
        ("system.plate.mesh[5]=2", "system.plate.mesh has items 0 to 1, not '5'"),
        ("system.plate.mush=2", "--set system.plate.mush=2: plate has no key 'mush'; did you mean 'mesh'?"),
        ("title.a=2", "title is 'Test' and has no keys of its own"),
        ("title", "--set title: accepted is key=value"),
        ("title=[1", "--set title=[1: the value is not valid YAML"),
    ],
)
def test_wrong_override_is_named(override: str, said: str) -> None:
    assert said in refused(MODEL, override)


def test_files_that_cannot_be_read(tmp_path: Path) -> None:
    (tmp_path / "picture.yaml").write_bytes(b"\x89PNG\r\n\x1a\n\x00\xff\xfe")
    for path, said in [
        (tmp_path / "none.yaml", "cannot be read: No such file"),
        (tmp_path, "is a folder; expected is a model file"),
        (tmp_path / "picture.yaml", "is not a text file in UTF-8"),
    ]:
        with pytest.raises(ModelFileError, match=said) as caught:
            read_model(path)
        assert str(path) in str(caught.value)


def test_errors_of_a_file_name_its_path(tmp_path: Path) -> None:
    path = tmp_path / "plate.yaml"
    path.write_text(changed("mesh: [2, 3]", "mesh: [0, 3]"))
    with pytest.raises(ModelFileError, match=f"^{path}, line {line_of('mesh')}, system.plate.mesh"):
        read_model(path)


def test_curvature_and_rules_of_a_file_reach_the_section() -> None:
    text = changed("mesh: [2, 3]", "mesh: [2, 3]\n    curvature: cubed_normal\n    membrane_gauss: 3")
    section = loads(text).system.compile().plates[0].section
    assert (section.curvature, section.membrane_gauss) == ("cubed_normal", 3)


def test_schema_describes_units_defaults_and_references() -> None:
    schema = json_schema()
    json.dumps(schema, allow_nan=False)
    plate = schema["$defs"]["Plate"]["properties"]
    assert plate["n_gauss"]["default"] == 4
    assert plate["curvature"]["enum"] == ["unit_normal", "cubed_normal"]
    assert plate["curvature"]["default"] == "unit_normal"
    assert {"enum": [3, 4], "type": "integer"} in plate["membrane_gauss"]["anyOf"]
    assert "Kelvin-Voigt" in plate["damping"]["description"]
    length = schema["$defs"]["Lamina"]["properties"]["E1"]
    assert length["unit"] == "Pa"
    assert {choice["type"] for choice in length["anyOf"]} == {"number", "string"}
    assert "name" not in plate
    assert schema["$defs"]["Clamp"]["required"] == ["type", "on"]
    for reference in [part["$ref"] for part in schema["properties"]["system"]["additionalProperties"]["anyOf"]]:
        assert reference.removeprefix("#/$defs/") in schema["$defs"]


@pytest.mark.parametrize(
    ("kind", "key", "example"),
    [(ParameterStudy, "study", "layup_study/study"), (Optimisation, "optimize", "layup_optimisation/optimize")],
)
def test_schema_of_other_files_knows_the_keys_of_the_examples(kind: type, key: str, example: str) -> None:
    schema = declaration_schema(kind, key, key)
    json.dumps(schema, allow_nan=False)
    given = Document.read(Path(lm.__file__).parent / "examples" / f"{example}.yaml").data
    assert set(given) <= set(schema["properties"])
    assert set(schema["required"]) <= set(given)
    assert key in schema["required"]
    assert schema["additionalProperties"] is False
    for output in given["outputs"].values():
        parts = schema["properties"]["outputs"]["additionalProperties"]["anyOf"]
        known = [schema["$defs"][part["$ref"].removeprefix("#/$defs/")]["properties"] for part in parts]
        assert any(set(output) <= set(each) for each in known)


def test_a_text_that_is_read_again_is_as_before() -> None:
    text = template("cantilever")
    plain, changed = (loads(text, settings).text() for settings in ([], ["system.plate.mesh=[2, 1]"]))
    assert plain != changed
    for _ in range(2):
        with pytest.raises(ModelFileError, match="meshh"):
            loads(text, ["system.plate.meshh=3"])
    assert loads(text).text() == plain


def test_schema_says_how_bodies_joints_and_references_are_written() -> None:
    schema = json_schema()
    hub = schema["$defs"]["RigidBody"]["properties"]
    shapes = [choice.get("$ref") or choice["type"] for choice in hub["shape"]["anyOf"]]
    assert shapes == ["#/$defs/Box", "#/$defs/Cylinder", "#/$defs/Sphere", "null"]
    assert schema["$defs"]["Box"]["properties"]["kind"] == {"const": "box"}
    on = schema["$defs"]["Gauge"]["properties"]["on"]
    assert (on["type"], on["description"]) == ("string", "a joint.")
    assert schema["properties"]["redundant"]["enum"] == ["raise", "drop"]
    assert any(choice.get("type") == "number" for choice in schema["$defs"]["PointForce"]["properties"]["profile"]["anyOf"])


def test_every_argument_has_a_description_in_the_schema() -> None:
    definitions = json_schema()["$defs"]
    for cls in {getattr(lm, name) for name in lm.__all__} & set(SECTIONS["system"].classes()):
        assert set(definitions[cls.__name__]["properties"]) - {"type"} <= set(arguments(cls)), cls.__name__


def test_table_is_read_from_a_file_beside_the_model_and_written_with_its_numbers(tmp_path: Path) -> None:
    (tmp_path / "data").mkdir()
    (tmp_path / "data/forces.csv").write_text("time,force\n0,0\n0.5,2  # half way\n1,-1\n")
    path = tmp_path / "model.yaml"
    path.write_text(
        changed("slowly: {kind: ramp, t_end: 1 s}", "slowly: {kind: table, file: data/forces.csv, interpolation: pchip}")
    )
    model = read_model(path)
    assert model.system.declarations[2].profile == lm.Table((0, 0.5, 1), (0, 2, -1), "pchip")
    (tmp_path / "data/forces.csv").unlink()
    again = loads(model.text())  # self-contained: the file is not needed any more
    assert again.system.declarations[2].profile == model.system.declarations[2].profile
    assert "forces.csv" not in model.text()


@pytest.mark.parametrize(
    ("table", "key", "said"),
    [
        (
            "file: none.csv",
            "file",
            "{folder}/none.csv': the file cannot be read: No such file or directory; accepted is a text file",
        ),
        ("file: bad.csv", "file", "{folder}/bad.csv': line 3 holds 'a,b'"),
        ("file: late.csv", "file", "{folder}/late.csv': times 1 and 2 are 1 and 0; accepted are strictly increasing times"),
        ("file: [1]", "file", "found [1]; accepted is the path of a CSV file"),
        ("file: bad.csv, times: [0, 1]", "times", "'times' does not go with 'file'; accepted are file, interpolation"),
        ("file: bad.csv, interpolation: smooth", "interpolation", "found 'smooth'; accepted are linear, pchip, cubic"),
    ],
)
def test_message_about_a_file_of_a_table_names_line_and_path(tmp_path: Path, table: str, key: str, said: str) -> None:
    (tmp_path / "bad.csv").write_text("t,f\n0,1\na,b\n")
    (tmp_path / "late.csv").write_text("1,1\n0,1\n")
    path = tmp_path / "model.yaml"
    path.write_text(changed("kind: ramp, t_end: 1 s", f"kind: table, {table}"))
    with pytest.raises(ModelFileError) as caught:
        read_model(path)
    message = str(caught.value)
    assert message.startswith(f"{path}, line {line_of('slowly: {kind')}, profiles.slowly.{key}: ")
    assert said.format(folder=tmp_path) in message


def test_schema_takes_a_table_with_points_or_with_a_file() -> None:
    table = json_schema()["$defs"]["Table"]
    assert table["properties"]["file"]["type"] == "string"
    assert [set(way["required"]) for way in table["oneOf"]] == [{"times", "values"}, {"file"}]


def test_integrator_is_told_by_its_type_or_its_keys_and_is_the_usual_one_otherwise() -> None:
    def integrator(text: str) -> lm.BDF | lm.GeneralizedAlpha:
        return loads(changed("{dt: 1 ms, rho_inf: 0.8}", text)).analyses[1].integrator

    assert integrator("{type: bdf, dt: 2 ms, max_order: 3}") == lm.BDF(dt=2e-3, max_order=3)
    assert integrator("{dt: 2 ms, max_order: 3}") == lm.BDF(dt=2e-3, max_order=3)
    assert integrator("{dt: 2 ms}") == lm.GeneralizedAlpha(dt=2e-3)
    assert integrator("{type: generalized_alpha, dt: 2 ms}") == lm.GeneralizedAlpha(dt=2e-3)
    with pytest.raises(ModelFileError, match="max_order"):
        integrator("{type: bdf, dt: 2 ms, max_order: 6}")


def test_interval_of_recording_is_read() -> None:
    model = loads(changed("start: still}\n  modes", "start: still, every: 5 ms}\n  modes"))
    assert model.analyses[1].every == 5e-3
    assert "every" in refused(changed("start: still}\n  modes", "start: still, every: 0 s}\n  modes"))


@pytest.mark.parametrize(
    ("text", "right"),
    [("1.5 mm", True), ("23 1/K", True), ("2.3e-5 1/K", True), ("5%", True), ("2 3", False), ("K", False)],
)
def test_the_schema_knows_a_number_with_a_unit(text: str, right: bool) -> None:
    assert bool(re.match(QUANTITY, text)) == right

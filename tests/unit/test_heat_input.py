"""What cannot be heated is refused by name, what should be known is told, and model files hold every item of heat."""

from __future__ import annotations

import pytest

import lamella as lm
from lamella.errors import ConstraintError, ConvergenceError, DeclarationError, ModelError, UnitError
from lamella.io.model_file import loads
from lamella.units import to_si

MATERIAL = {"E": 70e9, "nu": 0.3, "rho": 2700.0, "alpha": 2.3e-5, "k": 200.0, "c": 900.0}


def heated(kind="restrained", strain="exact", field=True, **material):
    section = lm.Laminate(lm.Isotropic(**(MATERIAL | material)), thickness=2e-3)
    system = lm.System()
    plate = system.add(lm.Plate("panel", (1.0, 0.5), (2, 1), section, strain=strain))
    system.add(lm.Clamp("root", plate.edge("x-"), kind=kind))
    if field:
        system.add(lm.TemperatureField("heat", plate, reference=290.0))
    return system, plate


REFUSED = {
    "absorptivity": (
        lambda plate: lm.SolarFlux("sun", plate, (0, 0, -1), 1.2),
        "SolarFlux 'sun': absorptivity.0 = 1.2; accepted is a value at most 1",
    ),
    "absorptivity of one side": (
        lambda plate: lm.SolarFlux("sun", plate, (0, 0, -1), (0.5, -0.1)),
        "SolarFlux 'sun': absorptivity.1 = -0.1; accepted is a value at least 0",
    ),
    "direction": (
        lambda plate: lm.SolarFlux("sun", plate, (0, 0, 0), 0.5),
        r"SolarFlux 'sun': direction = \(0.0, 0.0, 0.0\); accepted is a vector of some length",
    ),
    "absolute temperature": (
        lambda plate: lm.TemperatureField("heat", plate, reference=-3.0),
        "TemperatureField 'heat': reference = -3.0; accepted is a value at least 0",
    ),
    "absolute temperature in degrees": (
        lambda plate: lm.TemperatureField("heat", plate, reference="-300 degC"),
        "TemperatureField 'heat': reference = -300 degC; accepted is a value at least 0",
    ),
    "space": (lambda plate: lm.Radiation("space", plate, 0.8, space=-1.0), "Radiation 'space': space = -1.0"),
    "emissivity": (lambda plate: lm.Radiation("space", plate, 1.1), "Radiation 'space': emissivity = 1.1"),
    "film": (lambda plate: lm.Film("air", plate, -2.0, 300.0), "Film 'air': coefficient = -2.0"),
    "side": (lambda plate: lm.HeatFlux("lamp", plate, "left", 10.0), "HeatFlux 'lamp': side = 'left'"),
    "side twice": (lambda plate: lm.Film("air", plate, 2.0, 300.0, sides=("top", "top")), "top, bottom or both, each once"),
    "no side": (lambda plate: lm.Radiation("space", plate, 0.8, sides=()), "top, bottom or both, each once"),
    "unit": (lambda plate: lm.HeatFlux("lamp", plate, "top", "10 W"), r"does not convert to W/m\^2"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_impossible_values_are_named(name):
    make, message = REFUSED[name]
    with pytest.raises(DeclarationError, match=message):
        make(heated()[1])


def test_a_side_and_a_share_stand_for_tuples():
    plate = heated()[1]
    assert lm.Film("air", plate, 2.0, 300.0, sides="top").sides == ("top",)
    assert lm.SolarFlux("sun", plate, (0, 0, -1), "50 percent").absorptivity == (0.5, 0.5)


@pytest.mark.parametrize(("missing", "said"), [("k", "the thermal conductivity"), ("c", "the specific heat")])
def test_material_without_thermal_data(missing, said):
    system, _ = heated(**{missing: None})
    with pytest.raises(DeclarationError, match=rf"TemperatureField 'heat': Isotropic of ply 0 .*{said}.*not given; accepted"):
        system.compile()


@pytest.mark.parametrize(
    "make",
    [
        lambda plate: lm.SolarFlux("item", plate, (0, 0, -1), 0.5),
        lambda plate: lm.HeatFlux("item", plate, "top", 1.0),
        lambda plate: lm.HeatSource("item", plate, 1.0),
        lambda plate: lm.Film("item", plate, 1.0, 300.0),
        lambda plate: lm.Radiation("item", plate, 0.8),
        lambda plate: lm.PrescribedTemperature("item", plate, 300.0),
        lambda plate: lm.PrescribedTemperature("item", plate.edge("x-"), 300.0),
    ],
)
def test_heat_on_a_plate_without_a_field(make):
    system, plate = heated(field=False)
    system.add(make(plate))
    with pytest.raises(DeclarationError, match=r"'item': plate 'panel' has no temperature field; add TemperatureField"):
        system.compile()


def test_two_fields_on_one_plate():
    system, plate = heated()
    system.add(lm.TemperatureField("other", plate))
    with pytest.raises(DeclarationError, match="TemperatureField 'other': plate 'panel' has the field 'heat'; accepted is one"):
        system.compile()


@pytest.mark.parametrize("strain", ["exact", "rigid"])
def test_steady_state_without_a_way_out_for_heat(strain):
    system, plate = heated(strain=strain)
    system.add(lm.HeatSource("heater", plate, 10.0))
    with pytest.raises(
        ModelError, match=r"nothing determines the temperatures of 'heat', heat has no way out; add a Film, Radiat"
    ):
        lm.equilibrium(system)


def test_steady_state_with_a_narrow_way_out_for_heat():
    system, plate = heated(strain="rigid")
    system.add(lm.HeatSource("heater", plate, 1e-4))
    system.add(lm.Film("air", plate, 1e-7, 290.0))
    assert float(lm.equilibrium(system)["heat.mean"]) == pytest.approx(290.0 + 1.0, rel=1e-6)  # 1e-10 of the conductance


def test_a_plate_that_radiates_at_absolute_zero():
    system, plate = heated(field=False)
    system.add(lm.TemperatureField("heat", plate))  # the reference is 0 K when it is left out
    system.add(lm.HeatSource("heater", plate, 10.0))
    system.add(lm.Radiation("space", plate, 0.8))
    with pytest.raises(ConvergenceError, match=r"temperature T_N at node .* of plate 'panel': heat has no way out here; .* 0 K"):
        lm.equilibrium(system)


def test_heat_in_a_rigid_plate_that_is_held_is_no_locked_system():
    system, plate = heated(strain="rigid")
    system.add(lm.HeatSource("heater", plate, 2700.0 * 900.0))  # 1 K/s
    result = lm.simulate(system, 2.0, lm.GeneralizedAlpha(dt=0.5))
    assert float(result["heat.mean"][-1]) == pytest.approx(292.0, abs=1e-9)  # a linear solution: rounding of 300 K


def test_corner_that_two_edges_hold_at_the_same_temperature():
    system, plate = heated()
    profile = lm.Ramp(t_end=1.0)
    for side in ("x-", "x+", "y-", "y+"):
        system.add(lm.PrescribedTemperature(side, plate.edge(side), 300.0, profile=profile))
    result = lm.equilibrium(system, t=1.0)
    assert float(result["heat.mean"]) == pytest.approx(300.0, rel=1e-12)
    assert any("meets" in note for note in result.start.notes)  # whose reaction counts the corner


def test_corner_that_two_edges_hold_at_different_temperatures():
    system, plate = heated()
    for side, level in (("x-", 300.0), ("y-", 310.0)):
        system.add(lm.PrescribedTemperature(side, plate.edge(side), level))
    with pytest.raises(ConstraintError, match=r"T_N of 'y-' at node 0 of 'panel' contradicts T_N of 'x-'"):
        system.compile() and lm.equilibrium(system)


def notes_of(system, plate):
    system.add(lm.Film("air", plate, 10.0, 300.0))
    return " ".join(lm.equilibrium(system).start.notes)


def test_a_full_clamp_of_a_heated_plate_is_told():
    assert "'root' clamps an edge of 'panel' with the kind 'full', so it cannot grow where 'heat'" in notes_of(*heated("full"))


def test_a_plate_fixed_to_the_ground_is_told_too():
    system, plate = heated()
    system.declarations = [item for item in system.declarations if item.name != "root"]
    ground = system.add(lm.Ground())
    system.add(lm.FixedJoint("mount", ground.origin, plate.edge("x-")))
    assert "'mount' clamps an edge of 'panel'" in notes_of(system, plate)


@pytest.mark.parametrize(("kind", "options"), [("restrained", {}), ("sliding", {}), ("full", {"alpha": 0.0})])
def test_nothing_is_told_of_clamps_that_heat_does_not_strain(kind, options):
    assert "clamps" not in notes_of(*heated(kind, **options))


def test_a_plate_that_begins_with_the_stress_of_its_temperature_is_told():
    """Where it begins from an equilibrium it has grown, and in statics nothing begins."""
    told, steps = "'heat' begins at 310 K, 'panel' is free of stress at 290 K", lm.GeneralizedAlpha(dt=1e-3)

    def begun(initial=None, **material):
        system, plate = heated(field=False, **material)
        system.add(lm.TemperatureField("heat", plate, reference=290.0, initial=initial))
        system.add(lm.Film("air", plate, 10.0, 310.0))
        return system

    def notes(result):
        return " ".join(result.start.notes)

    system = begun(310.0)
    still = lm.equilibrium(system)
    assert told in notes(lm.simulate(system, 2e-3, steps))
    assert told in notes(lm.Stepping(system, steps))
    silent = [still, lm.simulate(system, 2e-3, steps, initial=still.final)]
    silent += [lm.simulate(other, 2e-3, steps) for other in (begun(), begun(290.0), begun(310.0, alpha=0.0))]
    assert not any("begins" in notes(result) for result in silent)


@pytest.mark.parametrize(
    ("text", "kelvin"),
    [("20 degC", 293.15), ("20°C", 293.15), ("-20.5 celsius", 252.65), ("68 degF", 293.15), ("1e1 degC", 283.15)],
)
def test_temperatures_on_a_scale(text, kelvin):
    assert to_si(text, "K") == pytest.approx(kelvin, rel=1e-15, abs=1e-12)


@pytest.mark.parametrize(("text", "unit"), [("5 degC/m", "K/m"), ("900 J/(kg*degC)", "J/(kg*K)"), ("20 degC + 3 K", "K")])
def test_scales_are_no_units_of_differences(text, unit):
    with pytest.raises(UnitError, match="differences of temperature in K or delta_degC"):
        to_si(text, unit)
    assert to_si("5 delta_degC/m", "K/m") == 5.0


MODEL = """\
lamella: 1
materials:
  sheet: {E: 1.93 GPa, nu: 0.3, rho: 36.8 kg/m^3, alpha: 2.3e-5 1/K, k: 1.5 W/(m*K), c: 921 J/(kg*K)}
system:
  panel: {type: plate, size: [7.5 m, 0.5 m], mesh: [2, 1], laminate: {ply: sheet, thickness: 10.3 mm}}
  root: {type: clamp, on: panel.x-, kind: restrained}
  heat: {type: temperature_field, on: panel, reference: 20 degC, initial: 300 K, initial_gradient: 3 K/m}
  sun:
    type: solar_flux
    on: panel
    direction: [0, 0, -1]
    absorptivity: [0.79, 20 percent]
    constant: 1350 W/m^2
    turning: [0, 1 deg/s, 0]
    model: uncoupled
    profile: {kind: step, at: 2 s}
  moon: {type: solar_flux, on: panel, direction: [0, 0, 1], absorptivity: 0.3}
  lamp: {type: heat_flux, on: panel, side: bottom, flux: 0.1 mW/mm^2, profile: {kind: ramp, t_end: 1 s}}
  heater: {type: heat_source, on: panel, power: 0.1 kW/m^3}
  air: {type: film, on: panel, coefficient: 2 W/(m^2*K), ambient: 25 degC, sides: top}
  space: {type: radiation, on: panel, emissivity: 0.8, space: 3 K, sides: [top, bottom]}
  edge: {type: prescribed_temperature, on: panel.x+, temperature: 37 degC, gradient: 5 delta_degC/m}
  all: {type: prescribed_temperature, on: panel, temperature: 310.15 K}
analysis: {still: {type: statics}}
"""


def test_model_files_hold_every_item_of_heat():
    items = {item.name: item for item in loads(MODEL, name="model").system.declarations}
    plate = items["panel"]
    assert items["heat"] == lm.TemperatureField("heat", plate, 293.15, 300.0, 3.0)
    turning = (0.0, pytest.approx(0.017453292519943295), 0.0)
    assert (items["sun"].absorptivity, items["sun"].turning, items["sun"].model) == ((0.79, 0.2), turning, "uncoupled")
    assert items["moon"].absorptivity == (0.3, 0.3)
    assert items["lamp"].flux == pytest.approx(100.0)
    assert items["heater"].power == 100.0
    assert (items["air"].ambient, items["air"].sides) == (298.15, ("top",))
    assert items["space"] == lm.Radiation("space", plate, 0.8, 3.0)
    assert (items["edge"].temperature, items["edge"].gradient) == (pytest.approx(310.15), 5.0)
    assert items["edge"].on.side == "x+"
    assert items["all"].on is plate

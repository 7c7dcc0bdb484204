"""A unit of FMI 3, by pythonfmu3; imported where a unit is built or run, which both have that package."""

from __future__ import annotations

from typing import Any
from xml.etree.ElementTree import Element

from pythonfmu3 import DefaultExperiment, Float64, Fmi3Causality, Fmi3Slave, Fmi3Status, Fmi3StepResult, Fmi3Variability, Unit

from lamella.errors import LamellaError
from lamella.fmu.lasting import interface_of, lasting
from lamella.fmu.plant import Plant, Variable, as_state
from lamella.fmu.units import NONE, base_units, is_structured
from lamella.fmu.variables import Variables


@lasting
class Fmi3Unit(Fmi3Slave):
    """Shows a :class:`Plant` to FMI 3."""

    def __init__(self, **options: Any) -> None:
        super().__init__(**options)
        interface = interface_of(self)
        self.plant = Plant(str(self.resources), interface)
        self.modelName, self.description, self.vars = interface.name, interface.description, Variables(interface.name)
        self.default_experiment = DefaultExperiment(interface.t_start, interface.t_end, interface.step)
        self.time = interface.t_start
        units = sorted({item.unit for item in (*interface.inputs, *interface.outputs)} - {NONE} | {"s"})
        self.register_units([Unit(unit, **_numbers(base_units(unit))) for unit in units])
        kind = {"causality": Fmi3Causality.independent, "variability": Fmi3Variability.continuous}
        time = {"getter": lambda: self.time, "setter": lambda value: self.plant.set("time", value)}
        self.register_variable(Float64("time", unit="s", **kind, **time), nested=False)
        for item in interface.inputs:
            self._add(item, Fmi3Causality.input, lambda name=item.name: self.plant.input(name))
        for item in interface.outputs:
            self._add(item, Fmi3Causality.output, lambda name=item.name: self.plant.output(name))

    def _add(self, item: Variable, causality: Fmi3Causality, getter: Any) -> None:
        variable = Float64(
            item.name,
            causality=causality,
            variability=Fmi3Variability.continuous,
            description=item.description,
            unit=None if item.unit == NONE else item.unit,
            getter=getter,
            setter=lambda value: self.plant.set(item.name, value),
        )
        self.register_variable(variable, nested=False)

    def to_xml(self, model_options: Any = None) -> Element:
        """The model description; names that are no Modelica names are plain texts."""
        root = super().to_xml(model_options or {})
        interface = self.plant.interface
        if not all(is_structured(item.name) for item in (*interface.inputs, *interface.outputs)):
            root.set("variableNamingConvention", "flat")
        return root

    def setup_experiment(self, start_time: float) -> None:
        self.time = start_time

    def enter_initialization_mode(self) -> None:
        self.plant.begin(self.time)

    def do_step(self, current_time: float, step_size: float) -> Fmi3StepResult:
        try:
            reached = self.plant.advance(current_time, step_size)
        except LamellaError as error:
            self.log(str(error), Fmi3Status.error)
            self.time = self.plant.t if self.plant.moves else self.time  # where a motion that fails stands
            return Fmi3StepResult(status=Fmi3Status.error)
        self.time = self.plant.t
        return Fmi3StepResult(status=Fmi3Status.ok, terminateSimulation=not reached)

    def _get_fmu_state(self) -> dict[str, Any]:
        return {"time": self.time, **self.plant.save()}

    def _set_fmu_state(self, state: Any) -> None:
        self.plant.restore(state)
        self.time = self.plant.t if self.plant.moves else state.get("time", self.time)

    @staticmethod
    def _fmu_state_from_bytes(state: bytes) -> Any:
        return as_state(state)


def _numbers(exponents: dict[str, str]) -> dict[str, Any]:
    return {key: float(value) if key == "factor" else int(value) for key, value in exponents.items()}

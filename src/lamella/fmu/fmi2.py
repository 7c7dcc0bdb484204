"""A unit of FMI 2, by pythonfmu; imported where a unit is built or run, which both have that package."""

from __future__ import annotations

from typing import Any
from xml.etree.ElementTree import Element, SubElement

from pythonfmu import DefaultExperiment, Fmi2Causality, Fmi2Slave, Real
from pythonfmu.enums import Fmi2Status, Fmi2Variability

from lamella.errors import LamellaError
from lamella.fmu.lasting import interface_of, lasting
from lamella.fmu.plant import Plant, Variable, as_state
from lamella.fmu.units import NONE, base_units, is_structured
from lamella.fmu.variables import Variables


@lasting
class Fmi2Unit(Fmi2Slave):
    """Shows a :class:`Plant` to FMI 2."""

    def __init__(self, **options: Any) -> None:
        super().__init__(**options)
        interface = interface_of(self)
        self.plant = Plant(str(self.resources), interface)
        self.modelName, self.description, self.vars = interface.name, interface.description, Variables(interface.name)
        self._t_start = interface.t_start
        self.default_experiment = DefaultExperiment(interface.t_start, interface.t_end, interface.step)
        for item in interface.inputs:
            self._add(item, Fmi2Causality.input, lambda name=item.name: self.plant.input(name))
        for item in interface.outputs:
            self._add(item, Fmi2Causality.output, lambda name=item.name: self.plant.output(name))

    def _add(self, item: Variable, causality: Fmi2Causality, getter: Any) -> None:
        variable = Real(
            item.name,
            causality=causality,
            variability=Fmi2Variability.continuous,
            description=item.description,
            getter=getter,
            setter=lambda value: self.plant.set(item.name, value),
        )
        self.register_variable(variable, nested=False)

    def to_xml(self, model_options: Any = None) -> Element:
        """The model description, with what pythonfmu leaves out: units, and which outputs are unknown at the start."""
        root = super().to_xml(model_options or {})
        interface = self.plant.interface
        variables = {item.name: item for item in (*interface.inputs, *interface.outputs)}
        if not all(map(is_structured, variables)):
            root.set("variableNamingConvention", "flat")
        definitions = Element("UnitDefinitions")
        for unit in sorted({item.unit for item in variables.values()} - {NONE}):
            SubElement(SubElement(definitions, "Unit", name=unit), "BaseUnit", base_units(unit))
        if len(definitions):
            root.insert(1, definitions)
        for entry in root.iter("ScalarVariable"):
            unit = variables[entry.attrib["name"]].unit
            if unit != NONE:
                entry[0].set("unit", unit)
        structure = root.find("ModelStructure")
        assert structure is not None
        outputs = list(structure.iterfind("Outputs/Unknown"))
        if outputs:
            unknowns = SubElement(structure, "InitialUnknowns")
            for output in outputs:
                SubElement(unknowns, "Unknown", index=output.attrib["index"])
        return root

    def setup_experiment(self, start_time: float, stop_time: float | None, tolerance: float | None) -> None:
        self._t_start = start_time

    def enter_initialization_mode(self) -> None:
        self.plant.begin(self._t_start)

    def do_step(self, current_time: float, step_size: float) -> bool:
        try:
            return self.plant.advance(current_time, step_size)
        except LamellaError as error:
            self.log(str(error), Fmi2Status.error)
            return False

    def _get_fmu_state(self) -> dict[str, Any]:
        return self.plant.save()

    def _set_fmu_state(self, state: Any) -> None:
        self.plant.restore(state)

    @staticmethod
    def _fmu_state_from_bytes(state: bytes) -> Any:
        return as_state(state)

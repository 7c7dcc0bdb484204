"""lamella: flexible multibody dynamics of thin plates and shells.

The public names below are imported when they are first used, so that the command line answers at once.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

__version__ = "0.1.0"

if TYPE_CHECKING:
    from lamella.body.ground import Ground as Ground
    from lamella.body.plate import Edge as Edge
    from lamella.body.plate import Plate as Plate
    from lamella.body.rigid import RigidBody as RigidBody
    from lamella.body.shape import Box as Box
    from lamella.body.shape import Cylinder as Cylinder
    from lamella.body.shape import Sphere as Sphere
    from lamella.body.shell import Shell as Shell
    from lamella.contact.friction import BristleFriction as BristleFriction
    from lamella.contact.friction import RegularisedFriction as RegularisedFriction
    from lamella.contact.obstacles import CylinderContact as CylinderContact
    from lamella.contact.obstacles import PlaneContact as PlaneContact
    from lamella.contact.obstacles import SphereContact as SphereContact
    from lamella.critical import CriticalPoint as CriticalPoint
    from lamella.differentiation.gradient import Gradient as Gradient
    from lamella.differentiation.gradient import gradient as gradient
    from lamella.fmu.export import export_fmu as export_fmu
    from lamella.integrate.bdf import BDF as BDF
    from lamella.integrate.generalized_alpha import GeneralizedAlpha as GeneralizedAlpha
    from lamella.io.analysis import Motion as Motion
    from lamella.io.results import read_result as read_result
    from lamella.io.static_analysis import NaturalModes as NaturalModes
    from lamella.io.static_analysis import Statics as Statics
    from lamella.joint.clamp import Clamp as Clamp
    from lamella.joint.coupling import AngleCoupling as AngleCoupling
    from lamella.joint.coupling import PositionCoupling as PositionCoupling
    from lamella.joint.cylindrical import CylindricalJoint as CylindricalJoint
    from lamella.joint.distance import Cable as Cable
    from lamella.joint.distance import DistanceJoint as DistanceJoint
    from lamella.joint.drive import AngleDrive as AngleDrive
    from lamella.joint.drive import SlideDrive as SlideDrive
    from lamella.joint.edge_average import EdgeAverage as EdgeAverage
    from lamella.joint.fixed import FixedJoint as FixedJoint
    from lamella.joint.hinge import EdgeHinge as EdgeHinge
    from lamella.joint.linear_constraint import Component as Component
    from lamella.joint.linear_constraint import LinearConstraint as LinearConstraint
    from lamella.joint.planar_edge import Diaphragm as Diaphragm
    from lamella.joint.planar_edge import Symmetry as Symmetry
    from lamella.joint.point_on_line import PointInPlaneJoint as PointInPlaneJoint
    from lamella.joint.point_on_line import PointOnLineJoint as PointOnLineJoint
    from lamella.joint.prismatic import PrismaticJoint as PrismaticJoint
    from lamella.joint.revolute import RevoluteJoint as RevoluteJoint
    from lamella.joint.spherical import SphericalJoint as SphericalJoint
    from lamella.joint.support import EdgeSupport as EdgeSupport
    from lamella.joint.support import PointSupport as PointSupport
    from lamella.joint.support import PrescribedMotion as PrescribedMotion
    from lamella.joint.universal import UniversalJoint as UniversalJoint
    from lamella.linear.model import LinearModel as LinearModel
    from lamella.linear.model import linearise as linearise
    from lamella.linear.state_space import StateSpace as StateSpace
    from lamella.load.control_law import PID as PID
    from lamella.load.control_law import FunctionLaw as FunctionLaw
    from lamella.load.control_law import StateSpaceLaw as StateSpaceLaw
    from lamella.load.controller import Controller as Controller
    from lamella.load.event import Event as Event
    from lamella.load.force import EdgeForce as EdgeForce
    from lamella.load.force import PointForce as PointForce
    from lamella.load.force import SurfaceForce as SurfaceForce
    from lamella.load.gravity import Gravity as Gravity
    from lamella.load.moment import EdgeMoment as EdgeMoment
    from lamella.load.moment import PointMoment as PointMoment
    from lamella.load.pressure import Pressure as Pressure
    from lamella.load.spin import SteadySpin as SteadySpin
    from lamella.load.spring import SlideSpring as SlideSpring
    from lamella.load.spring import SpringDamper as SpringDamper
    from lamella.load.spring import TorsionSpring as TorsionSpring
    from lamella.load.stop import EndStop as EndStop
    from lamella.load.stop import Latch as Latch
    from lamella.load.user import UserForce as UserForce
    from lamella.material.isotropic import Isotropic as Isotropic
    from lamella.material.lamina import Lamina as Lamina
    from lamella.material.laminate import Laminate as Laminate
    from lamella.material.laminate import Ply as Ply
    from lamella.math.profile import Constant as Constant
    from lamella.math.profile import Cycloid as Cycloid
    from lamella.math.profile import Harmonic as Harmonic
    from lamella.math.profile import Integral as Integral
    from lamella.math.profile import Polynomial as Polynomial
    from lamella.math.profile import Ramp as Ramp
    from lamella.math.profile import SmoothStep as SmoothStep
    from lamella.math.profile import Step as Step
    from lamella.math.profile import Table as Table
    from lamella.math.profile import TrapezoidalSpeed as TrapezoidalSpeed
    from lamella.modal import Modes as Modes
    from lamella.modal import modes as modes
    from lamella.motion import simulate as simulate
    from lamella.optimisation.problem import Limits as Limits
    from lamella.optimisation.problem import Objective as Objective
    from lamella.optimisation.problem import Optimisation as Optimisation
    from lamella.optimisation.run import run_optimisation as run_optimisation
    from lamella.result import Outcome as Outcome
    from lamella.result import Result as Result
    from lamella.sensor.edge import EdgeCrossing as EdgeCrossing
    from lamella.sensor.edge import EdgeTension as EdgeTension
    from lamella.sensor.mean import MeanPosition as MeanPosition
    from lamella.solve.arc_length import ArcLength as ArcLength
    from lamella.solve.displacement_control import DisplacementControl as DisplacementControl
    from lamella.solve.newton import Newton as Newton
    from lamella.stability import Buckling as Buckling
    from lamella.stability import buckling as buckling
    from lamella.statics import equilibrium as equilibrium
    from lamella.statics import equilibrium_path as equilibrium_path
    from lamella.stepping.run import Stepping as Stepping
    from lamella.surface.function import FunctionSurface as FunctionSurface
    from lamella.surface.points import PointSurface as PointSurface
    from lamella.surface.pulleys import PulleySurface as PulleySurface
    from lamella.surface.revolution import AnnulusSurface as AnnulusSurface
    from lamella.surface.revolution import BeltSurface as BeltSurface
    from lamella.surface.revolution import ConeSurface as ConeSurface
    from lamella.surface.revolution import CylinderSurface as CylinderSurface
    from lamella.surface.revolution import SphereSurface as SphereSurface
    from lamella.sweep.designs import GridDesign as GridDesign
    from lamella.sweep.designs import LatinHypercubeDesign as LatinHypercubeDesign
    from lamella.sweep.designs import ListDesign as ListDesign
    from lamella.sweep.designs import SaltelliDesign as SaltelliDesign
    from lamella.sweep.designs import SobolDesign as SobolDesign
    from lamella.sweep.outputs import MassOutput as MassOutput
    from lamella.sweep.outputs import ShapeOutput as ShapeOutput
    from lamella.sweep.outputs import SignalOutput as SignalOutput
    from lamella.sweep.parameter import Parameter as Parameter
    from lamella.sweep.run import run_parameter_study as run_parameter_study
    from lamella.sweep.study import ParameterStudy as ParameterStudy
    from lamella.system import System as System
    from lamella.thermal.field import TemperatureField as TemperatureField
    from lamella.thermal.prescribed import PrescribedTemperature as PrescribedTemperature
    from lamella.thermal.solar import SolarFlux as SolarFlux
    from lamella.thermal.surface import Film as Film
    from lamella.thermal.surface import HeatFlux as HeatFlux
    from lamella.thermal.surface import HeatSource as HeatSource
    from lamella.thermal.surface import Radiation as Radiation

_HOME = {
    "body.ground": ("Ground",),
    "body.plate": ("Edge", "Plate"),
    "stability": ("Buckling", "buckling"),
    "contact.friction": ("BristleFriction", "RegularisedFriction"),
    "contact.obstacles": ("CylinderContact", "PlaneContact", "SphereContact"),
    "critical": ("CriticalPoint",),
    "differentiation.gradient": ("Gradient", "gradient"),
    "fmu.export": ("export_fmu",),
    "integrate.bdf": ("BDF",),
    "integrate.generalized_alpha": ("GeneralizedAlpha",),
    "io.analysis": ("Motion",),
    "io.results": ("read_result",),
    "io.static_analysis": ("NaturalModes", "Statics"),
    "body.rigid": ("RigidBody",),
    "body.shape": (
        "Box",
        "Cylinder",
        "Sphere",
    ),
    "body.shell": ("Shell",),
    "joint.cylindrical": ("CylindricalJoint",),
    "joint.edge_average": ("EdgeAverage",),
    "joint.fixed": ("FixedJoint",),
    "joint.hinge": ("EdgeHinge",),
    "joint.linear_constraint": ("Component", "LinearConstraint"),
    "joint.planar_edge": ("Diaphragm", "Symmetry"),
    "joint.point_on_line": (
        "PointInPlaneJoint",
        "PointOnLineJoint",
    ),
    "joint.prismatic": ("PrismaticJoint",),
    "joint.revolute": ("RevoluteJoint",),
    "joint.spherical": ("SphericalJoint",),
    "joint.universal": ("UniversalJoint",),
    "joint.clamp": ("Clamp",),
    "joint.coupling": ("AngleCoupling", "PositionCoupling"),
    "joint.distance": ("Cable", "DistanceJoint"),
    "joint.drive": ("AngleDrive", "SlideDrive"),
    "joint.support": ("EdgeSupport", "PointSupport", "PrescribedMotion"),
    "linear.model": ("LinearModel", "linearise"),
    "linear.state_space": ("StateSpace",),
    "load.control_law": ("PID", "FunctionLaw", "StateSpaceLaw"),
    "load.controller": ("Controller",),
    "load.event": ("Event",),
    "load.force": ("EdgeForce", "PointForce", "SurfaceForce"),
    "load.gravity": ("Gravity",),
    "load.moment": ("EdgeMoment", "PointMoment"),
    "load.pressure": ("Pressure",),
    "load.spin": ("SteadySpin",),
    "load.spring": ("SlideSpring", "SpringDamper", "TorsionSpring"),
    "load.stop": ("EndStop", "Latch"),
    "load.user": ("UserForce",),
    "thermal.field": ("TemperatureField",),
    "thermal.prescribed": ("PrescribedTemperature",),
    "thermal.solar": ("SolarFlux",),
    "thermal.surface": ("Film", "HeatFlux", "HeatSource", "Radiation"),
    "material.isotropic": ("Isotropic",),
    "material.lamina": ("Lamina",),
    "material.laminate": ("Laminate", "Ply"),
    "math.profile": (
        "Constant",
        "Cycloid",
        "Harmonic",
        "Integral",
        "Polynomial",
        "Ramp",
        "SmoothStep",
        "Step",
        "Table",
        "TrapezoidalSpeed",
    ),
    "modal": ("Modes", "modes"),
    "optimisation.problem": ("Limits", "Objective", "Optimisation"),
    "optimisation.run": ("run_optimisation",),
    "result": ("Outcome", "Result"),
    "motion": ("simulate",),
    "sensor.edge": ("EdgeCrossing", "EdgeTension"),
    "sensor.mean": ("MeanPosition",),
    "solve.arc_length": ("ArcLength",),
    "solve.displacement_control": ("DisplacementControl",),
    "solve.newton": ("Newton",),
    "statics": ("equilibrium", "equilibrium_path"),
    "stepping.run": ("Stepping",),
    "surface.function": ("FunctionSurface",),
    "surface.points": ("PointSurface",),
    "surface.pulleys": ("PulleySurface",),
    "surface.revolution": ("AnnulusSurface", "BeltSurface", "ConeSurface", "CylinderSurface", "SphereSurface"),
    "sweep.designs": ("GridDesign", "LatinHypercubeDesign", "ListDesign", "SaltelliDesign", "SobolDesign"),
    "sweep.outputs": ("MassOutput", "ShapeOutput", "SignalOutput"),
    "sweep.parameter": ("Parameter",),
    "sweep.run": ("run_parameter_study",),
    "sweep.study": ("ParameterStudy",),
    "system": ("System",),
}
_MODULE_OF = {name: module for module, names in _HOME.items() for name in names}

__all__ = ["__version__", *_MODULE_OF]  # pyright: ignore[reportUnsupportedDunderAll]


def __getattr__(name: str) -> object:
    if name not in _MODULE_OF:
        raise AttributeError(f"module 'lamella' has no attribute '{name}'")
    value = getattr(import_module(f"lamella.{_MODULE_OF[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted(__all__)

"""Reference surfaces of curved shells, as maps from two parameters to space."""

from lamella.surface import function, points, pulleys, revolution  # so that every surface is known by its base class
from lamella.surface.base import Surface

__all__ = ["Surface", "function", "points", "pulleys", "revolution"]

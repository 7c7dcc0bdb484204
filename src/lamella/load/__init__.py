"""Loads: gravity, forces, pressure and moments, each times a function of time."""

"""Sensors: what is recorded and measured of a body besides its markers; they act on nothing."""

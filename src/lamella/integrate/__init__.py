"""Integrators: from one point in time to the next."""

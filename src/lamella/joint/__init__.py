"""Supports and joints: what holds points and edges of bodies."""

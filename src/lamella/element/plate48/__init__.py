"""Plate48: the bicubic Hermite (Bogner-Fox-Schmit) absolute nodal coordinate shell element with 48 coordinates."""

"""Plate36: the absolute nodal coordinate shell element without twist, of Dufva and Shabana, with 36 coordinates."""

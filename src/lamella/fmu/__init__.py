"""Functional mock-up units (FMI): a model file as a part of a co-simulation in other programs."""

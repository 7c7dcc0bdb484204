"""Optimisation: the best design of a model by the gradients of its outputs."""

"""Motions that are advanced from outside, step by step, with inputs that are held in between."""

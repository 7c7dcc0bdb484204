"""Scalars of a configuration, lengths and angles, with gradients and Hessians: what springs, stops, drives and cables see."""

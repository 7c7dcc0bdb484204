"""Linear models for control: the equations about a steady state, from named inputs to named outputs."""

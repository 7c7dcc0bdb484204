"""Reference surfaces of curved shells, as maps from two parameters to space."""

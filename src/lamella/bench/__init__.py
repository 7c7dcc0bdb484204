"""Benchmarks: the same cases in lamella and in the peers that are installed (``lamella bench``, docs/performance.md)."""

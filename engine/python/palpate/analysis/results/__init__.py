"""Figures of the committed results (benchmarks/results), each a function of a table."""

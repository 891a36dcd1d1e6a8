"""What the means of a sweep (`sweep.csv`) say of rankings of conditions."""

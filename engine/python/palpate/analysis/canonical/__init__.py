"""The page of a canonical run (`canonical.csv`): a wall at an angle to the only motor."""

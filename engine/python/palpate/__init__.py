"""Palpate in Python. Nothing heavy is imported until it is used."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import os

    import pandas as pd

__all__ = ["read_trials"]


def read_trials(path: str | os.PathLike[str]) -> pd.DataFrame:
    """Read the trials of an experiment: see `palpate.analysis.trials.read_trials`."""
    from palpate.analysis import trials

    return trials.read_trials(path)

"""Palpate in Python. Nothing heavy is imported until it is used."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import os

    import pandas as pd

__all__ = ["read_trials"]


def __dir__() -> list[str]:
    """Without what only types need."""
    return __all__


def read_trials(path: str | os.PathLike[str]) -> pd.DataFrame:
    """Read the trials of an experiment: see `palpate.analysis.trials.read_trials`."""
    try:
        from palpate.analysis import trials
    except ModuleNotFoundError as error:
        if not error.name or error.name.partition(".")[0] == "palpate":
            raise
        raise ModuleNotFoundError(
            f"palpate.read_trials needs the Python module {error.name}; "
            f"install python3-{error.name.partition('.')[0]} (on Debian: apt install)",
            name=error.name,
        ) from error

    return trials.read_trials(path)

"""The experiments of a file: the trials of one kind of operator in one variant of the plan."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from palpate.analysis.errors import InputError, printable
from palpate.analysis.numbers import as_printed
from palpate.analysis.statistics import wilson
from palpate.analysis.statistics.types import Array

from .outcomes import OUTCOMES, TIME_TO_LIMIT, Outcome, with_outcomes

# The factors of the paper. Trial is the block, from 1.
FACTORS = ("Haptic", "Rotation", "Object", "Trial")
CONDITION = ["Haptic", "Rotation", "Object"]
HAPTIC = ("NoH", "UaH", "H")
# The force acts on a simulated hand that the person leads.
SEEN = ("seen-UaH", "seen-H")
SEEN_CLAIM = "a seen force is a claim about seeing, never pooled with a felt one"
ROTATION = ("NoR", "R")
# The statuses of trials, and how counts name them.
STATUS = {"done": "done", "timeout": "timeouts", "fault": "faults", "aborted": "aborted",
          "skipped": "skipped"}
ENDED = ["done", "timeouts", "faults"]  # those that were neither cut nor left out
FOLLOWINGS = ("delayed", "predict", "replan", "frozen", "adapts-0", "adapts-0.5", "adapts-1", "")
VARIANT = ["view", "align", "start_orientation_deg", "scale"]

# The largest number of combinations of Haptic, Rotation, Object and Trial: the time of the paper's
# analysis grows with the third power of this number.
MOST_CELLS = 600
# The most experiments in one file: each has its own figures and tables.
MOST_EXPERIMENTS = 100
DIVIDING_COLUMNS = (
    "each combination of view, align, start_orientation_deg and scale is an experiment of its own: "
    "rename a column that has another meaning"
)


class Variant(NamedTuple):
    """The settings that make several experiments of one plan; the defaults are what the paper
    did."""

    view: str = "turning"
    align: str = "nearest"
    start_orientation_deg: float = 0.0
    scale: float = 1.0

    def order(self) -> tuple[Any, ...]:
        """What the paper did comes first."""
        differs = [mine != papers for mine, papers in zip(self, Variant())]
        start, scale = self.start_orientation_deg, self.scale
        return (differs[0], differs[1], differs[2], start, differs[3], scale)

    def name(self, plain: Variant | None = None) -> str:
        """ "view still, start 45 deg, scale 0.5": where it differs from `plain`, by default what
        the paper did; empty if it does not."""
        texts = (
            f"view {self.view}",
            f"align {self.align}",
            f"start {as_printed(self.start_orientation_deg)} deg",
            f"scale {as_printed(self.scale)}",
        )
        others = zip(self, plain or Variant(), texts)
        return ", ".join(text for mine, other, text in others if mine != other)


def natural(name: str) -> tuple[Any, ...]:
    """Orders names by the numbers in them: "P2" before "P10"."""
    parts: list[tuple[int, int, str]] = []
    for part in re.findall(r"[0-9]+|[^0-9]", name):
        digits = part.lstrip("0") or "0"
        is_number = part[0].isascii() and part[0].isdigit()
        parts.append((ord("0"), len(digits), digits) if is_number else (ord(part), 0, ""))
    return tuple(parts), name


@dataclass(frozen=True)
class Experiment:
    """trials: one row for each trial (practice is left out), sorted, with the columns `participant`
    and FACTORS (categories: the levels that occur, in their order), `status`, `reason` and the key
    of each outcome. Of several attempts at a trial it is the last completed one, or the last one if
    none was completed. repeated: how many other attempts there were, by reason, or by status if
    they have none. following: empty for people."""

    following: str
    variant: Variant
    trials: pd.DataFrame
    repeated: dict[str, int]
    limit_s: float

    @property
    def is_simulated(self) -> bool:
        return self.following != ""

    @property
    def who(self) -> str:
        """ "delayed"; "people"."""
        return self.following or "people"

    @property
    def name(self) -> str:
        """ "delayed, start 45 deg"; "people". A following names its view."""
        plain = Variant(view=self.variant.view) if self.is_simulated else Variant()
        return ", ".join(filter(None, [self.who, self.variant.name(plain)]))

    @property
    def whose(self) -> str:
        """Before the element of an error: "following delayed, view still, "."""
        return whose(self.following, self.variant)

    @cached_property
    def levels(self) -> dict[str, list[str]]:
        return {factor: list(self.trials[factor].cat.categories) for factor in FACTORS}

    @cached_property
    def participants(self) -> list[str]:
        return list(self.trials["participant"].cat.categories)

    @property
    def is_seen(self) -> bool:
        """The people saw the force, and did not feel it."""
        return not set(SEEN).isdisjoint(self.levels["Haptic"])

    def has(self, outcome: Outcome) -> bool:
        return bool(self.trials[outcome.key].notna().any())

    @property
    def has_timeouts(self) -> bool:
        return bool((self.trials["status"] == "timeout").any())

    def reported_outcomes(self) -> list[Outcome]:
        """Those that the trials have; the time with timeouts as the limit only with timeouts."""
        candidates = [o for o in OUTCOMES if o is not TIME_TO_LIMIT or self.has_timeouts]
        return [outcome for outcome in candidates if self.has(outcome)]

    def grid(self, outcome: Outcome) -> Array:
        """The outcome by participant, Haptic, Rotation, Object and Trial; NaN: missing."""
        axes = [self.trials[name].cat for name in ("participant", *FACTORS)]
        grid = np.full([len(axis.categories) for axis in axes], np.nan)
        grid[tuple(axis.codes.to_numpy() for axis in axes)] = self.trials[outcome.key].to_numpy()
        return grid

    @cached_property
    def counts(self) -> pd.DataFrame:
        """How the trials of each condition ended, indexed by CONDITION; the first row, ("all",
        "all", "all"), is of all conditions. absent: without a row for a participant, a condition
        and a block. share, low, high: timeouts among the trials that ended by themselves, with
        Wilson's 95 % interval. reasons: of aborted and skipped trials."""
        by_status = self.trials.groupby([*CONDITION, "status"], observed=False).size()
        counts = by_status.unstack("status")
        counts.columns = list(STATUS.values())
        planned = len(self.participants) * len(self.levels["Trial"])
        counts["absent"] = planned - counts.sum(axis=1)
        everything = counts.sum().to_frame(("all",) * 3).T
        index = pd.MultiIndex.from_tuples([("all",) * 3, *counts.index], names=CONDITION)
        counts = pd.concat([everything, counts]).set_axis(index)
        held = counts[ENDED].sum(axis=1)
        low, high = wilson(counts["timeouts"].to_numpy(), held.to_numpy())
        share = counts["timeouts"] / held.where(held > 0)
        reasons = [self._reasons(levels) for levels in counts.index]
        return counts.assign(share=share, low=low, high=high, reasons=reasons)

    def _reasons(self, levels: tuple[str, ...]) -> str:
        """ "aborted: focus 2, hidden 1; skipped: experimenter 1"."""
        cut = self.trials[self.trials["reason"] != ""]
        if levels[0] != "all":
            cut = cut[(cut[CONDITION].astype(str) == levels).all(axis=1)]
        by_status = {status: cut.loc[cut["status"] == status, "reason"] for status in STATUS}
        return "; ".join(
            f"{status}: {counts_text(Counter(reasons))}"
            for status, reasons in by_status.items()
            if len(reasons)
        )

    @property
    def total(self) -> dict[str, int]:
        """By the names of STATUS, and absent, of all conditions together."""
        counts = self.counts.iloc[0]
        return {name: int(counts[name]) for name in (*STATUS.values(), "absent")}

    def done(self, levels: dict[str, str]) -> int:
        """How many trials were completed at these levels of factors of the condition."""
        done = self.counts["done"].iloc[1:]
        for factor, level in levels.items():
            done = done[done.index.get_level_values(factor) == level]
        return int(done.sum())

    @property
    def missing(self) -> int:
        return sum(self.total.values()) - self.total["done"]

    def empty_condition(self) -> str | None:
        """The first condition without a completed trial: "UaH, R, O2"."""
        of_conditions = self.counts["done"].iloc[1:]
        empty = of_conditions.index[of_conditions == 0]
        return ", ".join(empty[0]) if len(empty) else None


def without_pilots(frame: pd.DataFrame) -> pd.DataFrame:
    """The trials that are not of a pilot run."""
    return frame[frame["pilot"] == 0]


def check_haptic(frame: pd.DataFrame) -> None:
    """Raises InputError for rows with levels of Haptic that are seen and with others that are felt:
    frame has the column haptic."""
    there = set(frame["haptic"])
    seen = [level for level in SEEN if level in there]
    felt = [level for level in HAPTIC[1:] if level in there]
    if seen and felt:
        raise InputError("", "column haptic", f"has {seen[0]} and {felt[0]}; expected forces that "
                         f"are seen, or forces that are felt: {SEEN_CLAIM}",
                         "analyse the trials of each plan on their own")


def counts_text(counts: Mapping[str, int]) -> str:
    """ "focus 2, hidden 1"."""
    return ", ".join(f"{name} {n}" for name, n in _largest_first(counts).items())


def _largest_first(counts: Mapping[str, int]) -> dict[str, int]:
    return dict(sorted(counts.items(), key=lambda count: (-count[1], count[0])))


def whose(following: str, variant: Variant) -> str:
    parts = [f"following {following}" if following else "", variant.name()]
    return "".join(f"{part}, " for part in parts if part)


def experiments_of(frame: pd.DataFrame, limit_s: float) -> list[Experiment]:
    """frame: the rows of trials.csv (read_trials). People come first, then simulated persons: the
    paper's variant first, and in each variant the followings in their order.

    Raises InputError for a file without trials, with too many experiments, with fewer than two
    participants, and with a condition without any row.
    """
    groups = {
        (Variant(*key[1:]), key[0]): rows
        for key, rows in frame.groupby(["following", *VARIANT], observed=True, sort=False)
    }
    if len(groups) > MOST_EXPERIMENTS:
        raise InputError(
            "",
            "view, align, start_orientation_deg, scale and following",
            f"divide the file into {len(groups)} experiments; expected at most {MOST_EXPERIMENTS}",
            DIVIDING_COLUMNS,
        )
    if not groups:
        raise InputError("", "rows", "are 0; expected trials of two participants or more")
    order = sorted(
        groups, key=lambda key: (key[1] != "", key[0].order(), FOLLOWINGS.index(key[1]))
    )
    try:
        return [_experiment(*key, groups[key], limit_s) for key in order]
    except InputError as error:
        if len({variant for variant, _ in groups}) > 1:
            error.hint = "; ".join(filter(None, [error.hint, DIVIDING_COLUMNS]))
        raise


def _in_order(names: pd.Series[Any], known: Sequence[str] | None = None) -> pd.Categorical:
    """The names with the levels that occur as categories, in their order."""
    texts = names.astype(str)
    found = set(texts)
    levels = [k for k in known if k in found] if known else sorted(found, key=natural)
    return pd.Categorical(texts, categories=levels, ordered=True)


def _attempts(rows: pd.DataFrame) -> tuple[pd.DataFrame, pd.DataFrame]:
    """The attempts that count, one for each trial, and the other ones."""
    rows = rows.assign(is_done=rows["status"] == "done").sort_values(
        ["is_done", "attempt"], kind="stable"
    )
    keys = ["participant", "block", "haptic", "rotation", "object"]
    is_counted = ~rows.duplicated(keys, keep="last")
    return rows[is_counted], rows[~is_counted]


def _experiment(
    variant: Variant, following: str, frame: pd.DataFrame, limit_s: float
) -> Experiment:
    counted, others = _attempts(frame[frame["block"] > 0])
    repeated = others["reason"].where(others["reason"] != "", others["status"])
    columns = {
        "participant": _in_order(counted["participant"]),
        "Haptic": _in_order(counted["haptic"], (*HAPTIC, *SEEN)),
        "Rotation": _in_order(counted["rotation"], ROTATION),
        "Object": _in_order(counted["object"]),
        "Trial": _in_order(counted["block"]),
        "status": pd.Categorical(counted["status"], categories=list(STATUS)),
        "reason": counted["reason"].to_numpy(),
    }
    trials = with_outcomes(counted.reset_index(drop=True), limit_s).assign(**columns)
    trials = trials.sort_values(["participant", *FACTORS]).reset_index(drop=True)
    trials = trials[[*columns, *(outcome.key for outcome in OUTCOMES)]]
    counts = _largest_first(Counter(repeated))
    experiment = Experiment(following, variant, trials, counts, limit_s)
    _check(experiment)
    return experiment


def _check(experiment: Experiment) -> None:
    sizes = {factor: len(levels) for factor, levels in experiment.levels.items()}
    cells = int(np.prod(list(sizes.values())))
    if cells > MOST_CELLS:
        raise InputError(
            "",
            experiment.whose + "object and block",
            f"have {sizes['Object']} and {sizes['Trial']} levels, which gives {cells} cells; "
            f"expected at most {MOST_CELLS} combinations of haptic, rotation, object and block",
            "check the columns, or analyse fewer objects or blocks",
        )
    people = len(experiment.participants)
    if people < 2:
        raise InputError(
            "",
            experiment.whose + "participant",
            f"has {people} level{'' if people == 1 else 's'} beside practice; expected two "
            "participants or more",
            "the analysis is about differences between participants",
        )
    rows = experiment.trials.groupby(CONDITION, observed=False).size()
    absent = rows.index[rows == 0]
    if len(absent):
        raise InputError(
            "",
            f"{experiment.whose}condition {printable(', '.join(absent[0]))}",
            "has no trial; expected every combination of haptic, rotation and object",
            "add its trials, or remove the level that was not tested everywhere",
        )

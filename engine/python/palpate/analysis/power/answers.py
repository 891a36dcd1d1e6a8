"""The answers of a study: power, and numbers of people."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from palpate.analysis.statistics import wilson

from . import paper
from .contrasts import together
from .question import Study
from .simulation import Bools, Counts, first_of_equal_noise

# The powers for which the smallest number of people is found.
POWERS = (0.8, 0.9)
Numbers = NDArray[np.int64]


def first_from(is_enough: Bools) -> Numbers:
    """The first n from which on it is enough. is_enough: (..., n = 2, 3, ...). Where it is not
    enough at the largest n: the largest n + 1."""
    stays = np.logical_and.accumulate(is_enough[..., ::-1], axis=-1)
    return np.asarray(is_enough.shape[-1] + 2 - stays.sum(axis=-1))


@dataclass(frozen=True)
class Answer:
    """The smallest number of people with which each of the tests has the power."""

    power: float
    tests: list[int]  # the effects that the assumed means have, corrected; empty: none
    model: int  # the assumption
    people: int  # the largest simulated number + 1: more; 0 without a test
    least: int  # over all assumptions
    most: int


class Answers:
    """counts: (models, tests, people from 2 on), of simulate()."""

    def __init__(self, study: Study, counts: Counts) -> None:
        self.study, self.counts = study, counts
        self.most = study.request.participants
        self.sets = study.request.sets
        self.is_null = np.array(study.is_null)
        # With fewer than 2^53 data sets, no power is rounded to the other side of 0.8.
        self.share = counts / self.sets
        self.low, self.high = wilson(counts, self.sets)

    @cached_property
    def people(self) -> dict[float, Numbers]:
        """The smallest number from which on the power is never below, by power: (models, tests);
        `most` + 1: more than were simulated."""
        return {power: first_from(self.share >= power) for power in POWERS}

    @cached_property
    def bounds(self) -> dict[float, tuple[Numbers, Numbers]]:
        """The numbers of people at which the bounds of the 95 % interval reach the power: first the
        upper bound."""
        return {p: (first_from(self.high >= p), first_from(self.low >= p)) for p in POWERS}

    @property
    def example(self) -> int:
        """The number of people whose power is stated: the paper's, or the largest simulated."""
        return min(paper.PARTICIPANTS, int(self.most))

    @cached_property
    def by_noise(self) -> list[int]:
        """The models by ascending noise."""
        order = self.study.assumptions["noise"].to_numpy().argsort(kind="stable")
        return [int(model) for model in order]

    @cached_property
    def has_one_noise(self) -> bool:
        """Whether all assumptions have the same noise, and therefore the same answers."""
        return not first_of_equal_noise(self.study.assumptions["noise"].to_numpy()).any()

    @cached_property
    def answer(self) -> Answer:
        """The answer in one number. Pairs are not in it: they are looked at after an effect."""
        power, contrasts = POWERS[0], self.study.contrasts
        effects = [group[-1] for group in together(contrasts) if not contrasts[group[0]].family]
        tests = [t for t in effects if not self.is_null[t]]
        people = self.people[power][:, tests].max(axis=1, initial=0)
        model = self.study.model_of_answer
        least, most = int(people.min()), int(people.max())
        return Answer(power, tests, model, int(people[model]), least, most)

    def number(self, n: int, test: int) -> int | None:
        """None: more than were simulated, or no number helps, because there is no effect."""
        return None if self.is_null[test] or n > self.most else int(n)

    def _cases(self) -> Iterator[tuple[int, tuple[Any, ...], int]]:
        """Each model and test, and the first cells of its rows in tables."""
        columns = ["error_from", "error_sd", "share_u", "share_w"]
        for model, cells in enumerate(self.study.assumptions[columns].itertuples(index=False)):
            first = (cells[0], *map(six_digits, cells[1:]))
            for t, test in enumerate(self.study.contrasts):
                yield model, (*first, test.name, test.correction), t

    def needed_people(self) -> pd.DataFrame:
        """One row per assumption and test. An empty number beside has_effect = 1: more than the
        largest number. Beside has_effect = 0: the assumed means make the test's hypothesis true, so
        that no number helps."""
        columns = ["error_from", "error_sd", "share_u", "share_w", "test", "correction",
                   "has_effect", *(f"people_for_{power}" for power in POWERS)]
        columns += [f"{side}_for_{power}" for power in POWERS for side in ("low", "high")]
        found = [self.people[power] for power in POWERS]
        found += [side for power in POWERS for side in self.bounds[power]]
        rows = [
            (*cells, int(not self.is_null[t]), *(self.number(each[model, t], t) for each in found))
            for model, cells, t in self._cases()
        ]
        return pd.DataFrame(rows, columns=columns, dtype=object)

    def curves(self) -> pd.DataFrame:
        """One row per assumption, test and number of people, with the power and its 95 % interval.
        The power is exact, other numbers have six digits at most."""
        columns = ["error_from", "error_sd", "share_u", "share_w", "test", "correction",
                   "participants", "data_sets", "significant", "power", "low", "high"]
        rows = [
            (*cells, n, self.sets, *point)
            for model, cells, t in self._cases()
            for n, *point in zip(
                range(2, self.most + 1),
                self.counts[model, t].tolist(),
                map(all_digits, self.share[model, t].tolist()),
                map(six_digits, self.low[model, t]),
                map(six_digits, self.high[model, t]),
            )
        ]
        return pd.DataFrame(rows, columns=columns)

    def as_json(self, notes: list[str]) -> dict[str, Any]:
        """The request, the model, the pilot, the notes, and for each assumption and test the counts
        of significant data sets from 2 people on."""
        assumptions = [
            {
                **row[["error_from", "error_sd", "share_u", "share_w"]].to_dict(),
                "variances": row[["u", "w", "e"]].to_dict(),
                "tests": [self._test_json(model, t) for t in range(len(self.study.contrasts))],
            }
            for model, (_, row) in enumerate(self.study.assumptions.iterrows())
        ]
        return {"answer": self._answer_json(), "settings": _settings(self.study), "pilot": _pilot(self.study), "notes": notes,
                "assumptions": assumptions}

    def _answer_json(self) -> dict[str, Any]:
        answer = self.answer
        assumed = self.study.assumptions.iloc[answer.model]
        within = [n if answer.tests and n <= self.most else None
                  for n in (answer.people, answer.least, answer.most)]
        return {
            "people": within[0],
            "power": answer.power,
            "tests": [self.study.contrasts[t].title for t in answer.tests],
            "assumption": assumed[["error_from", "error_sd", "share_u", "share_w"]].to_dict(),
            "over_all_assumptions": within[1:],
        }

    def _test_json(self, model: int, t: int) -> dict[str, Any]:
        test = self.study.contrasts[t]
        return {
            "test": test.name,
            "correction": test.correction,
            "has_effect": not self.is_null[t],
            "people": {str(p): self.number(n[model, t], t) for p, n in self.people.items()},
            "people_bounds": {
                str(p): [self.number(side[model, t], t) for side in sides]
                for p, sides in self.bounds.items()
            },
            "significant": self.counts[model, t].tolist(),
        }


def six_digits(value: float) -> str:
    return f"{value:.6g}"


def all_digits(value: float) -> str:
    """The fewest digits that identify the number."""
    return repr(value).removesuffix(".0")


def _settings(study: Study) -> dict[str, Any]:
    request = study.request
    settings = {
        "measure": request.measure,
        "unit": study.measure.outcome.unit,
        "effects_from": "--effect" if request.effect else "paper",
        "effects": dict(zip(study.measure.design.conditions, map(float, study.means))),
        "error_sd": request.error,
        "share_u": request.share_u,
        "share_w": request.share_w,
    }
    if study.paper_scatter:
        settings["paper_errors"] = [
            {"from": s.source, "sd": s.sd, "rounding_low": s.low, "rounding_high": s.high}
            for s in study.paper_scatter
        ]
    return settings | {
        "trials_of_condition": study.trials,
        "participants": request.participants,
        "data_sets": request.sets,
        "seed": request.seed,
        "significance": 0.05,
    }


def _pilot(study: Study) -> dict[str, Any] | None:
    pilot = study.pilot
    if pilot is None:
        return None
    return {
        "file": study.request.pilot,
        "following": study.request.following,
        "participants": pilot.participants,
        "left_out": pilot.left_out,
        "trials": pilot.trials,
        "missing": pilot.missing,
        "trials_of_condition": pilot.m,
        "mean_squares": pilot.mean_squares,
        "degrees_of_freedom": pilot.df,
        "estimates": pilot.raw,
        "variances": pilot.variances,
        "means": dict(zip(study.measure.design.conditions, map(float, pilot.means))),
        "fit": {
            "f": pilot.f,
            "p_below": pilot.p_below,
            "sd_of_differences": pilot.pairs(study.contrasts).to_dict("index"),
        },
    }

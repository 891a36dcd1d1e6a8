"""Artificial trials for tests: the paper's means with scatter between people and between trials.

They are those of the former C++ tests, number by number up to the last digit of log and cos.
"""

from __future__ import annotations

import csv
import io
import math
from dataclasses import dataclass, field
from typing import Any

_MASK = (1 << 64) - 1
_WORDS, _MIDDLE = 312, 156


class SeededRandom:
    """geometry/base/random.h: a 64-bit Mersenne Twister (std::mt19937_64), and Box-Muller."""

    def __init__(self, seed: int) -> None:
        self._state = [seed & _MASK]
        for i in range(1, _WORDS):
            last = self._state[-1]
            self._state.append((6364136223846793005 * (last ^ last >> 62) + i) & _MASK)
        self._next = _WORDS

    def _turn(self) -> None:
        state = self._state
        for i in range(_WORDS):
            x = (state[i] & 0xFFFFFFFF80000000) | (state[(i + 1) % _WORDS] & 0x7FFFFFFF)
            state[i] = state[(i + _MIDDLE) % _WORDS] ^ x >> 1 ^ (0xB5026F5AA96619E9 if x & 1 else 0)
        self._next = 0

    def bits(self) -> int:
        if self._next == _WORDS:
            self._turn()
        x = self._state[self._next]
        self._next += 1
        x ^= x >> 29 & 0x5555555555555555
        x ^= x << 17 & 0x71D67FFFEDA60000
        x ^= x << 37 & 0xFFF7EEE000000000
        return x ^ x >> 43

    def uniform(self, low: float, high: float) -> float:
        return low + (high - low) * (self.bits() >> 11) * 2.0**-53

    def index(self, count: int) -> int:
        return self.bits() % count

    def normal(self) -> float:
        radius = math.sqrt(-2.0 * math.log(1.0 - self.uniform(0.0, 1.0)))
        return radius * math.cos(self.uniform(0.0, 2.0 * math.pi))


@dataclass(frozen=True)
class SampleTrials:
    """The settings of a sample. effects: of Haptic and Rotation; 0 is none, 1 that of the paper."""

    followings: tuple[str, ...] = ("",)  # "": people
    participants: int = 10
    blocks: int = 3
    haptic: tuple[str, ...] = ("NoH", "UaH", "H")
    rotation: tuple[str, ...] = ("NoR", "R")
    objects: tuple[str, ...] = ("O1", "O2", "O3", "O4")
    effects: float = 1.0
    has_timeouts: bool = False  # about a fifth of the trials in R with `frozen`
    seed: int = 1


@dataclass
class _Draws:
    random: SeededRandom
    sample: SampleTrials
    person: float = 0.0
    rows: list[dict[str, Any]] = field(default_factory=list)


def _half_up(value: float) -> float:
    return math.copysign(math.floor(abs(value) + 0.5), value)


def _add(draws: _Draws, row: dict[str, Any], place: float) -> None:
    random, sample, person = draws.random, draws.sample, draws.person
    e = sample.effects
    of = {"NoH": 0, "UaH": 1, "H": 2}[row["haptic"].removeprefix("seen-")]
    r = 0.5 if row["rotation"] == "R" else -0.5
    block = row["block"]
    time = (27.0 + e * (2.0, 0.3, -2.0)[of] + 4.0 * e * r + 3.0 * person + 5.0 * place - block
            + 5.0 * random.normal())
    losses = (22.0 + e * (2.0, 0.0, -1.5)[of] + 2.0 * e * r + 2.0 * person + 0.3 * (time - 27.0)
              + 2.0 * random.normal())
    depth_dm = (0.067 + e * (0.034, 0.001, -0.036)[of] - e * r * (-0.01, 0.02, -0.01)[of]
                + 0.004 * person + 0.008 * random.normal())
    angle = 41.0 - 17.0 * e * r + 2.0 * person + 3.0 * random.normal()
    is_lost = (sample.has_timeouts and row["following"] == "frozen" and row["rotation"] == "R"
               and random.uniform(0.0, 1.0) < 0.2)
    row["status"] = "timeout" if is_lost else "done"
    if not is_lost:
        time_s = (100.0 if block == 0 else 1.0) * max(8.0, time)
        count = max(0.0, _half_up(losses))
        row.update({"total_time_s": time_s,
                    "losses_of_contact": count,
                    "losses_100ms": max(0.0, _half_up(0.5 * losses)),
                    "losses_per_s": count / time_s,
                    "mean_penetration_m": 0.1 * max(0.001, depth_dm),
                    "mean_penetration_dm": max(0.001, depth_dm),
                    "mean_contact_angle_deg": max(1.0, angle)})
    draws.rows.append(row)


def sample_trials(sample: SampleTrials = SampleTrials()) -> list[dict[str, Any]]:
    """The rows of trials.csv, as columns and values. Block 0 is practice; its times are a hundred
    times too long."""
    draws = _Draws(SeededRandom(sample.seed), sample)
    for following in sample.followings:
        for participant in range(1, sample.participants + 1):
            draws.person = draws.random.normal()
            for block in range(sample.blocks + 1):
                conditions = [(h, r, o) for h in sample.haptic for r in sample.rotation
                              for o in range(len(sample.objects))]
                for trial, (haptic, rotation, o) in enumerate(conditions, start=1):
                    row = {"following": following, "participant": str(participant), "block": block,
                           "trial": trial, "haptic": haptic, "rotation": rotation,
                           "object": sample.objects[o], "attempt": 1}
                    _add(draws, row, 0.5 * o)
    return draws.rows


MEASURES = ("total_time_s", "losses_of_contact", "losses_100ms", "losses_per_s",
            "mean_penetration_m",
            "mean_penetration_dm", "mean_contact_angle_deg")
COLUMNS = ("following", "participant", "block", "trial", "haptic", "rotation", "object", "attempt",
           "status") + MEASURES


def trials_csv(rows: list[dict[str, Any]], columns: tuple[str, ...] = COLUMNS) -> str:
    """The text of trials.csv. What a row does not have is an empty field; numbers have the fewest
    digits that identify them."""
    text = io.StringIO(newline="")
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(columns)
    for row in rows:
        writer.writerow([_field(row.get(column, "")) for column in columns])
    return text.getvalue()


def _field(value: Any) -> str:
    if isinstance(value, float):
        return repr(int(value)) if value.is_integer() and abs(value) < 1e15 else repr(value)
    return str(value)

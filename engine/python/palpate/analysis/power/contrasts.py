"""The tests of the primary analysis, as contrasts of the conditions of one person."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import reduce
from itertools import combinations, groupby

import numpy as np

from palpate.analysis.statistics import all_terms, effect_name
from palpate.analysis.statistics.repeated import helmert_contrasts
from palpate.analysis.statistics.types import EPSILON, Array

PLAIN, GREENHOUSE_GEISSER, HOLM = "uncorrected", "Greenhouse-Geisser", "Holm"


@dataclass(frozen=True)
class Design:
    """Every combination of these levels; Rotation varies fastest."""

    haptic: tuple[str, ...]
    rotation: tuple[str, ...]

    @property
    def conditions(self) -> list[str]:
        """ "UaH-R", ..."""
        return [f"{haptic}-{rotation}" for haptic in self.haptic for rotation in self.rotation]


@dataclass(frozen=True, eq=False)
class Contrast:
    """A test of an effect, or of a pair of means."""

    name: str  # "Haptic"; "H - UaH"
    correction: str
    # conditions x degrees of freedom. Of an effect: orthonormal columns; of a pair: its difference.
    weights: Array
    family: str = ""  # of pairs, for which Holm's correction is made; empty: an effect

    @property
    def title(self) -> str:
        return f"{self.name}, {self.correction}"

    def is_null(self, means: Array) -> bool:
        """Whether these means of the conditions make the hypothesis true, to within rounding."""
        # A mean may be a sum of three numbers, and a score is a sum of one product per mean.
        bound = (len(means) + 4.0) * EPSILON * np.abs(means).sum()
        return bool((np.abs(means @ self.weights) <= bound).all())


def contrasts_of(design: Design) -> list[Contrast]:
    """The effects, each uncorrected and, with more than one degree of freedom, by Greenhouse and
    Geisser; then the pairs by Holm, those of a family side by side."""
    return [*_effects(design), *_pairs(design)]


def _effects(design: Design) -> Iterator[Contrast]:
    levels = {"Haptic": len(design.haptic), "Rotation": len(design.rotation)}
    for term in all_terms([name for name, k in levels.items() if k > 1]):
        parts = [helmert_contrasts(k) if name in term else np.full((k, 1), 1.0 / np.sqrt(k))
                 for name, k in levels.items()]
        weights = reduce(np.kron, parts)
        yield Contrast(effect_name(term), PLAIN, weights)
        if weights.shape[1] > 1:
            yield Contrast(effect_name(term), GREENHOUSE_GEISSER, weights)


def _pairs(design: Design) -> Iterator[Contrast]:
    haptics, rotations = len(design.haptic), len(design.rotation)
    of_haptic, mean = np.eye(haptics), np.full(rotations, 1.0 / rotations)
    for i, j in combinations(range(haptics), 2):
        weights = np.kron(of_haptic[j] - of_haptic[i], mean)[:, None]
        name = f"{design.haptic[j]} - {design.haptic[i]}"
        yield Contrast(name, HOLM, weights, "levels of Haptic")
    if rotations < 2:
        return
    for row, level in zip(of_haptic, design.haptic):
        weights = np.kron(row, np.array([-1.0, 1.0]))[:, None]
        yield Contrast(f"R - NoR in {level}", HOLM, weights, "R - NoR within each level of Haptic")


def together(contrasts: Sequence[Contrast]) -> list[list[int]]:
    """The places of the tests of each effect, and of those of each family of pairs."""
    key = [contrast.family or contrast.name for contrast in contrasts]
    return [list(places) for _, places in groupby(range(len(key)), key.__getitem__)]

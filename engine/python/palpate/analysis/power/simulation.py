"""Power by simulation: how often the tests are significant with the first 2, 3, ... people.

A trial is y = condition + u(person) + w(person, condition) + e(trial), all normal and independent.
u cancels in every test, so that the power depends on the noise alone: the variance of a person's
mean in a condition, var w + var e / trials. Each data set is drawn once, with the noise 1, and
serves all models and all numbers of people: with a standard deviation s, only the true effects
change, which become effect / s. A curve over the number of people is therefore smooth, its points
are not independent, and each has the error of all data sets.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import reduce
from typing import Any

import numpy as np
from numpy.typing import NDArray

from palpate.analysis.statistics import SIGNIFICANCE, f_for_tail, t_for_coverage
from palpate.analysis.statistics.types import EPSILON, Array

from .contrasts import GREENHOUSE_GEISSER, Contrast, together

_chebyshev: Any = np.polynomial.chebyshev  # NumPy 1.24 has no types for it

Counts = NDArray[np.int64]
Bools = NDArray[np.bool_]

# Data sets that are drawn with one seed, so that no number depends on threads. Arrays of a block
# stay in a cache.
BLOCK = 256
_DEGREE = 24  # of the series of critical values; the error is below 1e-11, see the tests


class EpsilonLimits:
    """The critical F of 2 epsilon and 2 epsilon (n - 1) degrees of freedom, by the number of people
    and epsilon (1/2 to 1): a Chebyshev series of its logarithm."""

    def __init__(self, people: NDArray[Any]) -> None:
        nodes = _chebyshev.chebpts1(_DEGREE + 1)
        df1 = 1.5 + 0.5 * nodes[:, None]
        logarithms = np.log(f_for_tail(SIGNIFICANCE, df1, df1 * (people - 1.0)))
        self._series = _chebyshev.chebfit(nodes, logarithms, _DEGREE)[:, :, None]

    def __call__(self, epsilon: Array) -> Array:
        """epsilon: (people, sets)."""
        place = np.clip(4.0 * epsilon - 3.0, -1.0, 1.0)  # rounding may leave 1/2 to 1
        return np.asarray(np.exp(_chebyshev.chebval(place, self._series, tensor=False)))


def draw(seed: int, block: int, people: int, conditions: int) -> Array:
    """Standard normal means, (people, conditions, BLOCK): the first people are the same for any
    number of people."""
    random = np.random.Generator(np.random.PCG64([seed, block]))
    return random.standard_normal((people, conditions, BLOCK))


class Scores:
    """The scores of one contrast in a block of data sets, for the first 2, 3, ... people."""

    def __init__(self, contrast: Contrast, noise: Array) -> None:
        """noise: (people, conditions, sets), of draw()."""
        scores = contrast.weights.T @ noise
        n = np.arange(1.0, len(scores) + 1.0)[:, None, None]
        means = scores.cumsum(axis=0) / n
        squares = (np.square(scores).cumsum(axis=0) - n * np.square(means))[1:]
        squares = np.maximum(squares, EPSILON**2)  # two scores may be equal to within rounding
        factor = n[1:] * (n[1:] - 1.0) / squares.sum(axis=1, keepdims=True)
        # F is the square of the standardised mean: of `effect` alone, plus that of the noise.
        self._scale = np.sqrt(factor[:, 0])
        self._noise = [self._scale * mean for mean in means[1:].swapaxes(0, 1)]
        self._parts = (scores, means, squares)

    def f(self, effects: NDArray[Any]) -> Array:
        """(people, sets): F, or the square of the paired t. effects: the true mean of each score
        divided by the standard deviation of the noise."""
        standardised = [effect * self._scale + noise for effect, noise in zip(effects, self._noise)]
        return np.asarray(reduce(np.add, map(np.square, standardised)))

    def epsilon(self) -> Array:
        """(people, sets): Greenhouse and Geisser's, of two degrees of freedom."""
        scores, means, squares = self._parts
        n = np.arange(2.0, len(scores) + 1.0)[:, None]
        products = scores.prod(axis=1).cumsum(axis=0)[1:] - n * means[1:].prod(axis=1)
        trace, trace_of_square = squares.sum(axis=1), np.square(squares).sum(axis=1)
        return np.asarray(np.square(trace) / (2.0 * (trace_of_square + 2.0 * np.square(products))))


def holm(t2: Sequence[Array], limits: Sequence[Array]) -> list[Bools]:
    """Which tests of a family are significant, step-down (Holm, 1979).

    limits: of t^2 for 1, 2, ... remaining hypotheses, ascending.
    """
    found = [np.zeros(t2[0].shape, dtype=bool) for _ in t2]
    goes_on = np.ones(t2[0].shape, dtype=bool)
    for step, limit in enumerate(reversed(limits), 1):
        above = [each > limit for each in t2]
        count = reduce(np.add, [each.view(np.int8) for each in above])
        goes_on &= count >= step  # also the step-th largest exceeds its limit
        for significant, each in zip(found, above):
            significant |= goes_on & each
    return found


def _for_each_set(limits: Array) -> Array:
    """(people, sets): NumPy compares whole arrays three times as fast as an array and a column."""
    return np.repeat(limits[:, None], BLOCK, axis=1)


class Simulation:
    """Counts how many data sets are significant.

    contrasts: the tests. means: of the conditions. noises: the variance of a person's mean in a
    condition, of each model.
    """

    def __init__(
        self, contrasts: Sequence[Contrast], means: Array, noises: Array, people: int, seed: int
    ) -> None:
        self._contrasts, self._means, self._seed = contrasts, means, seed
        self._groups = together(contrasts)
        self._sds = np.sqrt(noises)
        n = np.arange(2.0, people + 1.0)
        # By the degrees of freedom of an effect, and for 1, 2, ... remaining pairs of a family.
        self._f = {k: _for_each_set(f_for_tail(SIGNIFICANCE, k, k * (n - 1.0))) for k in (1, 2)}
        largest = max(len(group) for group in self._groups)
        t = [t_for_coverage(n - 1.0, 1.0 - SIGNIFICANCE / k) for k in range(1, largest + 1)]
        self._t2 = [_for_each_set(np.square(each)) for each in t]
        self._epsilon = EpsilonLimits(n)
        self._shape = len(noises), len(contrasts), people - 1

    def decisions(self, noise: Array, sd: float) -> Bools:
        """(tests, people from 2 on, sets), with this standard deviation of the noise."""
        found = [self._decider(group, noise)(sd) for group in self._groups]
        return np.stack([decision for group in found for decision in group])

    def _decider(self, group: list[int], noise: Array) -> Callable[[float], list[Bools]]:
        """Decides the tests of a group, given a standard deviation of the noise."""
        tests = [self._contrasts[t] for t in group]
        effects = [self._means @ test.weights for test in tests]
        sets = noise.shape[-1]
        if tests[0].family:
            of_pairs = [Scores(test, noise) for test in tests]

            def decide_family(sd: float) -> list[Bools]:
                t2 = [scores.f(effect / sd) for scores, effect in zip(of_pairs, effects)]
                return holm(t2, [limit[:, :sets] for limit in self._t2[: len(tests)]])

            return decide_family
        of_effect = Scores(tests[0], noise)
        limits = [self._f[tests[0].weights.shape[1]][:, :sets]]
        if tests[-1].correction == GREENHOUSE_GEISSER:
            limits.append(self._epsilon(of_effect.epsilon()))

        def decide_effect(sd: float) -> list[Bools]:
            f = of_effect.f(effects[0] / sd)
            return [f > limit for limit in limits]

        return decide_effect

    def _count_block(self, block: int, sets: int) -> Counts:
        """(models, tests, people from 2 on)."""
        conditions = len(self._means)
        noise = draw(self._seed, block, self._shape[2] + 1, conditions)[..., :sets]
        counts = np.empty(self._shape, dtype=np.int64)
        for group in self._groups:
            decide = self._decider(group, noise)
            for model, sd in enumerate(self._sds):
                for t, significant in zip(group, decide(sd)):
                    counts[model, t] = np.count_nonzero(significant, axis=1)
        return counts

    def counts(self, sets: int, jobs: int = 1) -> Counts:
        """(models, tests, people from 2 on): how many of the data sets are significant. jobs:
        threads; the result does not depend on them."""
        total = np.zeros(self._shape, dtype=np.int64)
        blocks = -(-sets // BLOCK)
        sizes = [min(BLOCK, sets - BLOCK * block) for block in range(blocks)]
        with ThreadPoolExecutor(jobs) as threads:
            for counts in threads.map(self._count_block, range(blocks), sizes):
                total += counts
        return total


def first_of_equal_noise(noises: Array) -> Counts:
    """For each noise, the first that is equal to within rounding."""
    roundings = 32.0  # a noise comes from shares and a variance by fewer
    is_equal = np.abs(noises[:, None] - noises) <= roundings * EPSILON * noises[:, None]
    return np.asarray(is_equal.argmax(axis=1))


def simulate(
    contrasts: Sequence[Contrast],
    means: Array,
    noises: Array,
    people: int,
    sets: int,
    seed: int,
    jobs: int = 1,
) -> Counts:
    """(models, tests, people from 2 on): how many data sets are significant. Models of equal noise
    have equal counts."""
    different, place = np.unique(first_of_equal_noise(noises), return_inverse=True)
    simulation = Simulation(contrasts, means, noises[different], people, seed)
    return simulation.counts(sets, jobs)[place]

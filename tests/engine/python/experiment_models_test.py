"""The mixed model and the losses as counts, against R (r/models.R)."""

from __future__ import annotations

import math
import sys
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parent / "r"))
from experiment_samples import LIMIT_S, frame_of
from palpate.analysis.experiment.experiments import experiments_of
from palpate.analysis.experiment.loss_rates import loss_rates
from palpate.analysis.experiment.outcomes import LOSSES, PENETRATION, TIME
from palpate.analysis.experiment.variances import parts_of_variance
from palpate.analysis.power.contrasts import Design
from palpate.analysis.power.pilot import estimate
from sample_trials import SampleTrials, sample_trials
from unbalanced_trials import rows as unbalanced_rows


def experiment_of(rows):
    for row in rows:
        row.setdefault("status", "done")
    return experiments_of(frame_of(rows), LIMIT_S)[0]


@pytest.fixture(scope="module")
def unbalanced():
    return experiment_of(unbalanced_rows())


# nlme never reaches a part of 0; of the penetration these are its numbers without that part, which is
# more likely.
@pytest.mark.parametrize(
    ("outcome", "sds"),
    [
        (TIME, (2.559927389, 3.096015201, 5.370158262)),
        (LOSSES, (2.197050062, 2.268266718, 2.437042165)),
        (PENETRATION, (0.0, 0.00714858827, 0.00780511814)),
    ],
    ids=lambda value: getattr(value, "key", ""),
)
def test_parts_of_variance_equal_those_of_nlme(unbalanced, outcome, sds):
    parts = parts_of_variance(unbalanced, outcome)
    found = parts.participants, parts.participant_condition, parts.trials
    assert found == pytest.approx(sds, rel=1e-5)  # nlme's optimiser
    squares = np.square(sds)
    assert parts.share_of_participants == pytest.approx(squares[:2].sum() / squares.sum(), rel=1e-5)
    assert (parts.n_trials, parts.n_participants) == (370, 6)


# The condition is that of the pilot of `experiment power`, with objects and blocks fixed: the numbers
# are the same where no estimate is negative.
@pytest.mark.parametrize("people", [4, 10, 41])
def test_parts_of_variance_are_those_of_a_pilot(people):
    rows = sample_trials(SampleTrials(participants=people))
    for row in rows:  # how the person differs in the condition
        place = 7.0 * int(row["participant"]) + 3.0 * len(row["haptic"]) + len(row["rotation"])
        row["total_time_s"] += 6.0 * math.sin(place)
    experiment = experiment_of(rows)
    pilot = estimate(experiment, TIME, Design(("NoH", "UaH", "H"), ("NoR", "R")))
    assert min(pilot.raw.values()) > 0.0
    parts = parts_of_variance(experiment, TIME)
    found = parts.participants, parts.participant_condition, parts.trials
    assert found == pytest.approx(np.sqrt([pilot.raw[name] for name in "uwe"]), rel=1e-7)


def test_one_block_of_one_object_has_no_parts():
    rows = sample_trials(SampleTrials(participants=4, blocks=1, objects=("O1",)))
    assert np.isnan(parts_of_variance(experiment_of(rows), TIME).trials)


def test_loss_rates_equal_those_of_glm(unbalanced):
    rates = loss_rates(unbalanced)
    expected = {  # ratio, 95 % interval, p
        "UaH / NoH": (0.996144367601, 0.959093408522, 1.034626650842, 0.841252727963),
        "H / NoH": (0.968711472271, 0.932002628608, 1.006866169371, 0.106483752743),
        "H / UaH": (0.972460924117, 0.934919068484, 1.011510280208, 0.163897698465),
        "R / NoR": (1.006765685862, 0.975484527276, 1.039049946860, 0.674644101076),
    }
    found = rates.ratios.set_index("pair")[["ratio", "low", "high", "p"]]
    assert list(found.index) == list(expected)
    for pair, values in expected.items():
        assert list(found.loc[pair]) == pytest.approx(values, rel=1e-9)
    assert rates.dispersion == pytest.approx(0.640936021392, rel=1e-9)
    assert (rates.df, rates.trials) == (356, 370)


# Twice the losses in twice the time are no difference.
def test_rate_does_not_depend_on_the_time():
    rows = sample_trials(SampleTrials(participants=3, effects=0.0))
    for row in rows:
        row["losses_of_contact"] = 10.0
        row["total_time_s"] = 10.0
        if row["rotation"] == "R":
            row.update(losses_of_contact=20.0, total_time_s=20.0)
        if row["block"] == 2 and row["object"] == "O1":
            row["losses_of_contact"] *= 1.1
    ratios = loss_rates(experiment_of(rows)).ratios
    assert list(ratios["ratio"]) == pytest.approx([1.0] * 4, rel=1e-3)


def test_level_without_losses_has_no_rates():
    rows = sample_trials(SampleTrials(participants=3))
    for row in rows:
        if row["haptic"] == "H":
            row["losses_of_contact"] = 0.0
    assert loss_rates(experiment_of(rows)) is None

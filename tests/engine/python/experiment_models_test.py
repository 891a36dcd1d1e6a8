"""The mixed model and the losses as counts, against R (r/models.R) and on balanced data."""

from __future__ import annotations

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
from sample_trials import SampleTrials, sample_trials
from unbalanced_trials import rows as unbalanced_rows


def experiment_of(rows):
    for row in rows:
        row.setdefault("status", "done")
    return experiments_of(frame_of(rows), LIMIT_S)[0]


@pytest.fixture(scope="module")
def unbalanced():
    return experiment_of(unbalanced_rows())


@pytest.mark.parametrize(
    ("outcome", "sds"),
    [
        (TIME, (2.725175451, 3.019611650, 5.457167889)),
        (LOSSES, (2.314244786, 2.278939413, 2.528397970)),
        (PENETRATION, (0.002103059371, 0.008035075246, 0.007659083970)),
    ],
    ids=lambda value: getattr(value, "key", ""),
)
def test_parts_of_variance_equal_those_of_nlme(unbalanced, outcome, sds):
    parts = parts_of_variance(unbalanced, outcome)
    found = parts.participants, parts.participant_condition, parts.trials
    assert found == pytest.approx(sds, rel=5e-4)  # variances to 1e-3
    squares = np.square(sds)
    assert parts.share_of_participants == pytest.approx(squares[:2].sum() / squares.sum(), rel=1e-3)
    assert (parts.n_trials, parts.n_participants) == (370, 6)


# On balanced data, restricted maximum likelihood gives what mean squares give, if that is positive.
def test_parts_of_variance_of_balanced_data_are_those_of_mean_squares():
    experiment = experiment_of(sample_trials())
    grid = experiment.grid(TIME).reshape(10, 24, 3)
    cells, blocks, mean = grid.mean(axis=2), grid.mean(axis=(0, 1)), grid.mean()
    people, conditions = cells.mean(axis=1), cells.mean(axis=0)
    of_people = 72.0 * np.square(people - mean).sum() / 9.0
    both = 3.0 * np.square(cells - people[:, None] - conditions + mean).sum() / (9.0 * 23.0)
    trials = np.square(grid - cells[:, :, None] - blocks + mean).sum() / (239.0 * 2.0)
    expected = np.sqrt([(of_people - both) / 72.0, (both - trials) / 3.0, trials])
    parts = parts_of_variance(experiment, TIME)
    found = parts.participants, parts.participant_condition, parts.trials
    assert found == pytest.approx(expected, rel=5e-4)


def test_part_of_nothing_is_0_and_one_block_has_no_parts():
    rows = sample_trials(SampleTrials(participants=4))
    assert parts_of_variance(experiment_of(rows), PENETRATION).participant_condition == 0.0
    rows = sample_trials(SampleTrials(participants=4, blocks=1))
    assert np.isnan(parts_of_variance(experiment_of(rows), TIME).trials)


def test_loss_rates_equal_those_of_glm(unbalanced):
    rates = loss_rates(unbalanced)
    expected = {  # ratio, 95 % interval, p
        "UaH / NoH": (1.003826294106, 0.965667383292, 1.043493076574, 0.846444282835),
        "H / NoH": (0.967969118170, 0.930410175277, 1.007044246320, 0.106587998274),
        "H / UaH": (0.964279501197, 0.926207373327, 1.003916599249, 0.0766180633554),
        "R / NoR": (0.990683053355, 0.959222626115, 1.023175314556, 0.56873643355),
    }
    found = rates.ratios.set_index("pair")[["ratio", "low", "high", "p"]]
    assert list(found.index) == list(expected)
    for pair, values in expected.items():
        assert list(found.loc[pair]) == pytest.approx(values, rel=1e-9)
    assert rates.dispersion == pytest.approx(0.673756680857, rel=1e-9)
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

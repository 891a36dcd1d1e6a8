"""What a question about power assumes: the paper's scatter and effects, shares, and the variances of
pilots."""

import argparse
from dataclasses import dataclass
from os import environ
from pathlib import Path

import numpy as np
import pytest

from palpate.analysis.errors import InputError
from palpate.analysis.experiment.outcomes import LOSSES, PENETRATION, TIME
from palpate.analysis.power import command, paper
from palpate.analysis.power.contrasts import contrasts_of
from palpate.analysis.power.notes import notes
from palpate.analysis.power.pilot import Pilot, estimate, experiment_of
from palpate.analysis.power.question import MEASURES, prepare
from palpate.analysis.power.simulation import first_of_equal_noise
from palpate.analysis.trials import read_trials

SIX = MEASURES["time"].design
PILOTS = 200


def random(seed):
    seed = int(environ.get("PALPATE_SEED", seed))
    print(f"PALPATE_SEED={seed}")
    return np.random.default_rng(seed)


def request(*options):
    parser = argparse.ArgumentParser()
    command.add_arguments(parser)
    return parser.parse_args(options)


def study(*options):
    return prepare(request(*options))


# The standard deviations follow from the paper's numbers as they are printed there.
def test_the_paper_has_the_scatter_of_its_own_model():
    time, losses, penetration = map(paper.trial_scatter, (TIME, LOSSES, PENETRATION))
    assert [each.sd for each in time] == pytest.approx([9.0, 9.9], abs=0.05)
    assert losses[1].source == "Haptic"
    assert [each.sd for each in losses] == pytest.approx([2.8, 5.4], abs=0.05)
    assert [each.sd for each in penetration] == pytest.approx([0.0146, 0.0188], abs=0.00005)
    assert paper.angle_scatter().sd == pytest.approx(4.29, abs=0.005)


# By trying means of the losses in steps of a hundredth within half a digit.
def test_rounding_of_the_papers_means_allows_a_range_of_errors():
    rotation, haptic = paper.trial_scatter(LOSSES)
    steps = np.arange(101) / 100.0
    means = np.stack(np.meshgrid(23.5 + steps, 21.5 + steps, 20.5 + steps))
    squares = np.square(means - means.mean(axis=0)).sum(axis=0)
    sds = np.sqrt(240.0 * squares / 2.0 / 19.139)
    assert haptic.low == pytest.approx(sds.min(), rel=1e-12)  # the extremes are at steps
    assert haptic.high == pytest.approx(sds.max(), rel=1e-12)
    assert [sds.min(), sds.max()] == pytest.approx([3.54, 7.37], abs=0.005)
    assert rotation.low == 0.0  # 22.5 and 22.5
    assert rotation.high == pytest.approx(np.sqrt(360.0 * 2.0 / 22.389), abs=1e-12)
    assert not haptic.allows(rotation.sd)
    assert rotation.allows(haptic.sd)
    assert [paper.rounding(mean) for mean in (29.0, 27.5, 0.101)] == pytest.approx(
        [0.5, 0.05, 0.0005], rel=1e-15)


def test_the_papers_means_keep_the_levels_and_have_no_interaction():
    contrasts = {contrast.title: contrast for contrast in contrasts_of(SIX)}
    for outcome in (TIME, LOSSES, PENETRATION):
        means = paper.condition_means(outcome)
        assert contrasts["Rotation x Haptic, uncorrected"].is_null(means)
        assert not contrasts["Haptic, uncorrected"].is_null(means)
    time = paper.condition_means(TIME)
    assert 0.5 * (time[0] + time[1]) == pytest.approx(29.0, abs=1e-12)
    assert time[1] - time[0] == pytest.approx(29.15 - 25.14, abs=1e-12)


# Of the paper's experiment, the scatter of the paired difference must come out again.
def test_the_angle_has_the_paired_difference_with_any_shares():
    noise = study("--measure=angle").assumptions["noise"].to_numpy()
    assert len(noise) == 36
    assert np.sqrt(2.0 * noise) == pytest.approx(paper.angle_scatter().sd, abs=1e-12)
    assert not first_of_equal_noise(noise).any()
    noise = study("--measure=angle", "--trials=4").assumptions["noise"].to_numpy()
    assert first_of_equal_noise(noise).any()


def test_shares_are_parts_of_the_variance_of_one_trial():
    found = study("--error=10", "--share-u=0.3", "--share-w=0.1").assumptions
    assert len(found) == 1
    assert found[["u", "w", "e"]].to_numpy()[0] == pytest.approx([30.0, 10.0, 60.0], abs=1e-12)
    assert found["noise"][0] == pytest.approx(10.0 + 60.0 / 12.0, abs=1e-12)
    assert len(study("--error=10", "--share-u=0.3").assumptions) == 6  # w 0.1 to 0.6
    assert len(study("--error=10").assumptions) == 36


@dataclass
class Trials:
    """What estimate() asks of an experiment. table: people, Haptic, Rotation, Object, Trial."""

    table: np.ndarray

    @property
    def participants(self):
        return [str(p + 1) for p in range(len(self.table))]

    @property
    def levels(self):
        return {"Haptic": SIX.haptic, "Rotation": SIX.rotation}

    def has(self, outcome):
        return True

    def grid(self, outcome):
        return self.table


def pilot_trials(rng, people, objects, blocks, variances, common=0.0, step=1.0):
    """Trials of the model, around a mean of 100. common: sd of what all people have in common in a
    condition, an object and a block; step: between the means of the conditions."""
    u, w, e = np.sqrt(variances)
    shape = (people, 6, objects * blocks)
    table = (100.0 + step * np.arange(6.0)[:, None]
             + u * rng.standard_normal((people, 1, 1))
             + w * rng.standard_normal((people, 6, 1))
             + common * rng.standard_normal((1, *shape[1:]))
             + e * rng.standard_normal(shape))
    return table.reshape(people, 3, 2, objects, blocks)


def estimate_of(table):
    return estimate(Trials(table), TIME, SIX)


def expect_unbiased(pilots, truth, least_negative_w):
    """Estimates before negative ones become 0: their mean is compared with the truth by its own
    standard error."""
    raw = np.array([[pilot.raw[name] for name in "uwe"] for pilot in pilots])
    mean, error = raw.mean(axis=0), raw.std(axis=0, ddof=1) / np.sqrt(len(raw))
    print("u, w, e: means", mean, "+-", error, "truth", truth)
    assert (np.abs(mean - truth) < 3.0 * error).all()
    assert np.count_nonzero(raw[:, 1] < 0.0) >= least_negative_w


def test_estimates_are_unbiased_over_200_pilots():
    rng = random(23003)
    truth = (30.0, 2.0, 60.0)  # w is often estimated below 0
    pilots = [estimate_of(pilot_trials(rng, 5, 4, 3, truth)) for _ in range(PILOTS)]
    for pilot in pilots:
        assert pilot.variances["w"] == max(0.0, pilot.raw["w"])
        assert pilot.m == 12.0
        assert pilot.df["e"] == 6 * 4 * 11
    expect_unbiased(pilots, truth, 10)


# A tenth of the trials is missing at random; objects and blocks differ more than trials.
def test_estimates_are_unbiased_over_200_pilots_with_missing_trials_and_unlike_objects():
    rng = random(23004)
    truth = (30.0, 6.0, 20.0)
    pilots = []
    for _ in range(PILOTS):
        table = pilot_trials(rng, 5, 2, 2, truth, common=12.0)
        table[rng.uniform(size=table.shape) < 0.1] = np.nan
        pilots.append(estimate_of(table))
        assert pilots[-1].m < 4.0
    expect_unbiased(pilots, truth, 0)


# By the definitions, for a pilot without missing trials and without anything in common.
def test_mean_squares_are_those_of_the_analysis_of_variance():
    n, k, m = 4, 6, 6
    table = pilot_trials(random(23005), n, 3, 2, (4.0, 3.0, 2.0))
    y = table.reshape(n, k, m)
    cell, item = y.mean(axis=2, keepdims=True), y.mean(axis=0)
    person, condition = cell.mean(axis=1, keepdims=True), cell.mean(axis=0)
    ms_p = k * m * np.square(person - y.mean()).sum() / (n - 1)
    ms_pc = m * np.square(cell - person - condition + y.mean()).sum() / ((n - 1) * (k - 1))
    ms_e = np.square(y - cell - item + condition).sum() / (k * (n - 1) * (m - 1))
    found = estimate_of(table)
    assert found.mean_squares == pytest.approx({"p": ms_p, "pc": ms_pc, "e": ms_e}, rel=1e-9)
    assert found.raw["e"] == pytest.approx(ms_e, rel=1e-9)
    assert found.raw["w"] == pytest.approx((ms_pc - ms_e) / m, abs=1e-9 * ms_pc)
    assert found.raw["u"] == pytest.approx((ms_p - ms_pc) / (k * m), abs=1e-9 * ms_p)
    assert found.means[2] == pytest.approx(condition[2, 0], abs=1e-9)
    assert found.df["pc"] == (n - 1) * (k - 1)


# A regression on columns of people and, with the sum 0, of objects and blocks gives the means of the
# people in each condition, and their covariance.
def test_missing_trials_are_adjusted_for_by_least_squares():
    n, k, items = 4, 6, 4
    table = pilot_trials(random(23007), n, 2, 2, (4.0, 3.0, 2.0), common=6.0)
    table.flat[::5] = np.nan
    cells, residual_ss, df, scatter = np.empty((n, k)), 0.0, 0, 0.0
    for c, y in enumerate(table.reshape(n, k, items).swapaxes(0, 1)):
        codes = np.vstack([np.eye(items - 1), -np.ones(items - 1)])
        x = np.hstack([np.repeat(np.eye(n), items, axis=0), np.tile(codes, (n, 1))])
        done = ~np.isnan(y.ravel())
        x, y = x[done], y.ravel()[done]
        inverse = np.linalg.inv(x.T @ x)
        fitted = inverse @ (x.T @ y)
        cells[:, c] = fitted[:n]
        residual_ss += np.square(y - x @ fitted).sum()
        df += len(y) - (n + items - 1)
        covariance = inverse[:n, :n]
        scatter += covariance.trace() - covariance.sum() / n
    m = k * (n - 1) / scatter
    centred = cells - cells.mean(axis=0)
    people = centred.mean(axis=1, keepdims=True)
    found = estimate_of(table)
    assert m < 3.5
    assert found.m == pytest.approx(m, rel=1e-9)
    assert found.df["e"] == df
    ms = found.mean_squares
    assert ms["e"] == pytest.approx(residual_ss / df, rel=1e-9)
    assert ms["pc"] == pytest.approx(m * np.square(centred - people).sum() / ((n - 1) * (k - 1)),
                                     rel=1e-9)
    assert ms["p"] == pytest.approx(m * k * np.square(people).sum() / (n - 1), rel=1e-9)


HEAD = "following,participant,block,haptic,rotation,object,status,total_time_s\n"


def pilot_csv(rng, path, change=lambda cells: [cells]):
    """Three people, two objects, two blocks. change: a row to the rows that are written."""
    times = pilot_trials(rng, 3, 2, 2, (4.0, 3.0, 2.0))
    lines = []
    for (p, h, r, o, b), time in np.ndenumerate(times):
        cells = ["", str(p + 1), str(b + 1), SIX.haptic[h], SIX.rotation[r], f"O{o + 1}", "done",
                 repr(float(time))]
        lines += [",".join(row) + "\n" for row in change(cells)]
    path.write_text(HEAD + "".join(lines))
    return estimate(experiment_of(read_trials(path), "", SIX), TIME, SIX)


# Practice counts for nothing, and a person without one condition is left out by name.
def test_practice_and_incomplete_people_are_left_out(tmp_path):
    def more(cells):
        practice = [*cells[:2], "0", *cells[3:7], repr(7.0 * float(cells[7]))]
        rows = [cells] + ([practice] if cells[2] == "1" else [])
        return rows + ([["", "Zoe", *cells[2:]]] if cells[1] == "1" and cells[4] == "NoR" else [])

    plain = pilot_csv(np.random.default_rng(23006), tmp_path / "plain.csv")
    found = pilot_csv(np.random.default_rng(23006), tmp_path / "more.csv", more)
    assert found.left_out == ["Zoe"]
    assert found.participants == 3
    assert found.mean_squares == plain.mean_squares


def made_pilot(**changes):
    return Pilot(
        missing=5, left_out=["Zoe"], m=4.0, mean_squares={"p": 1.0, "pc": 1.0, "e": 5.0},
        df={"p": 2, "pc": 8, "e": 40}, raw={"u": -1.0, "w": -2.0, "e": 3.0}, means=np.array([22.0]),
        cells=np.zeros((3, 6)), **changes)


def test_notes_say_what_is_negative_missing_or_not_normal():
    losses = study("--measure=losses")
    losses.pilot = made_pilot()
    text = "\n".join(notes(losses))
    for part in (
        "a count", "variance of u is -1, which is negative; 0 is used",
        "variance of w is -2, which is negative; 0 is used", "Zoe", "5 of 5 trials", "50 %",
        "MS_e / m = 1.25, is larger than what was observed, MS_pc / m = 0.25, by the factor 5",
        "The model does not fit this pilot: F = MS_pc / MS_e = 0.2 with 8 and 40 degrees",
        "The pilot's m is 4 trials of a person in a condition, an effective number; 12 are used",
        "as in the pilot, more people are needed", "are a lower bound", "Sphericity",
        "R - NoR = 1 may be 0 to 2",
    ):
        assert part in text
    assert "Check the units" not in text
    losses.pilot.means = np.array([0.4])
    assert notes(losses)[0].startswith("Check the units: the mean of the pilot is 0.4")


# P(F < f) by counting: the ratio of two mean squares of normal numbers.
def test_the_fit_is_the_tail_of_f_and_the_pairs_are_those_of_the_people():
    rng = random(23008)
    pilot = Pilot(m=4.0, mean_squares={"p": 1.0, "pc": 0.5, "e": 1.0},
                  df={"p": 2, "pc": 10, "e": 36}, raw={"u": 1.0, "w": 0.0, "e": 1.0},
                  cells=np.zeros((3, 6)))
    pilot.cells[:, 1] = 1.0, 4.0, 7.0  # NoH-R
    draws = 20_000
    pc = np.square(rng.standard_normal((draws, 10))).mean(axis=1)
    e = np.square(rng.standard_normal((draws, 36))).mean(axis=1)
    share = np.mean(pc < 0.5 * e)
    assert pilot.p_below == pytest.approx(share, abs=3.0 * np.sqrt(share * (1.0 - share) / draws))
    assert not pilot.is_too_low
    for name, pair in pilot.pairs(contrasts_of(SIX)).iterrows():
        # Of 1, 4, 7; the level NoH has half of each.
        expected = 3.0 if name == "R - NoR in NoH" else 1.5 if name.endswith("- NoH") else 0.0
        assert pair["pilot"] == pytest.approx(expected, abs=1e-12), name
        assert pair["model"] == pytest.approx(np.sqrt(0.5) if name[0] == "R" else 0.5, abs=1e-12)


# What has no scatter at all: F is 0 / 0 or 1 / 0, and fits.
@pytest.mark.parametrize("pc, e, p", [(1.0, 0.0, 1.0), (0.0, 1.0, 0.0)])
def test_the_fit_of_extremes(pc, e, p):
    pilot = Pilot(mean_squares={"p": 1.0, "pc": pc, "e": e}, df={"p": 2, "pc": 10, "e": 36})
    assert pilot.p_below == p


def test_variants_beside_practice_are_refused(tmp_path):
    path = tmp_path / "views.csv"
    rows = [f",{p},{b},UaH,{r},O1,done,7,{view}\n" for p in "12" for b in "012" for r in SIX.rotation
            for view in ["still" if b == "0" else "turning"]]
    path.write_text(HEAD.replace("\n", ",view\n") + "".join(rows))
    experiment_of(read_trials(path), "", MEASURES["angle"].design)
    path.write_text(path.read_text().replace("turning", "still", 1))
    with pytest.raises(InputError, match="column view: has several levels"):
        experiment_of(read_trials(path), "", MEASURES["angle"].design)


FIVE = "NoH-NoR=29,NoH-R=31,UaH-NoR=27,UaH-R=29,H-NoR=25"


def refusal(*options):
    with pytest.raises(InputError) as caught:
        study(*options)
    return str(caught.value)


# Others are in the oracle.
@pytest.mark.parametrize("text, expected", [
    (f"{FIVE},H-R=x", 'has "x" for H-R; expected a number from -1e9 to 1e9'),
    (f"{FIVE},H-R=inf", 'has "inf" for H-R'),
    (f"{FIVE},H-R=+3", 'has "+3" for H-R'),
    (f"{FIVE},H-R=1_0", 'has "1_0" for H-R'),
    (f"{FIVE},H-R=1e400", 'has "1e400" for H-R'),
    ("NoH=1", 'has the part "NoH=1"; expected CONDITION=MEAN (write NoH-NoR=29.5,... for each of '
              "NoH-NoR, NoH-R, UaH-NoR, UaH-R, H-NoR, H-R)"),
])
def test_bad_effects_are_refused(text, expected):
    assert refusal(f"--effect={text}").startswith(f"--effect: {expected}")


def test_only_the_papers_effects_are_said_to_be_published():
    own = " ".join(notes(study(f"--effect={FIVE},H-R=28")))
    assert "as large as those of --effect" in own and "published" not in own
    of_paper = " ".join(notes(study()))
    assert "are a lower bound" in of_paper and "--effect" not in of_paper


def test_effects_have_any_order_and_blanks():
    text = ", ".join(reversed(f"{FIVE},H-R=-2.5e1".split(",")))
    assert study(f"--effect={text}").means.tolist() == [29.0, 31.0, 27.0, 29.0, 25.0, -25.0]


def test_a_large_error_is_accepted():
    assert study("--error=1e9").assumptions["error_sd"].max() == 1e9


class MadePilot:
    """Three people, two objects, two blocks, and practice. The times are numbers of a formula
    without any pattern that a model could explain."""

    def __init__(self, following=""):
        self.rows, state = [], 1
        for person in range(1, 4):
            for block in range(3):
                for haptic in SIX.haptic:
                    for rotation in SIX.rotation:
                        for thing in ("O1", "O2"):
                            state = (state * 1664525 + 1013904223) % (1 << 32)
                            time = 20.0 + 4.0 * person + (state >> 24) / 32.0
                            self.rows.append([following, f"P{person}", block, haptic, rotation,
                                              thing, "done", time])

    def write(self, path, *others):
        rows = self.rows + [row for other in others for row in other.rows]
        path.write_text(HEAD + "".join(",".join(map(str, row)) + "\n" for row in rows))
        return f"--pilot={path}"


def test_a_pilot_gives_the_variances(tmp_path):
    pilot = study(MadePilot().write(tmp_path / "pilot.csv")).pilot
    assert (pilot.participants, pilot.trials, pilot.m) == (3, 72, 4.0)
    assert pilot.df["pc"] == 10
    assert pilot.df["e"] == 36  # 6 conditions, 3 - 1 people, 4 - 1 trials
    assert pilot.raw["w"] == pytest.approx(
        (pilot.mean_squares["pc"] - pilot.mean_squares["e"]) / 4.0, abs=1e-9)


def test_a_pilot_may_have_missing_trials_and_several_followings(tmp_path):
    delayed = MadePilot("delayed")
    delayed.rows[30][6:] = "timeout", ""
    delayed.rows = [row for row in delayed.rows if row[1:3] != ["P2", 2]]
    path = delayed.write(tmp_path / "both.csv", MadePilot())
    for name, trials, missing in (("delayed", 59, 13), ("people", 72, 0)):
        found = study(path, f"--following={name}")
        assert (found.pilot.participants, found.pilot.trials) == (3, trials)
        assert found.pilot.missing == missing
        text = "13 of 72 trials of the pilot are missing"
        assert any(text in note for note in notes(found)) == (missing == 13)
    assert "column following: has trials of 2 kinds; expected one kind (choose one with --following: " \
           "delayed or people)" in refusal(path)


def test_rows_of_a_pilot_run_count_only_if_there_are_no_others(tmp_path):
    alone = study(MadePilot().write(tmp_path / "plain.csv")).pilot
    head, *lines = (tmp_path / "plain.csv").read_text().splitlines()
    for name, mark in (("run.csv", 1), ("both.csv", 0)):
        text = "".join(f"{line},{mark}\n" for line in lines)
        if mark == 0:
            text += "".join(f"{line.rpartition(',')[0]},500,1\n" for line in lines)
        (tmp_path / name).write_text(f"{head},pilot\n{text}")
        found = study(f"--pilot={tmp_path / name}").pilot
        assert (found.trials, found.raw) == (alone.trials, alone.raw)


@pytest.mark.parametrize("option", ["--error", "--share-u", "--share-w"])
def test_a_pilot_excludes_assumptions(tmp_path, option):
    path = MadePilot().write(tmp_path / "pilot.csv")
    assert refusal(path, f"{option}=0.5").startswith(f"{option}: excludes --pilot")


@pytest.mark.parametrize("value", ["1e300", "1e155", "2e9"])
def test_a_pilot_with_too_large_values_is_refused(tmp_path, value):
    pilot = MadePilot()
    pilot.rows.append(["", "P1", 3, "NoH", "NoR", "O1", "done", value])
    message = refusal(pilot.write(tmp_path / "pilot.csv"))
    assert "pilot.csv: column total_time_s: is " in message
    assert "in a trial of participant P1, which is too large; expected -1e9 to 1e9" in message



def test_a_pilot_whose_force_was_seen_is_refused(tmp_path):
    pilot = MadePilot()
    for row in pilot.rows:
        row[3] = row[3] if row[3] == "NoH" else "seen-" + row[3]
    refused = refusal(pilot.write(tmp_path / "seen.csv"))
    assert "column haptic: is seen-UaH in a trial of participant P1" in refused
    assert "claim about seeing" in refused


def test_a_pilot_of_which_only_uah_is_asked_for_may_have_other_levels(tmp_path):
    path = MadePilot().write(tmp_path / "pilot.csv")
    angle = path.removeprefix("--pilot=")
    text = Path(angle).read_text().replace("total_time_s", "mean_contact_angle_deg")
    (tmp_path / "angle.csv").write_text(text)
    pilot = study(f"--pilot={tmp_path / 'angle.csv'}", "--measure=angle").pilot
    assert (pilot.participants, pilot.trials, pilot.m) == (3, 24, 4.0)

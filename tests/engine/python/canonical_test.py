"""The page of the canonical protocol, made of given rows."""

from __future__ import annotations

import itertools
import math
import re

import numpy as np
import pandas as pd
import pytest

from palpate.analysis import figures
from palpate.analysis.canonical import command, means
from palpate.analysis.canonical.figures import angle_figure
from palpate.analysis.canonical.means import MOTIONS, RATIO, SHARE, STILL, TURNING
from palpate.analysis.errors import InputError
from palpate.analysis.measured import Run

NONE = math.nan
RUN = Run(plan="plan <i>", seed=1, operator="person", operator_version=1, version="0")


def rows_at(angles_deg, operators, ratio, share):
    """Each motion without and with rotation, with the same values."""
    cells = itertools.product(range(1, operators + 1), angles_deg, MOTIONS, (STILL, TURNING))
    return pd.DataFrame([dict(zip(means.KEY, cell)) | {RATIO: ratio, SHARE: share}
                         for cell in cells])


def page_of(rows):
    return command.report(rows, RUN).files["canonical.html"]


def test_page_states_how_many_operators_have_a_value_where_not_all_have():
    rows = rows_at([30.0], 4, 0.5, 0.25)
    assert page_of(rows).count("n = ") == 0
    rows.loc[rows.index[-1], RATIO] = NONE  # operator 4, stroked, with rotation
    page = page_of(rows)
    assert page.count("n = 3<") == 1
    assert page.count("n = ") == 1


@pytest.mark.parametrize(("share", "warning", "drawings"), [
    (NONE, "no trial touched the wall", 0), (0.5, "no trial has a force into the hand", 2)])
def test_page_has_one_warning_for_one_cause(share, warning, drawings):
    report = command.report(rows_at([30.0], 2, NONE, share), RUN)
    assert len(report.warnings) == 1
    assert report.warnings[0].startswith(warning)
    assert report.files["canonical.html"].count("<svg ") == drawings


def test_page_names_a_motion_without_a_value():
    rows = rows_at([30.0], 2, 0.5, 0.5)
    rows.loc[rows["motion"] == "stroked", RATIO] = NONE
    report = command.report(rows, RUN)
    assert report.warnings == ["Force along over force into, stroked: is not drawn: no trial has a "
                               "value"]
    assert report.files["canonical.html"].count("<svg ") == 3


@pytest.mark.parametrize(("turning", "is_cut"), [(0.25, True), (7000.0, False)])
def test_the_axis_of_the_ratio_ends_above_r_and_not_above_nor(turning, is_cut):
    """NoR is tan 89.99 deg. Only an axis in thousands has labels in thousands."""
    rows = rows_at([89.99], 2, 5729.6, 0.0)
    rows.loc[rows["rotation"] == TURNING, RATIO] = turning
    of = means.means_of(rows, RATIO, "pressed")
    axis = means.ratio_axis(of)
    assert axis.is_cut == is_cut
    assert axis.top > max(turning, 4.0 if is_cut else 5729.6)
    svg = str(figures.svg(angle_figure(of, "pressed", is_ratio=True), "ratio", "title"))
    assert bool(re.search(r">[1-9]000<", svg)) != is_cut
    cut = "NoR and tan\u00a0a go on above the figure"
    assert (cut in page_of(rows)) == is_cut


def test_whiskers_of_shares_end_at_0_and_1():
    rows = rows_at([0.0, 30.0, 60.0], 3, 0.5, 0.5)
    first = rows["participant"] == 1
    for angle_deg, one, others in ((0.0, 0.9, 1.0), (30.0, 0.45, 0.5), (60.0, 0.02, 0.0)):
        at = rows["angle_deg"] == angle_deg
        rows.loc[at & first, SHARE], rows.loc[at & ~first, SHARE] = one, others
    of = means.means_of(rows, SHARE, "pressed")
    [ax] = angle_figure(of, "pressed", is_ratio=False).axes
    for whiskers in ax.collections:
        ends = np.array([segment[:, 1] for segment in whiskers.get_segments()])
        mean, half = of[STILL]["mean"], of[STILL]["half_width"]
        assert ends[0] == pytest.approx([mean[0.0] - half[0.0], 1.0])
        assert ends[1] == pytest.approx([mean[30.0] - half[30.0], mean[30.0] + half[30.0]])
        assert ends[2] == pytest.approx([0.0, mean[60.0] + half[60.0]])
    assert len(ax.collections) == 2


def test_a_run_of_one_angle_has_whiskers():
    rows = rows_at([30.0], 2, 0.5, 0.4)
    rows.loc[rows["participant"] == 2, SHARE] = 0.6
    of = means.means_of(rows, SHARE, "pressed")
    half = of[STILL]["half_width"].iloc[0]
    [ax] = angle_figure(of, "pressed", is_ratio=False).axes
    for whiskers in ax.collections:
        [segment] = whiskers.get_segments()
        assert segment[:, 1] == pytest.approx([max(0.5 - half, 0.0), min(0.5 + half, 1.0)])


def test_page_names_angles_that_differ_by_their_digits():
    rows = rows_at([89.99, 90.0], 2, 0.5, 0.5)
    rows.loc[(rows["angle_deg"] == 90.0) & (rows["rotation"] == STILL), RATIO] = NONE
    page = page_of(rows)
    assert page.count(">89.99<") == 4  # a row of each table
    assert page.count(">5729.578<") == 2  # tan a
    assert "Why is there no ratio at 90 deg without rotation?" in page
    assert "elsewhere" not in page


def test_page_explains_only_what_is_missing():
    page = page_of(rows_at([30.0, 75.0], 2, 0.5, 0.5))
    assert "Why is there no ratio" not in page
    assert "go on above the figure" not in page
    soft = page_of(rows_at([30.0, 75.0], 2, NONE, 0.5))
    assert "as at a wall without stiffness" in soft
    assert "at 90 deg" not in soft
    assert soft.count("<svg ") == 2  # of the share


def test_page_shows_names_with_markup_as_text():
    page = page_of(rows_at([30.0], 2, 0.5, 0.5))
    assert "plan &lt;i&gt;" in page
    assert "plan <i>" not in page


def test_page_has_the_same_bytes_again():
    rows = rows_at([0.0, 30.0], 3, 0.5, 0.5)
    assert page_of(rows) == page_of(rows)


def test_means_are_those_of_the_participants_with_a_value():
    """Student's t for 2 degrees of freedom is 4.302653 at 95 %."""
    rows = rows_at([15.0, 30.0], 4, NONE, 0.25)
    here = (rows["motion"] == "stroked") & (rows["angle_deg"] == 30.0)
    rows.loc[here & (rows["rotation"] == TURNING), RATIO] = [1.0, 2.0, NONE, 3.0]
    found = means.means_of(rows, RATIO, "stroked")[TURNING]
    assert list(found.index) == [15.0, 30.0]
    assert list(found["count"]) == [0, 3]
    assert math.isnan(found["mean"][15.0])
    assert found["mean"][30.0] == 2.0
    assert found["half_width"][30.0] == pytest.approx(4.302653 / math.sqrt(3.0), abs=1e-5)
    assert (means.means_of(rows, RATIO, "pressed")[TURNING]["count"] == 0).all()


def test_a_small_interval_is_left_out():
    rows = rows_at([30.0], 2, 0.5, 0.5)
    rows.loc[rows.index[0], RATIO] = 0.5 + 1e-9
    assert not re.search(r"\d ± \d", page_of(rows))
    rows.loc[rows.index[0], RATIO] = 0.6
    assert len(re.findall(r"\d ± \d", page_of(rows))) == 1


def canonical_file(folder, *lines):
    path = folder / "canonical.csv"
    names = ",".join(column.name for column in means.columns())
    path.write_text("\n".join([names, *lines]) + "\n")
    return path


def test_reads_rows(tmp_path):
    path = canonical_file(tmp_path, "1,30,pressed,NoR,0.5,", "1,30,pressed,R,,1")
    rows = means.read_canonical(path)
    assert list(rows[RATIO]) == [0.5, pytest.approx(NONE, nan_ok=True)]
    assert np.isnan(rows[SHARE][0])


@pytest.mark.parametrize(("line", "element"), [
    ("1,30,pushed,NoR,0.5,1", "line 2, column motion"),
    ("1,-1,pressed,R,0.5,1", "line 2, column angle_deg"),
    ("1,30,pressed,NoR,half,1", "line 2, column along_over_into"), ("1,30,pressed,NoR", "line 2")])
def test_names_what_is_broken(tmp_path, line, element):
    with pytest.raises(InputError) as refused:
        means.read_canonical(canonical_file(tmp_path, line))
    assert refused.value.element == element

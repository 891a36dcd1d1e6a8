"""Reading trials.csv: what is right is read to the bit, what is broken is refused in the words of
the C++."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from oracle_cases import Case, cases
from palpate import read_trials
from palpate.analysis import tables, trials
from palpate.analysis.errors import InputError, printable
from palpate.analysis.trials import columns, measures

# The lines of the C++ reader. The other ones are of the analysis: the table was read.
OF_THE_READER = re.compile(r"palpate: trials\.csv: (line \d+|byte \d+|is empty|has no trial)\b")
HEADER = ("participant,block,trial,haptic,rotation,object,attempt,status,total_time_s,"
          "losses_of_contact,mean_penetration_dm\n")
FIRST = "Ann,1,1,NoH,R,O1,1,done,25.5,21,0.031\n"
TABLE = HEADER + FIRST + "Ann,1,2,H,R,O1,1,timeout,,,\n"


@pytest.fixture(autouse=True)
def in_a_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def read(text: str | bytes) -> pd.DataFrame:
    Path("t.csv").write_bytes(text if isinstance(text, bytes) else text.encode())
    return read_trials("t.csv")


def refusal(text: str | bytes) -> InputError:
    with pytest.raises(InputError) as refused:
        read(text)
    return refused.value


@pytest.mark.parametrize("case", cases("trials"), ids=lambda case: case.name)
def test_a_table_is_refused_by_line_and_column_as_in_cpp(case: Case) -> None:
    case.put_inputs(Path())
    assert case.exit_code == 2
    if not OF_THE_READER.match(case.stderr):
        assert len(read_trials("trials.csv")) >= 1
        return
    with pytest.raises(InputError) as refused:
        read_trials("trials.csv")
    # People's trials came later, and two statuses and two forces with them.
    expected = case.stderr.replace("done, timeout or fault",
                                   "done, timeout, fault, aborted or skipped")
    expected = expected.replace("NoH, UaH or H", "NoH, UaH, H, seen-UaH or seen-H")
    assert f"palpate: {refused.value}\n" == expected


def test_there_are_many_broken_tables() -> None:
    assert sum(bool(OF_THE_READER.match(case.stderr)) for case in cases("trials")) >= 180


@pytest.mark.parametrize("end", ["\n", "\r\n"])
@pytest.mark.parametrize("layout", [str, lambda text: "\ufeff" + text, str.rstrip])
def test_rows_of_people(end: str, layout: object) -> None:
    frame = read(layout(TABLE.replace("\n", end)))  # type: ignore[operator]
    assert len(frame) == 2
    first, last = frame.iloc[0], frame.iloc[1]
    assert (first["participant"], first["following"], first["block"]) == ("Ann", "", 1)
    assert (first["haptic"], first["status"]) == ("NoH", "done")
    assert (first["total_time_s"], first["mean_penetration_dm"]) == (25.5, 0.031)
    assert "mean_penetration_m" not in frame
    assert last["status"] == "timeout" and np.isnan(last["total_time_s"])


def test_quoted_fields_other_columns_and_missing_values() -> None:
    frame = read('"participant",block,haptic,rotation,object,status,note,total_time_s\n'
                 '"Ann, ""A""",1,H,R,O1,done,"two\nlines, one field",NA\n'
                 "Bob,1,H,R,O1,fault,,nan\n\n")
    assert list(frame["participant"]) == ['Ann, "A"', "Bob"]
    assert frame["total_time_s"].isna().all()
    assert "note" not in frame


def test_every_number_is_read_to_the_bit() -> None:
    values = [(1.0 / 3.0 + i) * 2.0**-60 for i in range(len(measures()))]
    names = ["participant", "block", "haptic", "rotation", "object", "status",
             "start_orientation_deg", "scale"]
    text = ",".join([*names, *measures()]) + "\n7,0,UaH,NoR,O4,fault,-0.1," + f"{1 / 3:.17g},"
    row = read(text + ",".join(f"{value:.17g}" for value in values) + "\n").iloc[0]
    assert [row[name] for name in measures()] == values
    assert (row["start_orientation_deg"], row["scale"]) == (-0.1, 1 / 3)


def test_types_of_the_columns() -> None:
    frame = read(TABLE)
    kinds = {name: frame[name].dtype.kind for name in frame}
    whole = {"block", "trial", "attempt", "pilot"}
    assert {name for name, kind in kinds.items() if kind == "i"} == whole
    numbers = {"total_time_s", "losses_of_contact", "mean_penetration_dm", "start_orientation_deg",
               "scale"}
    assert {name for name, kind in kinds.items() if kind == "f"} == numbers
    assert kinds["participant"] == "O" and frame["strategy"].eq("").all()


# An empty field of the last columns stands for what the paper did.
def test_levels_of_a_plan() -> None:
    names = ("participant,block,haptic,rotation,object,status,view,align,start_orientation_deg,"
             "scale\n")
    frame = read(names + "1,1,H,R,O1,done,,NA,,\n1,1,H,R,O1,done,still,forward,-144,0.5\n")
    levels = ["view", "align", "start_orientation_deg", "scale"]
    assert frame.loc[0, levels].to_list() == ["turning", "nearest", 0.0, 1.0]
    assert frame.loc[1, levels].to_list() == ["still", "forward", -144.0, 0.5]


def test_the_status_is_read_before_the_measures_in_any_order_of_columns() -> None:
    row = read("total_time_s,strategy,status,object,rotation,haptic,block,participant\n"
               "nan,a4,timeout,star,,,1,Ann\n").iloc[0]
    assert np.isnan(row["total_time_s"]) and row["strategy"] == "a4"


LIVE = ("participant,block,haptic,rotation,object,status,pilot,input,motion,reason,returns_shown,"
        "clutches,pictures,longest_picture_s,css_px_per_mm\n")
REASONS = ("focus, full_screen, pointer_lock, hidden, late_ticks, late_frames, trip, fault, server, "
           "experimenter, participant or lift")
OTHER = " (rename the column if it has another meaning)"


def test_live_trials() -> None:
    frame = read(LIVE + "1,1,H,R,O1,done,1,mouse,unknown,,2,0,9,0.125,3.78\n"
                 "1,1,H,R,O1,aborted,0,board,,trip,,,,,\n2,1,H,R,O1,skipped,,,,participant,,,,,\n")
    assert frame["pilot"].to_list() == [1, 0, 0] and frame["pilot"].dtype.kind == "i"
    assert frame["reason"].to_list() == ["", "trip", "participant"]
    assert frame["input"].to_list() == ["mouse", "board", ""]
    assert frame["motion"].to_list() == ["unknown", "", ""]
    numbers = ["returns_shown", "clutches", "pictures", "longest_picture_s", "css_px_per_mm"]
    assert frame.loc[0, numbers].to_list() == [2, 0, 9, 0.125, 3.78]
    assert frame.loc[1:, numbers].isna().all(axis=None)
    assert {frame[name].dtype.kind for name in numbers} == {"f"}
    assert set(measures()).isdisjoint({"pilot", *numbers})


def test_a_status_of_live_trials_needs_no_reason_in_a_file_without_reasons() -> None:
    frame = read("participant,block,haptic,rotation,object,status\n1,1,H,R,O1,aborted\n")
    assert frame.loc[0, ["status", "reason", "pilot"]].to_list() == ["aborted", "", 0]
    assert "pictures" not in frame


# The lines of broken_inputs_test.cpp are the same.
@pytest.mark.parametrize(("fields", "problem"), [
    ("done,2,mouse,unknown,,0,0,9,0.1,4",
     'column pilot: is "2"; expected a whole number from 0 to 1' + OTHER),
    ("done,0,Mouse,unknown,,0,0,9,0.1,4",
     'column input: is "Mouse"; expected mouse, pen, touch, board or script' + OTHER),
    ("done,0,mouse,fast,,0,0,9,0.1,4",
     'column motion: is "fast"; expected unaccelerated, accelerated or unknown' + OTHER),
    ("aborted,0,mouse,unknown,bored,0,0,9,0.1,4",
     f'column reason: is "bored"; expected {REASONS}' + OTHER),
    ("skipped,0,mouse,unknown,,0,0,9,0.1,4",
     f'column reason: is ""; expected {REASONS}, because the status is skipped'),
    ("done,0,mouse,unknown,focus,0,0,9,0.1,4",
     'column reason: is "focus"; expected an empty field, because the status is done'),
    ("done,0,mouse,unknown,,-1,0,9,0.1,4",
     'column returns_shown: is "-1"; expected a whole number from 0 to 1000000' + OTHER),
    ("done,0,mouse,unknown,,0,0.5,9,0.1,4",
     'column clutches: is "0.5"; expected a whole number from 0 to 1000000' + OTHER),
    ("done,0,mouse,unknown,,0,0,NA,0.1,4",
     'column pictures: is "NA"; expected a whole number from 0 to 1000000' + OTHER),
    ("done,0,mouse,unknown,,0,0,9,inf,4",
     'column longest_picture_s: is "inf"; expected a number from 0 to 1e+06' + OTHER),
    ("done,0,mouse,unknown,,0,0,9,0.1,0",
     'column css_px_per_mm: is "0"; expected a number above 0 and at most 1e+06' + OTHER),
])
def test_a_table_of_live_trials_is_refused_by_line_and_column(fields: str, problem: str) -> None:
    assert str(refusal(f"{LIVE}1,1,H,R,O1,{fields}\n")) == f"t.csv: line 2, {problem}"


def test_the_same_trial_of_a_pilot_run_is_another_trial() -> None:
    row = "1,1,H,R,O1,done,{},mouse,unknown,,0,0,9,0.1,4\n"
    assert len(read(LIVE + row.format(0) + row.format(1))) == 2
    refused = str(refusal(LIVE + row.format(1) + row.format(1)))
    assert "attempt 1, turning, nearest, 0 deg, scale 1, pilot; expected each trial once" in refused


def test_a_file_that_cannot_be_read_is_refused_by_name() -> None:
    Path("folder").mkdir()
    for name in ("missing.csv", "folder"):
        with pytest.raises(InputError) as refused:
            read_trials(name)
        assert refused.value.path == name and str(refused.value).startswith(f"{name}: ")


def test_a_file_beyond_the_limits_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(trials, "MOST_TRIALS", 1)
    assert str(refusal(TABLE)) == ("t.csv: line 3: is beyond the limit; expected at most 1 trials "
                                   "(divide the file)")
    monkeypatch.setattr(tables, "MOST_BYTES", 100)
    assert str(refusal(TABLE)).startswith("t.csv: is larger than 100 bytes")


def test_an_error_is_one_line_whatever_a_field_holds() -> None:
    for field in ("\x1b]0;title\x07", "a\u2028b", "\u202eabc", '"a\nb"', '"\r\n"'):
        line = str(refusal(TABLE.replace("25.5", field)))
        assert line.startswith("t.csv: line 2, column total_time_s: is ")
        assert len(line.splitlines()) == 1 and line == printable(line)


def test_the_columns_of_measures_follow_from_columns_csv() -> None:
    names = [column.name for column in columns()]
    assert names.index("status") + 1 == names.index(measures()[0])
    assert {"total_time_s", "missed_deadlines", "turning_energy_J"} <= set(measures())
    assert [column.name for column in columns() if column.is_required] == [
        "participant", "block", "haptic", "rotation", "object", "status"]


def in_a_process(code: str) -> str:
    room = Path(__file__).resolve().parents[3] / "engine" / "python"
    done = subprocess.run([sys.executable, "-P", "-c", code], env={"PYTHONPATH": str(room)},
                          capture_output=True, text=True, check=True)
    return done.stdout.strip()


def test_without_pandas_the_package_of_debian_is_named() -> None:
    said = in_a_process("import sys; sys.modules['pandas'] = None\nimport palpate\n"
                        "try: palpate.read_trials('t.csv')\n"
                        "except ModuleNotFoundError as error: print(error)")
    assert said == ("palpate.read_trials needs the Python module pandas; install python3-pandas "
                    "(on Debian: apt install)")


def test_dir_lists_what_the_package_offers() -> None:
    assert in_a_process("import palpate; print(dir(palpate))") == "['read_trials']"

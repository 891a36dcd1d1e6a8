"""The figures of committed results show what their data say, and all committed figures are legible on
white and on dark ground."""

import copy
import csv
import json
import re
import sys
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

ROOT = Path(__file__).resolve().parents[3]
BENCHMARKS = ROOT / "benchmarks"
sys.path.insert(0, str(BENCHMARKS))
import a4_instants  # noqa: E402
import accuracy_results  # noqa: E402
import calm_chart_results  # noqa: E402
import compare_results  # noqa: E402
import passive_results  # noqa: E402
import result_figures  # noqa: E402
import result_tables  # noqa: E402
import sweep_results  # noqa: E402
import update_results  # noqa: E402

from palpate.analysis.results import (  # noqa: E402
    a4_helps,
    a4_turns,
    accuracy,
    budgets,
    calm_chart,
    groove,
    strategies,
)
from palpate.analysis.results.grounds import INK, TONES, on_any_ground  # noqa: E402
from palpate.analysis.results.picture import picture  # noqa: E402


def committed(name):
    return json.loads((BENCHMARKS / "results" / name).read_text(encoding="utf-8"))


def series(axes, label):
    """The points of the marks with this label, one row each."""
    lines = [line.get_xydata() for line in axes.get_lines() if line.get_label() == label]
    return np.vstack(lines) if lines else np.empty((0, 2))


def texts(axes):
    return [text.get_text() for text in axes.findobj(lambda artist: hasattr(artist, "get_text"))]


def test_committed_figures_are_drawn_from_the_committed_results():
    machines = [update_results.Machine(path) for path in (BENCHMARKS / "results").glob("*.json")]
    figures = update_results.figures_of(ROOT, machines)
    assert len(figures) == 7
    for path, (kind, table) in figures.items():
        assert result_figures.is_drawn(path, kind, table), f"{path} is up to date"


# a4.svg

def angle_deg(instant):
    """From the rotation matrix of the quaternion, between the device's normal and the x axis."""
    w, z = instant["T_device_scene"]["q_wz"]
    x, y = instant["normal_scene"]
    return np.degrees(np.arccos(min(1.0, abs((w * w - z * z) * x - 2.0 * w * z * y))))


def test_the_turning_star_has_the_angles_of_the_trace():
    data, star = committed("paper_objects/a4.json"), committed("paper_objects/objects.json")["star"]
    figure = a4_turns.draw(data, star)
    instants = data["instants"]
    angles = [angle_deg(instant) for instant in instants]
    assert len(angles) == 4 and angles == sorted(angles, reverse=True)
    for axes, angle, instant in zip(figure.axes, angles, instants):
        assert angle == pytest.approx(instant["contact_angle_deg"], abs=0.01)
        assert axes.get_title("left") == f"{instant['t_s']:.2f} s"
        assert axes.get_title("right") == f"{angle:.0f}\u00b0"
        share = 100 * np.cos(np.radians(angle))
        assert axes.get_xlabel() == f"force rendered:\n{share:.0f} %"
        (first, second) = series(axes, "wall")
        normal = a4_turns.turned(instant, instant["normal_scene"])
        # The proxy, at the origin, keeps a stand-off from the wall, far less than a pixel.
        assert abs(first @ normal) < 1e-4 and abs(second @ normal) < 1e-4
    walls = {tuple(a4_turns.touched_wall(data, instant).ravel()) for instant in instants}
    assert len(walls) == 1, "every panel shows the same wall"
    drawn = picture(figure, a4_turns.TITLE)
    changed = copy.deepcopy(data)
    changed["instants"][1]["T_device_scene"]["q_wz"] = [1.0, 0.0]
    assert picture(a4_turns.draw(changed, star), a4_turns.TITLE) != drawn, "another pose"
    changed = copy.deepcopy(star)
    changed[1]["losses_of_contact"] = 4321
    assert "4321" not in drawn
    assert "4321" in picture(a4_turns.draw(data, changed), a4_turns.TITLE), "another result"


def trace_row(tick, normal, alpha_deg, contact=1):
    return {"tick": tick, "t": 0.001 * tick, "proxy_x": 0.0, "proxy_y": 0.0, "normal_x": normal[0],
            "normal_y": normal[1], "contact": contact, "alpha_deg": alpha_deg, "q_w": 1.0, "q_z": 0.0,
            "o_x": 0.0, "o_y": 0.0}


def test_the_contact_with_the_largest_angle_is_chosen(tmp_path):
    """Three contacts: one is not aligned, one starts at a smaller angle, one is chosen."""
    rows = [trace_row(n, (1.0, 0.0), 80.0 - n) for n in range(10)]
    rows += [trace_row(10 + n, (0.0, 1.0), 60.0 - n) for n in range(61)]
    rows += [trace_row(71, (0.0, 0.0), 0.0, contact=0)]
    rows += [trace_row(72 + n, (0.0, 1.0), 70.0 - n) for n in range(71)]
    trace, contour = tmp_path / "trace.csv", tmp_path / "contour.csv"
    for path, table in ((trace, rows), (contour, [
            {"x": x, "y": y} for x, y in ((0.5, 0), (1, 0), (1, 1), (0, 1), (0, 0), (0.5, 0))])):
        with open(path, "w", newline="", encoding="utf-8") as file:
            writer = csv.DictWriter(file, table[0].keys())
            writer.writeheader()
            writer.writerows(table)
    data = a4_instants.instants_of(trace, contour)
    assert data["first_tick"] == 72, "the chosen contact starts at 70 deg"
    assert [i["contact_angle_deg"] for i in data["instants"]] == [70.0, 45.0, 20.0, 3.0]
    assert [i["t_s"] for i in data["instants"]] == [0.0, 0.025, 0.05, 0.067], "from the start of the contact"
    assert len(data["outline_scene_m"]) == 4, "a start on a straight wall is no corner"


# groove.svg

def test_the_proxy_in_the_groove_rests_nearest_to_the_goal():
    old, stopped, nearest, rest = groove.steps()
    first, second = groove.normals()
    assert max(abs(groove.height(rest, normal)) for normal in (first, second)) < 1e-12
    assert abs(groove.height(stopped, first)) < 1e-12, "the first step ends on plane 1"
    assert min(groove.height(point, second) for point in (old, stopped)) > 0.0, "plane 2 is met last"
    least = np.linalg.norm(rest - groove.GOAL_MM)
    for angle in np.radians(np.arange(0.0, 360.0, 0.1)):
        step = rest + 0.01 * np.array([np.cos(angle), np.sin(angle)])
        if min(groove.height(step, normal) for normal in (first, second)) >= 0.0:
            assert np.linalg.norm(step - groove.GOAL_MM) > least, "no free direction leads nearer"
    assert np.linalg.norm(nearest - groove.GOAL_MM) < least, "plane 1 alone would let the proxy go nearer"
    shown = texts(groove.draw())
    for text in (*groove.TEXT, groove.NOTE):
        assert any(" ".join(each.split("\n")) == text for each in shown)


# a4_helps.svg

def of_sweep(data):
    table = sweep_results.figure_table(data)
    return table, a4_helps.draw(pd.DataFrame(table["shares"]), pd.DataFrame(table["measures"]),
                                table["notes"])


def test_the_halves_and_words_of_a_sweep_lie_at_their_shares():
    data = committed("sweep/sweep.json")
    _, figure = of_sweep(data)
    measures = sweep_results.drawn(data)
    assert [axes.get_title("left") for axes in figure.axes] == [words for words, _ in measures]
    names = [label.get_text() for label in figure.axes[0].get_yticklabels()]
    assert names == list(sweep_results.ASSUMPTIONS.values())
    parameters = list(sweep_results.ASSUMPTIONS)
    for axes, (_, ranking) in zip(figure.axes, measures):
        expected = {"low half": [], "high half": [], "word": []}
        for row in data["halves"]:
            if row["ranking"] == ranking:
                part = row["part"] if row["part"] in expected else "word"
                expected[part].append((100 * row["holds"] / row["points"],
                                       parameters.index(row["parameter"])))
        # Ten numbers with two halves; four words of following and two of align.
        assert [len(points) for points in expected.values()] == [10, 10, 6]
        for part, points in expected.items():
            found = sorted(map(tuple, series(axes, part)))
            assert np.allclose(found, sorted(points), rtol=1e-9, atol=1e-9), part
    changed = copy.deepcopy(data)
    changed["halves"][-1]["share"] = 0.123
    _, other = of_sweep(changed)
    assert picture(other, "t") != picture(figure, "t"), "another share gives another picture"


def test_what_decides_a_ranking_differs_most():
    data = committed("sweep/sweep.json")
    table, _ = of_sweep(data)
    for words, ranking in sweep_results.MEASURES:
        of = [row for row in data["halves"] if row["ranking"] == ranking]
        shares = {row["parameter"]: [other["share"] for other in of
                                     if other["parameter"] == row["parameter"]] for row in of}
        differences = {name: max(values) - min(values) for name, values in shares.items()}
        decides = next(row for row in data["rankings"] if row["ranking"] == ranking)
        most = max(differences.values())
        assert (decides["p"] is None) == (most == 0.0), f"{ranking} has p if shares differ"
        is_clear = most > 0.0 and decides["p"] < 0.05
        names = [name for name, difference in differences.items() if difference == most and is_clear]
        assert (decides["decisive_parameters"] or "").split() == names
        marked = {row["assumption"] for row in table["shares"] if row["measure"] == words and row["decides"]}
        if any(row["measure"] == words for row in table["shares"]):
            assert marked == {sweep_results.ASSUMPTIONS[name] for name in names}


# The other figures

def test_the_curves_of_budgets_are_shares_of_a4():
    result = passive_results.read(BENCHMARKS / "results/compare")
    table = pd.DataFrame(passive_results.figure_table(result))
    (axes,) = budgets.draw(table).axes
    assert [text.get_text() for text in axes.get_xticklabels()] == [
        "0", "1", "2", "5", "10", "20", "50", "100", "200"]
    depths = {row["strategy"]: row["mean"] for row in result["means"] if row["measure"] == "penetration"}
    whole = depths["mask"] - depths["a4"]
    expected = [100 * (depths["mask"] - depths[f"a4-passive:{budget:g}"]) / whole
                for budget in table["budget_mJ"].unique()]
    assert np.allclose(series(axes, "gain, ways")[:, 1], expected, rtol=1e-12)


def test_each_simulated_contact_has_a_mark_at_its_delay_and_stiffness():
    cases, zones = calm_chart_results.read(BENCHMARKS / "results/calm_chart")
    table = calm_chart_results.figure_table((cases, zones))
    figure = calm_chart.draw(pd.DataFrame(table["cases"]), pd.DataFrame(table["zones"]))
    rates = sorted({float(row["rate_Hz"]) for row in zones})
    assert [axes.get_title("left") for axes in figure.axes] == [f"{rate:,.0f} Hz" for rate in rates]
    for axes, rate in zip(figure.axes, rates):
        for outcome, (words, _) in calm_chart.OUTCOMES.items():
            expected = sorted(
                (1e3 * float(row["delay_s"]), min(max(float(row["stiffness_N_per_m"]), 100.0), 20000.0))
                for row in cases if float(row["rate_Hz"]) == rate and row["states_delay"] == "1"
                and calm_chart.OUTCOMES[row["outcome"]][0] == words)
            assert np.allclose(sorted(map(tuple, series(axes, words))) or np.empty((0, 2)),
                               expected or np.empty((0, 2)), rtol=1e-12), outcome
        limits = [[1e3 * float(row["delay_s"]), float(row["stable_N_per_m"])] for row in zones
                  if float(row["rate_Hz"]) == rate]
        assert np.allclose(series(axes, "below, the loop comes to rest by itself"), limits, rtol=1e-12)


def test_levels_of_a_knob_lie_at_their_time_and_error():
    table = pd.DataFrame({
        "knob": "mesh_depth", "title": "mesh", "method": "sphere", "is_default": [0, 1, 0],
        "error_name": "depth", "error_unit": "m", "time_name": "tick", "time_unit": "ns",
        "error": [1e-3, 1e-5, 0.0], "error_low": [8e-4, 8e-6, 0.0], "error_high": [2e-3, 2e-5, 0.0],
        "time": [100.0, 400.0, 900.0], "time_low": [90.0, 380.0, 880.0], "time_high": [110.0, 420.0, 950.0]})
    (axes,) = accuracy.draw(table).axes
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("tick (ns)", "depth (mm)")
    (curve,) = axes.containers
    x, y = curve.lines[0].get_data()
    assert np.allclose(x, [100.0, 400.0, 900.0]) and np.allclose(y[:2], [1.0, 0.01]) and 0 < y[2] < 0.008
    places = dict(zip((text.get_text() for text in axes.get_yticklabels()), axes.get_yticks()))
    assert places["0"] == y[2] and places["1"] == pytest.approx(1.0)
    assert np.allclose(series(axes, "default"), [[400.0, 0.01]])
    whiskers = [bars.get_segments() for bars in curve.lines[2]]
    assert np.allclose([segment[:, 0] for segment in whiskers[0]], [[90, 110], [380, 420], [880, 950]])
    assert np.allclose(whiskers[1][0][:, 1], [0.8, 2.0])


def test_the_accuracy_figure_has_the_measured_main_knobs():
    for path in (BENCHMARKS / "results").glob("*.json"):
        _, _, knobs = result_tables.read_result(path)
        table = pd.DataFrame(accuracy_results.figure_table(knobs))
        figure = accuracy.draw(table)
        shown = [axes.get_title("left") for axes in figure.axes if axes.get_title("left")]
        assert shown == list(table.drop_duplicates("knob")["title"])


def test_the_strategies_lie_at_their_differences_to_a4():
    result = committed("compare/people2005.json")
    table = pd.DataFrame(compare_results.figure_table(result))
    figure = strategies.draw(table.astype({name: float for name in strategies.NUMBERS}))
    for axes, (measure, factor) in zip(figure.axes, (
            ("contact angle", 1.0), ("penetration", 1e3), ("losses of contact", 1.0),
            ("port work", 1e3))):
        rows = [row for row in result["means"] if row["measure"] == measure]
        found = [mark.lines[0].get_xdata()[0] for mark in axes.containers]
        assert np.allclose(found, [factor * (row["minus_a4"] or 0.0) for row in rows], rtol=1e-12)
        assert len(axes.get_yticklabels()) == 13


# Both grounds

def luminance(colour):
    parts = [int(colour[at:at + 2], 16) / 255 for at in (1, 3, 5)]
    red, green, blue = (part / 12.92 if part <= 0.03928 else ((part + 0.055) / 1.055) ** 2.4
                        for part in parts)
    return 0.2126 * red + 0.7152 * green + 0.0722 * blue


def contrast(colour, ground):
    low, high = sorted((luminance(colour), luminance(ground)))
    return (high + 0.05) / (low + 0.05)


def colours_of(body):
    """Those of attributes and styles. Areas, grids and frames, which have an opacity, are left out."""
    body = re.sub(r'<text [^>]*fill="#ffffff"[^>]*>\d</text>', "", body)  # digits in badges
    used = set(re.findall(r"""(?:fill|stroke)=["']([^"']+)["'](?! (?:fill|stroke)-opacity)""", body))
    for style in re.findall(r'style="([^"]*)"', body):
        declared = dict(part.split(":", 1) for part in style.replace(" ", "").split(";") if ":" in part)
        if not {"opacity", "fill-opacity", "stroke-opacity"} & set(declared):
            used |= {declared[name] for name in ("fill", "stroke") if name in declared}
    return {colour for colour in used if colour not in ("none", "currentColor")}


FIGURES = [ROOT / "haptics/proxy/groove.svg", *sorted(BENCHMARKS.glob("results/**/*.svg")),
           *sorted(ROOT.glob("docs/pictures/*.svg"))]


def test_all_committed_figures_are_found():
    assert len(FIGURES) >= 5


@pytest.mark.parametrize("path", FIGURES, ids=lambda path: path.name)
def test_a_figure_is_legible_on_both_grounds(path):
    """It has no ground of its own, and its colours keep a contrast of 4 on both; or its ground is
    light or dark as the reader prefers, and its colours keep the 3 that WCAG 2.1 asks of graphics."""
    text = path.read_text(encoding="utf-8")
    body = text.split("</defs>")[-1] if "</style>" not in text else re.sub(
        r"<style.*?</style>", "", text, flags=re.DOTALL)
    has_grounds = "prefers-color-scheme:dark" in text
    if has_grounds:
        body = re.sub(r'<rect class="ground"[^>]*>', "", body)
    assert not re.search(r"""<rect[^>]*fill=.#ffffff|fill: #ffffff""", body, re.IGNORECASE)
    colours = colours_of(body)
    assert colours and all(re.fullmatch("#[0-9a-f]{6}", colour) for colour in colours), colours
    for colour in colours:
        least = min(contrast(colour, ground) for ground in ("#ffffff", "#131416"))
        assert least >= (3.0 if has_grounds else 4.0), f"{colour} has a contrast of {least:.2f}"
    letters = [float(size) for size in re.findall(r'font-size="([\d.]+)"|font: (?:bold )?([\d.]+)px', text)
               for size in size if size]
    width = float(re.search(r'viewBox="0 0 ([\d.]+)', text)[1])
    assert min(letters) * 700 / width >= 12.0, "letters of 12 px at a width of 700 px"


def test_a_picture_of_the_program_loses_its_ground():
    drawn = on_any_ground('<style>.x{}</style>\n<rect class="palpate-ground" width="9" fill="#ffffff"/>\n'
                          '<path stroke="#D55E00" fill="currentColor" font-size="10"/>'
                          '<path stroke="#80808040"/>', 1.5)
    assert drawn == (f'<path stroke="{TONES["#d55e00"]}" fill="{INK}" font-size="15.00"/>'
                     '<path stroke="#808080" stroke-opacity="0.25"/>')


def test_a_changed_or_missing_figure_is_not_up_to_date(tmp_path):
    path = tmp_path / "groove.svg"
    table = {"steps": 5}
    assert not result_figures.is_drawn(path, "groove", table)
    text = (ROOT / "haptics/proxy/groove.svg").read_text(encoding="utf-8")
    path.write_text(text, encoding="utf-8")
    assert result_figures.is_drawn(path, "groove", table)
    assert not result_figures.is_drawn(path, "groove", {"steps": 6}), "another table"
    path.write_text(text.replace("<path", "<path id='x'", 1), encoding="utf-8")
    assert not result_figures.is_drawn(path, "groove", table), "changed by hand"

"""The page and the figures of `accuracy`: as C++ made them, for real and for made-up knobs."""

import argparse
import copy
import html
import math
import os
import re
from collections import Counter
from xml.etree import ElementTree

import accuracy_cases as cases
import numpy as np
import oracle_cases
import pytest
from markupsafe import Markup
from page_text import tables_of, visible_text

from palpate.analysis import figures
from palpate.analysis.accuracy import command, results, texts
from palpate.analysis.accuracy import figures as drawing
from palpate.analysis.accuracy.axes import LabelPlaces, log_axis
from palpate.analysis.errors import InputError

METRES = {"m": 1.0, "mm": 1e-3, "µm": 1e-6, "nm": 1e-9}
NASTY = "<script>alert(1)</script> & \"quotes\", 'single' commas, `true` \\ @x $y ${z} ?"
# What methods changed since then added to the text.
WHY_NONE = (" None: the quartiles of the level that would be recommended overlap those of the "
            "default.")


def random(seed):
    seed = int(os.environ.get("PALPATE_SEED", seed))
    print(f"PALPATE_SEED={seed}")
    return np.random.default_rng(seed)


def made(folder):
    return command.run(argparse.Namespace(results=folder)).files


@pytest.fixture(scope="module")
def sample(tmp_path_factory):
    """The files of the made-up knobs, and accuracy.json."""
    return made(cases.put("sample", tmp_path_factory.mktemp("sample"))), cases.facts("sample")


@pytest.fixture(scope="module")
def gallery(tmp_path_factory):
    return made(cases.put("gallery", tmp_path_factory.mktemp("gallery")))


def knob(name, case="sample"):
    raw = next(each for each in cases.facts(case)["knobs"] if each["name"] == name)
    return results.knob(copy.deepcopy(raw))


def page_of(tmp_path, case, change):
    content = cases.facts(case)
    content["knobs"] = content["knobs"][:1]
    change(content)
    return made(cases.put(case, tmp_path / "changed", content))["report.html"]


def texts_of(figure):
    """The texts that a figure shows."""
    svg = str(figures.svg(figure, "f", "title"))
    return [html.unescape(text) for text in re.findall(r"<text[^>]*>([^<]*)</text>", svg)]


def check_finite(svg):
    assert not re.search(r"[^A-Za-z](nan|inf)[^A-Za-z]", svg, re.I)


# ---- the pages that C++ made -------------------------------------------------------------------


# Exact ties, 47.05 and 99.35 us: C++ let the last bits of a product decide.
TIES = {f"{rate} | kept | 2 of 2 | 2000 | 0 | {old} µs": f"{rate} | kept | 2 of 2 | 2000 | 0 | {new} µs"
        for rate, old, new in (("1 kHz", "47.1", "47"), ("2 kHz", "99.4", "99.3"))}


@pytest.mark.parametrize("case", ["star", "gallery"])
def test_the_page_says_what_the_page_of_c_plus_plus_said(case, tmp_path, monkeypatch):
    monkeypatch.setattr(drawing, "work_precision", lambda each: (None, None))  # texts alone
    monkeypatch.setattr(figures, "svg", lambda *_: Markup('<svg viewBox="0 0 1 1"></svg>'))
    page = made(cases.put(case, tmp_path))["report.html"]
    old = Counter(line.replace("medians, whiskers", "medians of 21 repeats, whiskers")
                  .replace("the default wins a tie.", "the default wins a tie." + WHY_NONE)
                  for line in cases.old_page(case))
    new = Counter(visible_text(page))
    ties = TIES if case == "star" else {}
    assert set(old - new) == set(ties)
    assert set(ties.values()) <= set(new - old)
    added = [line for line in new - old if line not in ties.values()]
    knobs = cases.facts(case)["knobs"]
    assert len(added) <= 1 + len(knobs)
    assert all(line.startswith(("Each knob at its default", "recommended: ", "no choice"))
               for line in added), added


def knobs_of(table):
    """The knobs of a raw.csv, with the texts of the case star; it does not have the orders."""
    texts_by_name = {each["name"]: each for each in cases.facts("star")["knobs"]}
    header, *lines = table
    knobs = {}
    for line in lines:
        row = dict(zip(header, line))
        raw = knobs.setdefault(row["knob"], texts_by_name[row["knob"]] | {
            "methods": [], "presets": [], "recommended": None})

        def spread(of, row=row):
            names = ("low", "median", "high")
            return row[of + "_median"] and {name: float(row[f"{of}_{name}"]) for name in names}

        level = {"label": row["level"] or row["preset"], "value": float(row["value"] or 0.0),
                 "error": spread("error"), "time": spread("time"), "failure": row["failure"],
                 "iterations": float(row["iterations"] or 0.0), "repeats": int(row["repeats"]),
                 "failures": int(row["failures"]), "at_floor": row["at_floor"] == "1",
                 "on_front": row["on_front"] == "1"}
        if row["preset"]:
            raw["presets"].append(level)
            continue
        if not raw["methods"] or raw["methods"][-1]["name"] != row["method"]:
            raw["methods"].append({"name": row["method"], "order": None, "expected_order": None,
                                   "floor": float(row["floor"]), "levels": []})
        raw["methods"][-1]["levels"].append(level)
        place = {"method": len(raw["methods"]) - 1, "level": len(raw["methods"][-1]["levels"]) - 1}
        raw.update({name: place for name, flag in (("recommended", "recommended"),
                                                   ("default", "is_default")) if row[flag] == "1"})
    return list(knobs.values())


@pytest.mark.parametrize("case", oracle_cases.cases("accuracy", refused=False),
                         ids=lambda case: case.name)
def test_tables_have_the_numbers_of_the_oracle(case, tmp_path, monkeypatch):
    monkeypatch.setattr(drawing, "work_precision", lambda each: (None, None))
    monkeypatch.setattr(figures, "svg", lambda *_: Markup('<svg viewBox="0 0 1 1"></svg>'))
    content = cases.facts("star") | {"knobs": knobs_of(case.csv("raw.csv"))}
    page = made(cases.put("star", tmp_path, content))["report.html"]

    def shown(cell):
        """Without quartiles that look like the median: they differ beyond the digits kept."""
        return re.sub(r"^(\S+)(.*) \[\1, \1\]$", r"\1\2", cell)

    def levels(html):
        tables = [table for table in tables_of(html) if table[0][0] == "level"]
        return [[list(map(shown, row)) for row in table[1:] if len(row) > 3] for table in tables]

    expected = levels(case.text("report.html"))
    assert sum(map(len, expected)) > 20
    assert levels(page) == expected


def test_the_same_results_give_the_same_bytes(gallery, tmp_path):
    assert made(cases.put("gallery", tmp_path)) == gallery


# ---- the page ----------------------------------------------------------------------------------


def test_every_id_is_unique_and_every_reference_resolves(sample):
    page = sample[0]["report.html"]
    ids = re.findall(r"\sid=[\"']([^\"']*)[\"']", page)
    assert len(ids) == len(set(ids)) > 20 * len(sample[1]["knobs"])
    references = re.findall(r"(?:href=[\"']#|url\(#)([^\"')]+)", page)
    assert references and set(references) <= set(ids)


def test_the_page_shows_a_pair_of_diagrams_for_each_knob(sample):
    page = sample[0]["report.html"]
    pairs = re.findall(r'<figure class="work-precision">(.*?)</figure>', page, re.S)
    assert len(pairs) == len(sample[1]["knobs"])
    for pair in pairs:
        shown = re.findall(r"<svg\b.*?</svg>", pair, re.S)
        assert len(shown) == 2
        for svg in shown:
            assert re.match(r'<svg\b[^>]*role="img" aria-label="', svg)
            assert svg.count("<title") == 1
            check_finite(svg)


def test_the_page_lists_every_level_that_failed(sample):
    page, facts = sample[0]["report.html"], sample[1]
    items = [f"{method['name']}, {level['label']}: {level['failures']} of 21 repeats, "
             f"{level['failure']}" for knob in facts["knobs"] for method in knob["methods"]
             for level in method["levels"]
             if level["failures"]]
    assert len(items) == 5
    lines = visible_text(page)
    for item in items:
        assert item in lines
    assert "preset fast: 21 of 21 repeats, leaked: passed a surface" in lines


def test_the_page_loads_no_other_file(sample):
    page = sample[0]["report.html"]
    for name in ("http://www.w3.org/2000/svg", "http://www.w3.org/1999/xlink"):
        page = page.replace(name, "")
    for word in ("http:", "https:", "//www", "<script", "<iframe", "<img", "@import", "src=",
                 "javascript:", "<?xml"):
        assert word not in page
    assert '<meta charset="utf-8">' in page and 'name="viewport"' in page


def test_names_are_shown_as_text(sample, tmp_path):
    page = sample[0]["report.html"]
    assert "<script" not in page and "\ufffd" not in page
    assert "&lt;script&gt;alert(1)&lt;/script&gt; &amp; &#34;quotes&#34;" in page

    def change(content):
        content["facts"] = [{"name": "machine <b>", "value": "a & b"}]
        content["scene"]["name"] = "a<b>.glb"
        content["scene"]["surfaces"][0]["name"] = '<script>"x"'
        content["scene"]["kept_rate"]["realtime_note"] = "<i>"
        content["advice"]["answers"][0]["reason"] = "<u>"
        content["advice"]["command"] = ["palpate", "'a <b>.glb'"]

    page = page_of(tmp_path, "gallery", change)
    for tag in ("<script", "<i>", "<b>", "<u>"):
        assert tag not in page, tag
    lines = visible_text(page)
    assert "Your scene: a<b>.glb" in lines and "palpate 'a <b>.glb'" in lines
    assert "<dt>machine &lt;b&gt;</dt><dd>a &amp; b</dd>" in page


def test_names_are_drawn_as_they_are(sample):
    name = NASTY[:24]
    for panel in drawing.work_precision(knob("hostile")):
        shown = texts_of(panel)
        assert any(text.startswith(name) for text in shown), shown
    raw = cases.facts("sample")["knobs"][0]
    raw["methods"][0]["name"], raw["methods"][1]["name"] = r"$x_1$", r"\frac{a}{b}"
    raw["error"]["name"], raw["time"]["name"] = "50 % %g", "<b>&amp;</b>"
    raw["methods"][1]["levels"][5]["label"] = "a_b^{c} µ 10⁻⁶"
    shown = texts_of(drawing.work_precision(results.knob(raw))[0])
    assert {r"$x_1$", r"\frac{a}{b}"} <= set(shown), "in the legend"
    assert {"50 % %g (µm)", "<b>&amp;</b> (µs)"} <= set(shown), "at the axes"
    assert "a_b^{c} µ 10⁻⁶ (default)" in shown, "at its level"


def test_the_page_states_why_a_default_is_not_on_the_front(sample):
    page, mesh = "\n".join(visible_text(sample[0]["report.html"])), sample[1]["knobs"][0]
    assert not mesh["default_on_front"]
    assert f"not on the front: {mesh['better_than_default']}" in page
    assert f"Why it is the default: {mesh['default_because']}" in page
    assert "It is the quickest with an error of at most 1 µm" in page


def test_floor_and_orders_are_in_the_table(sample):
    lines = visible_text(sample[0]["report.html"])
    assert any("explicit Euler, order 1.00 (theory 1), floor 1e-15 m" in line for line in lines)
    assert '<span class="mark warn">floor</span>' in sample[0]["report.html"]
    assert any(line.startswith("Floor: Round-off") for line in lines)
    assert any("Open points are at the floor." in line for line in lines)


def test_the_page_begins_with_the_advice_and_ends_with_the_facts(sample):
    page = sample[0]["report.html"]
    places = [page.index(text) for text in (
        '<section class="answer" id="advice">', '<figure class="overview"',
        "Each knob of the engine", "<details", '<section id="facts">')]
    assert places == sorted(places)
    assert "<details" not in page[places[-1]:]
    box = page[places[0]:places[1]]
    for answer in sample[1]["advice"]["answers"]:
        value = html.escape(answer["value"])
        assert f"<dt>{answer['setting']}</dt><dd><strong>{value}</strong>" in box
    assert "palpate run models/sphere.glb --fit auto --virtual" in "\n".join(visible_text(box))


def test_the_box_says_whether_the_machine_was_busy(sample, tmp_path):
    assert "busy" not in "\n".join(visible_text(sample[0]["report.html"]))
    page = page_of(tmp_path, "sample",
                   lambda content: content["advice"].update(busy="It was busy."))
    assert page.index('id="advice"') < page.index("It was busy.") < page.index("</section>")


def test_the_page_says_whether_the_delay_is_stated(sample, gallery):
    assert "No delay is stated" in sample[0]["report.html"]
    assert "No delay is stated" not in gallery["report.html"]
    assert "K 1 kN/m is calm only by the controller" in gallery["report.html"]


def test_a_page_without_a_knob_and_without_a_scene_is_made(tmp_path):
    def change(content):
        content["knobs"] = []

    page = page_of(tmp_path, "sample", change)
    assert "Summary of the knobs" not in page and "Your scene" not in page
    assert 'id="advice"' in page and 'id="facts"' in page


# ---- figures -----------------------------------------------------------------------------------


def test_a_diagram_is_well_formed_and_has_both_panels(sample):
    for raw in sample[1]["knobs"]:
        svg = sample[0][f"{raw['name']}.svg"]
        root = ElementTree.fromstring(svg)
        shown = "".join(root.itertext())
        assert "error against time" in shown
        assert "error against level" in shown or "time against level" in shown
        assert "prefers-color-scheme:dark" in svg and "currentColor" in svg
        check_finite(svg)


def test_axes_have_names_and_units():
    time, level = drawing.work_precision(knob("mesh_depth"))
    assert {"depth error (µm)", "time of a tick (µs)"} <= set(texts_of(time))
    assert {"depth error (µm)", "edge length (mm)"} <= set(texts_of(level))
    time, _ = drawing.work_precision(knob("integrator"))
    assert "computing for a second of contact (ms)" in texts_of(time)


def test_floor_order_presets_and_failures_are_named():
    time, level = map(texts_of, drawing.work_precision(knob("integrator")))
    assert {"floor", "explicit Euler (2 failed)", "Runge-Kutta 4 (1 failed)", "preset exact",
            "recommended"} <= set(time)
    assert "preset fast" not in time, "it failed"
    assert {"Runge-Kutta 4: order 4.00 (theory 4)", "floor"} <= set(level)


def test_the_slope_of_each_expected_order_is_drawn():
    def dashed(each):
        svg = str(figures.svg(drawing.work_precision(each)[1], "f", "t"))
        return svg.count("stroke-dasharray")

    without = knob("integrator")
    with_orders = dashed(without)
    for method in without.facts["methods"]:
        method["expected_order"] = None
    assert with_orders - dashed(without) == 3, "two methods and the legend"


def test_points_whiskers_and_the_front_are_where_the_numbers_are():
    each = knob("mesh_depth")
    ax = drawing.work_precision(each)[0].axes[0]
    sphere = each.levels[each.levels["method"] == 1]
    points = [line for line in ax.lines if line.get_marker() == "s" and len(line.get_xdata()) > 2]
    drawn = np.vstack([line.get_xydata() for line in points])
    expected = np.column_stack([np.log10(sphere["time"] * 1e-3), np.log10(sphere["error"] * 1e6)])
    np.testing.assert_allclose(np.sort(drawn, axis=0), np.sort(expected, axis=0), rtol=1e-12)
    across = ax.collections[2].get_segments()  # of the second method
    ends = np.log10(sphere[["time_low", "time_high"]].to_numpy() * 1e-3)
    np.testing.assert_allclose(np.array(across)[:, :, 0], ends, rtol=1e-12)


def test_a_knob_without_a_successful_level_is_drawn():
    raw = cases.facts("sample")["knobs"][1]
    levels = [level for method in raw["methods"] for level in method["levels"]]
    for level in levels + raw["presets"]:
        level.update(error=None, time=None, iterations=None, failures=21, failure="no",
                     at_floor=False, on_front=False)
    raw["recommended"] = None
    each = results.knob(raw)
    for figure in drawing.work_precision(each):
        check_finite(str(figures.svg(figure, "f", "t")))
    assert texts.recommendation(each) == "none: every level failed"
    assert drawing.overview_table([each]).empty


def test_extreme_numbers_are_drawn():
    rng = random(20261)

    def number():
        return 10.0 ** rng.uniform(-300.0, 300.0)

    def spread(values):
        low, median, high = np.quantile(values, [0.25, 0.5, 0.75])
        return {"low": low, "median": median, "high": high}

    for _ in range(3):
        raw = cases.facts("sample")["knobs"][0]
        for level in [level for method in raw["methods"] for level in method["levels"]]:
            level["value"] = 0.0 if rng.integers(4) == 0 else number()
            level["error"] = spread([number(), 0.0 if rng.integers(4) == 0 else number(), number()])
            level["time"] = spread([number(), number(), -number()])
            level["label"] = "x" * rng.integers(60)
        for figure in drawing.work_precision(results.knob(raw)):
            check_finite(str(figures.svg(figure, "f", "t")))


def test_the_overview_compares_with_what_is_small_enough_and_with_the_default():
    each = knob("mesh_depth")
    row = drawing.overview_table([each]).iloc[0]
    default, best = each.row("default"), each.row("recommended")
    assert row["error_default"] == default["error"] / 1e-6
    assert row["error_best_high"] == best["error_high"] / 1e-6
    assert row["time_best"] == best["time"] / default["time"]
    assert (row["time_default"], row["is_default"]) == (1.0, False)
    shown = texts_of(drawing.overview(drawing.overview_table([each, knob("integrator")])))
    assert {"Mesh resolution", "Integrator", "default", "recommended"} <= set(shown)


def test_the_caption_of_the_overview_names_a_band_where_there_is_one(sample, gallery):
    def caption(page):
        return re.search(r"<figcaption>(Each knob at its default.*?)</figcaption>", page)[1]

    assert "n = 7 knobs that offer a choice. A grey band" in caption(sample[0]["report.html"])
    assert caption(gallery["report.html"]).endswith("n = 5 knobs that offer a choice.")


def test_whiskers_wider_than_the_effect_recommend_nothing():
    raw = cases.facts("sample")["knobs"][0]
    raw["undecided"], raw["recommended"] = raw["recommended"], None
    each = results.knob(raw)
    level = each.row("undecided")
    assert texts.recommendation(each).startswith(
        f"none: {texts.place(each, level)} ({texts.error(each, level)}, ")
    assert "overlap within their quartiles" in texts.recommendation(each)
    time, _ = drawing.work_precision(each)
    assert "recommended" not in texts_of(time)
    assert drawing.overview_table([each]).empty


# ---- axes and labels ---------------------------------------------------------------------------


def test_an_axis_shows_zero_below_all_positive_values():
    axis = log_axis([1e-6, 0.0, 1e-3], [], "m")
    low, zero, high = axis.at([1e-6, 0.0, 1e-3])
    assert axis.low < zero < axis.band < low
    assert high == pytest.approx(math.log10(1e-3 * axis.factor), abs=1e-12)
    assert (zero, "0") in axis.ticks


def test_ticks_are_where_their_labels_say():
    rng = random(20262)
    checked = 0
    for _ in range(2000):
        low = 10.0 ** rng.uniform(-12.0, 3.0)
        high = low * 10.0 ** rng.uniform(0.0, 3.0)
        axis = log_axis([low, high], [], "m")
        labelled = [tick for tick in axis.ticks if tick[1]]
        assert all(axis.low <= position <= axis.high for position, _ in axis.ticks)
        assert 2 <= len(labelled) <= 12, (low, high)
        for position, label in labelled:
            if not re.fullmatch(r"[\d.e-]+", label):
                continue  # a power of ten with a superscript
            checked += 1
            assert math.log10(float(label)) == pytest.approx(position, abs=0.0022)  # three digits
            assert axis.factor * METRES[axis.unit] == pytest.approx(1.0, rel=1e-12)
    assert checked > 5000


def test_no_label_covers_another_or_leaves_the_area():
    rng = random(20263)
    for _ in range(100):
        places = LabelPlaces(300.0, 200.0)
        places.block(np.array([[150.0, 100.0]]), 6.0)
        for _ in range(30):
            point = rng.uniform((0.0, 0.0), (300.0, 200.0))
            places.take_beside(point, "x" * rng.integers(2, 14), 10.0, 9.0, True)
        boxes = places.taken
        assert len(boxes) > 4
        assert (boxes[:, :2] >= 0.0).all() and (boxes[:, 2:] <= (300.0, 200.0)).all()
        overlap = ((boxes[:, None, :2] < boxes[None, :, 2:]).all(axis=2)
                   & (boxes[None, :, :2] < boxes[:, None, 2:]).all(axis=2))
        assert overlap.sum() == len(boxes), "each with itself alone"


# ---- refused -----------------------------------------------------------------------------------


@pytest.mark.parametrize("content, problem", [
    ("{", "is not JSON"), ("[]", "is not palpate-accuracy-1"),
    ('{"format": "x"}', "measure again")])
def test_another_file_is_refused(content, problem, tmp_path):
    folder = cases.put("sample", tmp_path)
    (folder / "accuracy.json").write_text(content)
    with pytest.raises(InputError, match=problem) as error:
        made(folder)
    assert str(error.value).startswith(str(folder / "accuracy.json"))


def test_a_missing_file_is_refused(tmp_path):
    with pytest.raises(InputError, match="cannot be read: No such file"):
        made(tmp_path)


def test_a_name_that_leads_out_of_the_folder_is_refused(tmp_path):
    with pytest.raises(InputError, match="lower-case letters"):
        page_of(tmp_path, "sample", lambda content: content["knobs"][0].update(name="../x"))


@pytest.mark.parametrize("change", [
    ("<path ", '<path onclick="x()" '), ("<circle ", "<script>x()</script><circle "),
    ("<path ", '<path style="background:url(http://a)" '), ("</svg>", ""), ("<svg x=", "<g x=")])
def test_a_chart_that_could_run_something_is_refused(change, tmp_path):
    folder = cases.put("sample", tmp_path)
    path = folder / "stiffness.svg"
    path.write_text(path.read_text(encoding="utf-8").replace(*change), encoding="utf-8")
    with pytest.raises(InputError, match="is not the chart"):
        made(folder)

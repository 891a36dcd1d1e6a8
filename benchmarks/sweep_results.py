"""The table and the figure of the sweep over our assumptions: whether A4 helps.

For each measure in the condition UaH whose share is not 0 or 1, and for each assumption that the sweep
varies, the figure has the share of the hypercube's testable points at which the measure is smaller with
A4: in the low and in the high half of the assumption, or at each of its words. measure_sweep.py writes
the data.
"""

import json
import math

import result_tables as tables
from result_tables import BadInput

# The measure, and the name of its ranking.
MEASURES = [("contact angle", "mean contact angle, Rotation"),
            ("time", "total time, A4 in UaH"),
            ("losses", "losses of contact, A4 in UaH"),
            ("penetration", "mean penetration, A4 in UaH")]
# Words of each assumption, in the order of the tables.
ASSUMPTIONS = {
    "sight_delay_s": "delay of sight",
    "intention_noise_m": "noise of the aim",
    "force_noise": "noise of the force",
    "press_depth_m": "depth of pressing",
    "hand_stiffness_N_per_m": "stiffness of hand",
    "speed_m_per_s": "speed",
    "stiffness_N_per_m": "stiffness of device",
    "comfortable_depth_m": "slowing depth",
    "following": "following the turn",
    "align": "end of motor line",
    "start_orientation_deg": "start orientation",
    "scale": "size of objects",
}
HALVES = ("low half", "high half")


def read(folder):
    path = folder / "sweep.json"
    try:
        return json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise BadInput(f"{path}: expected a result of measure_sweep.py ({error!r})") from error


def percent(share):
    """Shares that are not 1 or 0 are not rounded to them."""
    text = f"{math.floor(100 * share + 0.5)} %"
    if text == "100 %" and share < 1.0:
        return "> 99 %"
    return "< 1 %" if text == "0 %" and share > 0.0 else text


def ranking(data, name):
    return next(row for row in data["rankings"] if row["ranking"] == name)


def parts(data, name, parameter):
    return [row for row in data["halves"] if row["ranking"] == name and row["parameter"] == parameter]


def decisive(row):
    return (row["decisive_parameters"] or "").split()


def drawn(data):
    """The measures with a panel: whose share is neither 0 nor 1."""
    return [(words, name) for words, name in MEASURES
            if 0 < ranking(data, name)["holds"] < ranking(data, name)["points"]]


def answer(data):
    """Lines: where A4 helps."""
    lines = ["With the force of one motor (UaH), A4 makes smaller the"]
    for words, name in MEASURES:
        row = ranking(data, name)
        line = f"- {words} at {row['holds']} of {row['points']} testable points"
        if row["untestable"]:
            line += f" ({row['untestable']} are not)"
        lines.append(line)
    return lines


def shares_of(data, words, name):
    """The rows of a measure in the figure."""
    decides = decisive(ranking(data, name))
    return [{"measure": words, "assumption": ASSUMPTIONS[parameter],
             "part": row["part"] if row["part"] in HALVES else "word", "share": row["share"],
             "decides": int(parameter in decides)}
            for parameter in ASSUMPTIONS for row in parts(data, name, parameter)
            if row["share"] is not None]


def figure_table(data):
    """What palpate.analysis.results.a4_helps draws."""
    measures = drawn(data)
    return {"shares": [row for words, name in measures for row in shares_of(data, words, name)],
            "measures": [{"measure": words, **{key: ranking(data, name)[key]
                                               for key in ("share", "low", "high")}}
                         for words, name in measures],
            "notes": answer(data) + notes_of(data)}


def notes_of(data):
    """Lines below the figure, after the answer."""
    untestable = max(ranking(data, name)["untestable"] for _, name in MEASURES)
    text = ["Dashed: all points, with Wilson's 95 % interval. A coin gives 50 %."]
    if untestable:
        text.append("Not testable: nobody completed the trials there.")
    text.append("Shares are of our ranges of simulated hands, not of people.")
    return text


def decided_by(row):
    if row["p"] is None:
        return "none"
    names = ", ".join(f"`{name}`" for name in decisive(row))
    return (names or "none beyond chance") + f" (p = {row['p']:.2g})"


def share_text(row):
    if row["share"] is None:
        return "-"
    return f"{percent(row['share'])} ({100 * row['low']:.0f} to {percent(row['high'])})"


def parts_lines(data):
    """A list: of each ranking that a parameter decides, the share in each part of this parameter."""
    lines = []
    for row in data["rankings"]:
        for name in decisive(row) if row["p"] is not None else []:
            shares = ", ".join(f"{of['part']} " + ("not testable" if of["share"] is None else
                                                   f"{percent(of['share'])} of {of['points']}")
                               for of in parts(data, row["ranking"], name))
            lines.append(f"- {row['ranking']}, `{name}`: {shares}.")
    return lines


def table(data):
    """Each ranking, where it holds, and what decides most."""
    rows = [(f"{row['ranking']}: {row['order']}",
             [f"{row['holds']} of {row['points']}", share_text(row), str(row["untestable"]),
              decided_by(row)]) for row in data["rankings"]]
    counts = data["counts"]
    lines = parts_lines(data)
    if lines:
        lines = ["Share of the testable points in each part of the parameter that decides most:", "",
                 *lines, ""]
    return tables.markdown(["ranking", "holds at", "share", "not testable", "what decides most"],
                           rows) + "\n\n" + "\n".join(lines) + (
        f"\n{data['points']['hypercube']} points of the hypercube; {counts['trials']} trials in all, "
        f"{counts['trials'] - counts['done']} of which did not end at the red sphere.")


def made(folder, make):
    try:
        return make(read(folder))
    except (KeyError, StopIteration, TypeError) as error:
        raise BadInput(f"{folder}: expected sweep.json of measure_sweep.py ({error!r})") from error


def figure_of(folder):
    return made(folder, figure_table)


def block(folder):
    return made(folder, table)

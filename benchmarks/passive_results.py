"""The table and the figure of the budgets of a4-passive."""

import json

import result_tables as tables
import svg
from result_tables import BadInput

NAME = "a4_passive.json"
PREFIX = "a4-passive:"
# Name of the column, measure, factor and format.
GROUPS = [
    [("penetration", "penetration", 1e3, "%.2f mm"),
     ("contact angle", "contact angle", 1, "%.1f deg"),
     ("missing force", "missing force", 1, "%.2f N")],
    [("energy of turning", "energy of turning", 1e3, "%.0f mJ"),
     ("port work", "port work", 1e3, "%.0f mJ"),
     ("work along the wall", "work along the wall", 1e3, "%.0f mJ"),
     ("work of one contact", "work of one contact", 1e3, "%.0f mJ")],
]
WIDTH, HEIGHT = 760, 330
LEFT, RIGHT, TOP, BOTTOM = 70, 190, 24, 46
TEXT = 14


def read(folder):
    """The result, as measure_passive_budgets.py wrote it."""
    path = folder / NAME
    try:
        result = json.loads(path.read_text(encoding="utf-8"))
        block(result)
        draw(result)
    except (OSError, ValueError, KeyError, TypeError, ZeroDivisionError) as error:
        raise BadInput(f"{path}: expected a result of measure_passive_budgets.py ({error!r})") from error
    return result


def means_of(result, measure):
    """{strategy: mean}."""
    return {row["strategy"]: row["mean"] for row in result["means"] if row["measure"] == measure}


def strategies_of(result):
    """mask, the budgets in their order, and a4, which has no limit."""
    budgets = [name for name in means_of(result, "penetration") if name.startswith(PREFIX)]
    return ["mask", *budgets, "a4"]


def gains(result):
    """{strategy: part of a4's gain in penetration over mask}."""
    means = means_of(result, "penetration")
    whole = means["mask"] - means["a4"]
    return {name: (means["mask"] - mean) / whole for name, mean in means.items()}


def rounded(pattern, value):
    """Without the sign of a value that rounds to zero."""
    text = pattern % value
    return text.lstrip("-") if float(text.split()[0]) == 0.0 else text


def block(result):
    share = gains(result)
    parts = []
    for group in GROUPS:
        with_gain = group is GROUPS[0]
        rows = []
        for name in strategies_of(result):
            cells = [rounded(pattern, factor * means_of(result, measure)[name])
                     for _, measure, factor, pattern in group]
            if with_gain:
                cells.insert(1, "%.0f %%" % (100 * share[name]))
            rows.append((f"`{name}`", cells))
        titles = [title for title, *_ in group]
        if with_gain:
            titles.insert(1, "gain")
        parts.append(tables.markdown([f"mean of {result['hands']} hands", *titles], rows))
    return "\n\n".join(parts)


def draw(result):
    """The gain and the energy of turning as shares of those of a4, over the budget."""
    energies = means_of(result, "energy of turning")
    budgets = [(float(name[len(PREFIX):]), name) for name in strategies_of(result)
               if name.startswith(PREFIX)]
    most = max(budget for budget, _ in budgets)
    curves = (("gain in penetration", svg.BLUE, gains(result)),
              ("energy of turning", svg.RED,
               {name: energy / energies["a4"] for name, energy in energies.items()}))
    picture = svg.Drawing(WIDTH, HEIGHT, "The part of A4's gain in penetration over mask, and of the "
                          "energy that its turns add, over the budget of a4-passive.")

    def place(budget, share):
        return (LEFT + budget / most * (WIDTH - LEFT - RIGHT),
                HEIGHT - BOTTOM - share * (HEIGHT - TOP - BOTTOM))

    for percent in (0, 25, 50, 75, 100):
        y = place(0.0, percent / 100)[1]
        picture.line([(LEFT, y), (WIDTH - RIGHT, y)], svg.FAINT)
        picture.text((LEFT - 8, y + 5), f"{percent} %", TEXT, anchor="end")
    for budget, _ in budgets:
        x, y = place(budget, 0.0)
        picture.text((x, y + 20), f"{budget:g}", TEXT, anchor="middle")
    picture.text(((LEFT + WIDTH - RIGHT) / 2, HEIGHT - 6), "budget of a contact, mJ", TEXT,
                 anchor="middle")
    for title, colour, shares in curves:
        points = [place(budget, shares[name]) for budget, name in budgets]
        picture.line(points, colour, 2)
        for point in points:
            picture.circle(point, 4, colour)
        picture.text((points[-1][0] + 12, points[-1][1] + 5), title, TEXT, colour)
    return picture.svg()

"""What a budget of a4-passive costs: shares of A4's gain and of its energy, over the budget."""

from __future__ import annotations

import pandas as pd
from matplotlib.figure import Figure

from palpate.analysis import figures
from palpate.analysis.results.picture import WIDTH_PX

TITLE = ("The part of A4's gain in penetration over mask, in presses and on ways, and of the energy "
         "that its turns add, over the budget of a4-passive")


def draw(table: pd.DataFrame) -> Figure:
    """table: curve, budget_mJ, share (of that of a4). The budgets are at equal distances."""
    figure, axes = figures.new_figure(WIDTH_PX, 330)
    budgets = list(table["budget_mJ"].unique())
    for number, (curve, rows) in enumerate(table.groupby("curve", sort=False)):
        axes.plot([budgets.index(budget) for budget in rows["budget_mJ"]], 100 * rows["share"],
                  color=figures.COLOURS[number], marker=figures.MARKERS[number], label=curve)
    axes.set_xticks(range(len(budgets)), [f"{budget:g}" for budget in budgets])
    axes.set_ylim(-4, 104)
    axes.set_xlabel("budget of a contact, mJ")
    axes.set_ylabel("share of that of a4, %")
    axes.legend(loc="upper left")
    return figure

"""What each strategy differs from A4, by four measures: the figure of a comparison as one picture."""

from __future__ import annotations

import pandas as pd
from matplotlib.figure import Figure

from palpate.analysis import figures
from palpate.analysis.results.picture import WIDTH_PX
from palpate.analysis.strategies.differences_figure import SHOWN, baseline, draw_differences

TITLE = ("Paired differences of each strategy to A4 with their 95 % intervals, by contact angle, "
         "penetration, losses of contact and port work")
NUMBERS = ("mean", "half_width", "minus_mask", "mask_half_width", "minus_a4", "a4_half_width")


def draw(table: pd.DataFrame) -> Figure:
    """A panel for each measure.

    table: measure, strategy, role, mean, half_width, minus_mask, mask_half_width, minus_a4 and
    a4_half_width, as the rows of Comparison.means.
    """
    other = baseline(table)
    figure, axes = figures.new_figure(WIDTH_PX, 640, nrows=2, ncols=2)
    for panel, measure in zip(axes.flat, SHOWN):
        draw_differences(panel, table[table["measure"] == measure], other)
    return figure

"""Figures 6 and 7 of the paper, one picture each, with the paper's means beside those of trials."""

from __future__ import annotations

from matplotlib.figure import Figure

from palpate.analysis.figures import new_figure

from . import plots
from .analysis import OperatorAnalysis
from .outcomes import LOSSES, PENETRATION, TIME

FIGURE_6 = (TIME, LOSSES, PENETRATION)


def figure_6(each: OperatorAnalysis) -> Figure:
    """Total time, losses of contact and mean penetration at each level of Haptic, one curve for
    each level of Rotation, below each other. Whiskers: 95 % intervals within participants
    (Cousineau-Morey); grey: the paper's people, over both rotations.

    Raises ValueError if no participant has completed trials in all conditions.
    """
    figure, panels = new_figure(plots.WIDTH, len(FIGURE_6) * plots.HEIGHT, nrows=len(FIGURE_6))
    for axes, outcome in zip(panels, FIGURE_6):
        means = each.primary[outcome].means
        means = means[(means[["Haptic", "Rotation"]] != "all").all(axis=1)]
        if means.empty:
            raise ValueError("no participant has completed trials in all conditions")
        plots.draw_by_rotation_and_haptic(axes, means, outcome, each.experiment.levels,
                                          each.whose_trials)
    return figure


def figure_7(each: OperatorAnalysis) -> Figure:
    """The mean contact angle of UaH without and with rotation. Whiskers: 95 % intervals within
    participants (Cousineau-Morey); grey: the paper's people, with standard deviations.

    Raises ValueError if the trials do not have the contact angle of a participant in both.
    """
    if each.angle_of_uah is None or each.angle_of_uah.means.empty:
        raise ValueError("no participant has a contact angle of UaH in both rotations")
    whose = "simulated operators" if each.experiment.is_simulated else "people of this file"
    return plots.angle_by_rotation(each.angle_of_uah.means, each.whose_trials,
                                   f"{whose}, 95 % interval")

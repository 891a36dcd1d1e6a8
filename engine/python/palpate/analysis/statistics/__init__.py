"""The statistics of the pages: what statsmodels and SciPy lack, on top of NumPy and SciPy.

Arrays may have leading axes (`...`): each function then answers for every data set of a stack at
once. A value that the data do not determine is NaN.
"""

from .comparisons import PairedT, fisher_plsd, holm, paired_t, standardized
from .distributions import (
    f_for_tail,
    f_tail,
    t_for_coverage,
    t_tail,
    t_two_sided,
    z_for_coverage,
)
from .factorial import Design, DesignError, FixedEffect, Fit, Wilks, rao
from .intervals import (
    COVERAGE,
    SIGNIFICANCE,
    MeanInterval,
    clopper_pearson,
    cousineau_morey,
    mean_interval,
    wilson,
)
from .nested import MOST_CELLS, Parts, parts_of_variance
from .ranks import Friedman, SignedRank, friedman, signed_rank
from .repeated import RepeatedEffect, RepeatedMeasures, repeated_measures, repeated_measures_of
from .terms import Term, all_terms, effect_name

__all__ = [
    "COVERAGE", "MOST_CELLS", "SIGNIFICANCE", "Design", "DesignError", "Fit", "FixedEffect",
    "Friedman", "MeanInterval", "PairedT", "Parts", "RepeatedEffect", "RepeatedMeasures",
    "SignedRank", "Term", "Wilks", "all_terms", "clopper_pearson", "cousineau_morey", "effect_name",
    "f_for_tail", "f_tail", "fisher_plsd", "friedman", "holm", "mean_interval", "paired_t",
    "parts_of_variance", "rao", "repeated_measures", "repeated_measures_of", "signed_rank",
    "standardized", "t_for_coverage", "t_tail", "t_two_sided", "wilson", "z_for_coverage",
]  # fmt: skip

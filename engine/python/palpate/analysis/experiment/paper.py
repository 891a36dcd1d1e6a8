"""The numbers and the findings of the paper (Lécuyer, Burkhardt, Le Biller and Congedo, 2005)."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from itertools import pairwise

from palpate.analysis.numbers import as_printed
from palpate.analysis.statistics import Term, effect_name, t_for_coverage

from .outcomes import ANGLE, LOSSES, PENETRATION, TIME, Outcome

H: Term = ("Haptic",)
R: Term = ("Rotation",)
O: Term = ("Object",)
T: Term = ("Trial",)
RH: Term = ("Haptic", "Rotation")
OH: Term = ("Haptic", "Object")
OR: Term = ("Rotation", "Object")

# The lines of the MANOVA: lambda (three digits), F, df2.
MANOVA: dict[Term, tuple[float, float, float]] = {
    H: (0.236, 228.207, 1292.0),
    R: (0.925, 17.486, 646.0),
    O: (0.110, 257.433, 1572.3),
    T: (0.925, 8.590, 1292.0),
    RH: (0.911, 10.271, 1292.0),
    OH: (0.868, 5.227, 1827.6),
    OR: (0.934, 4.964, 1572.3),
}

# F with 648 error degrees of freedom (of the contact angle: 9), and p where the paper states more
# than "significant".
F: dict[tuple[Outcome, Term], tuple[float, str]] = {
    (TIME, H): (12.141, ""),
    (TIME, R): (29.674, ""),
    (TIME, RH): (0.433, "n.s."),
    (LOSSES, H): (19.139, ""),
    (LOSSES, R): (22.389, ""),
    (LOSSES, RH): (2.608, "p < .07"),
    (PENETRATION, H): (836.377, ""),
    (PENETRATION, R): (0.845, "n.s."),
    (PENETRATION, RH): (22.859, ""),
    (ANGLE, R): (162.31, ""),
}
ERROR_DF, ANGLE_ERROR_DF = 648, 9

# Mean and standard deviation at a level. Contact angles are those of UaH.
MEANS: dict[tuple[Outcome, str], tuple[float, float]] = {
    (TIME, "NoH"): (29.0, 15.0),
    (TIME, "UaH"): (27.5, 15.0),
    (TIME, "H"): (25.0, 13.0),
    (TIME, "NoR"): (25.14, 12.041),
    (TIME, "R"): (29.15, 15.972),
    (LOSSES, "NoH"): (24.0, 11.0),
    (LOSSES, "UaH"): (22.0, 11.0),
    (LOSSES, "H"): (21.0, 10.0),
    (LOSSES, "NoR"): (22.0, 10.0),
    (LOSSES, "R"): (23.0, 12.0),
    (PENETRATION, "NoH"): (0.101, 0.031),
    (PENETRATION, "UaH"): (0.068, 0.023),
    (PENETRATION, "H"): (0.031, 0.008),
    (PENETRATION, "NoR"): (0.067, 0.035),
    (PENETRATION, "R"): (0.066, 0.038),
    (ANGLE, "NoR"): (49.4, 3.0),
    (ANGLE, "R"): (32.1, 5.0),
}


TRIALS = 720
HAPTIC_LEVELS, ROTATION_LEVELS = ("NoH", "UaH", "H"), ("NoR", "R")


@dataclass(frozen=True)
class Effect:
    """A difference of two means with its 95 % interval."""

    difference: float
    low: float
    high: float


def difference(outcome: Outcome, higher: str, lower: str) -> Effect:
    """The paper's difference of the means at two levels of one factor.

    The standard error comes from F: of two levels it is the difference divided by sqrt(F); of
    three, sqrt(2 MSE / n) with MSE = MS of the printed means / F. As in the paper, trials are
    independent.
    The interval has room for the rounding of the printed means.
    """
    rounding = sum(_half_unit(MEANS[outcome, level][0]) for level in (higher, lower))
    d = MEANS[outcome, higher][0] - MEANS[outcome, lower][0]
    if higher in ROTATION_LEVELS:
        f = F[outcome, R][0]
        half = float(t_for_coverage(ANGLE_ERROR_DF if outcome is ANGLE else ERROR_DF)) / f**0.5
        return Effect(d, (d - rounding) * (1.0 - half), (d + rounding) * (1.0 + half))
    means = [MEANS[outcome, level][0] for level in HAPTIC_LEVELS]
    n = TRIALS / len(means)
    mean = sum(means) / len(means)
    mean_square = n * sum((m - mean) ** 2 for m in means) / (len(means) - 1.0)
    error = (2.0 * mean_square / F[outcome, H][0] / n) ** 0.5
    half = float(t_for_coverage(ERROR_DF)) * error + rounding
    return Effect(d, d - half, d + half)


def _half_unit(value: float) -> float:
    """Half a unit of the last printed digit."""
    return 0.5 * 10.0 ** -len(as_printed(value).partition(".")[2])


def equivalence_margin(outcome: Outcome) -> float:
    """Half of the smallest difference of means that the paper calls significant in a measure."""
    pairs = [
        pair
        for finding in FINDINGS
        if finding.outcome is outcome and finding.claim is Claim.ORDER
        for pair in pairwise(finding.ascending)
    ]
    differences = [difference(outcome, higher, lower).difference for lower, higher in pairs]
    return 0.5 * min(differences)


class Claim(Enum):
    ORDER = "significant, with means in this order"
    EFFECT = "significant; the paper's text does not state the means"
    NO_EFFECT = "not significant"
    MULTIVARIATE = "significant in the MANOVA"


@dataclass(frozen=True)
class Finding:
    """A finding of the paper; the statement is about people."""

    outcome: Outcome | None  # None: of the MANOVA
    term: Term
    claim: Claim
    statement: str
    ascending: tuple[str, ...] = ()  # levels by ascending mean, of Claim.ORDER

    @property
    def effect(self) -> str:
        return effect_name(self.term)

    @property
    def name(self) -> str:
        """ "total time, Haptic"."""
        return f"{self.outcome.name if self.outcome else 'MANOVA'}, {self.effect}"

    @property
    def printed(self) -> str:
        """ "F(2, 648) = 12.141; H 25, UaH 27.5, NoH 29 s"."""
        if self.outcome is None:
            return "lambda = {:.3f}, F = {:.3f}".format(*MANOVA[self.term])
        f, p = F[self.outcome, self.term]
        df1 = 1 if self.term == R else 2
        is_angle = self.outcome is ANGLE
        text = f"F({df1}, {ANGLE_ERROR_DF if is_angle else ERROR_DF}) = "
        text += f"{f:.2f}" if is_angle else f"{f:.3f}"
        text += f", {p}" if p else ""
        means = [(level, MEANS[self.outcome, level][0]) for level in self.ascending]
        if not means:
            return text
        order = ", ".join(f"{level} {as_printed(mean)}" for level, mean in means)
        return f"{text}; {order} {self.outcome.unit}".rstrip()


_H_UAH_NOH, _NOR_R = ("H", "UaH", "NoH"), ("NoR", "R")

FINDINGS: tuple[Finding, ...] = (
    Finding(TIME, H, Claim.ORDER, "H is quickest, then UaH, then NoH", _H_UAH_NOH),
    Finding(TIME, R, Claim.ORDER, "rotation takes longer", _NOR_R),
    Finding(TIME, RH, Claim.NO_EFFECT, "no interaction"),
    Finding(LOSSES, H, Claim.ORDER, "H loses contact least often, then UaH, then NoH", _H_UAH_NOH),
    Finding(LOSSES, R, Claim.ORDER, "with rotation, contact is lost more often", _NOR_R),
    Finding(LOSSES, RH, Claim.NO_EFFECT, "no more than a trend of an interaction"),
    Finding(PENETRATION, H, Claim.ORDER, "H is least deep, then UaH, then NoH", _H_UAH_NOH),
    Finding(PENETRATION, R, Claim.NO_EFFECT, "rotation makes no difference"),
    Finding(PENETRATION, RH, Claim.EFFECT, "the effect of rotation depends on the force"),
    Finding(ANGLE, R, Claim.ORDER, "in UaH, rotation makes the angle smaller", ("R", "NoR")),
    *(Finding(None, term, Claim.MULTIVARIATE, "an effect") for term in MANOVA),
)

# What simulated persons cannot show, because they are built so: outcome, effect, and why.
BY_CONSTRUCTION: tuple[tuple[Outcome | None, Term, str], ...] = (
    (PENETRATION, H, "force makes the penetration smaller because both hands are springs"),
    (ANGLE, R, "rotation makes the contact angle smaller because A4 turns the normal to the motor"),
    (None, T, "blocks do not differ, because nobody learns"),
    (TIME, R, "rotation costs hardly any time, because only a person with the following frozen is "
              "led astray by the turning scene"),
    (LOSSES, H, "force saves no losses, because a person does not use the force that is felt; only "
                "the passive hand meets it"),
)  # fmt: skip


def reason_by_construction(finding: Finding) -> str | None:
    """Why simulated persons are no evidence for or against a finding; None if they may be."""
    for outcome, term, reason in BY_CONSTRUCTION:
        if (finding.outcome, finding.term) == (outcome, term):
            return reason
    return None

"""The answers of a study as texts for readers."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from palpate.analysis.errors import printable
from palpate.analysis.experiment.outcomes import ANGLE
from palpate.analysis.numbers import number_or_dash, with_decimals

from .answers import POWERS, Answers
from .contrasts import PLAIN
from .question import Study

NO_EFFECT = "no effect"


def _range(first: str, last: str) -> str:
    return first if first == last else f"{first} to {last}"


def _number_range(values: Iterable[float]) -> str:
    numbers = sorted(values)
    return _range(number_or_dash(numbers[0]), number_or_dash(numbers[-1]))


def people_text(answers: Answers, n: int, test: int) -> str:
    """ "12", ">60", "no effect"."""
    if answers.is_null[test]:
        return NO_EFFECT
    return str(n) if n <= answers.most else f">{answers.most}"


def _people(answers: Answers, test: int, power: float) -> str:
    """Over all assumptions, "5 to >60"; of one noise, with the bounds: "12 (11 to 13)"."""
    of_models = answers.people[power][:, test]
    text = _range(*(people_text(answers, n, test) for n in (of_models.min(), of_models.max())))
    low, high = (side[0, test] for side in answers.bounds[power])
    if not answers.has_one_noise or answers.is_null[test] or low == high:
        return text
    return f"{text} ({people_text(answers, low, test)} to {people_text(answers, high, test)})"


def _example(answers: Answers, test: int) -> str:
    """The power with answers.example people: "0.812 (0.804 to 0.820)", "0.953 to 0.204"."""
    place = answers.example - 2
    if answers.has_one_noise:
        share, low, high = (with_decimals(float(values[0, test, place]), 3)
                            for values in (answers.share, answers.low, answers.high))
        return f"{share} ({low} to {high})"
    shares = answers.share[:, test, place]
    return _range(with_decimals(float(shares.max()), 3), with_decimals(float(shares.min()), 3))


def heads(answers: Answers) -> list[str]:
    return [*map(str, POWERS), f"power with {answers.example} people"]


def lines(answers: Answers) -> list[list[str]]:
    """For each test its title, the numbers of people for POWERS, and the power of the example. A
    range goes from the assumption with the least noise to that with the most."""
    return [
        [test.title, *(_people(answers, t, power) for power in POWERS), _example(answers, t)]
        for t, test in enumerate(answers.study.contrasts)
    ]


def assumption_text(study: Study, model: int) -> str:
    """ "error 9.88 s, u 0.8, w 0.1"; "pilot"."""
    row = study.assumptions.iloc[model]
    if study.pilot:
        return str(row["error_from"])
    return (f"error {number_or_dash(row['error_sd'])}{study.unit}, u "
            f"{number_or_dash(row['share_u'])}, w {number_or_dash(row['share_w'])}")


def _conditions(study: Study, model: int) -> str:
    """ "if one trial has an error of 9.88 s with the shares u 0.3 and w 0.1, which are a choice"."""
    if study.pilot:
        return "with the variances of the pilot"
    row = study.assumptions.iloc[model]
    text = (f"if one trial has an error of {number_or_dash(row['error_sd'])}{study.unit} with the "
            f"shares u {number_or_dash(row['share_u'])} and w {number_or_dash(row['share_w'])}")
    return text if study.has_given_variances else f"{text}, which are a choice"


def answer_number(answers: Answers) -> str:
    """ "24 people"; "more than 60 people"; "no number of people"."""
    answer = answers.answer
    if not answer.tests:
        return "no number of people"
    is_within = answer.people <= answers.most
    return f"{answer.people} people" if is_within else f"more than {answers.most} people"


def answer_rest(answers: Answers) -> str:
    """What follows the number: for what, and under which conditions."""
    answer, study = answers.answer, answers.study
    measure = study.measure.outcome.name
    if not answer.tests:
        return f"for {measure}: the assumed means have no effect."
    effects = [study.contrasts[t] for t in answer.tests]
    names = ", ".join(e.name if e.correction == PLAIN else f"{e.name} by {e.correction}"
                      for e in effects)
    text = (f"for {measure}: each effect of the assumed means ({names}) then has a power of at "
            f"least {answer.power}, {_conditions(study, answer.model)}, and a person does "
            f"{study.trials} trials in a condition")
    if answers.has_one_noise:
        return f"{text}."
    least, most = (f">{answers.most}" if n > answers.most else str(n)
                   for n in (answer.least, answer.most))
    return f"{text}. Over all {len(study.assumptions)} assumptions: {_range(least, most)} people."


def _source(study: Study, source: str) -> str:
    """Where an error is from, with what the rounding of the paper's means allows."""
    for scatter in study.paper_scatter:
        rounding = (f"; {number_or_dash(scatter.low)} to {number_or_dash(scatter.high)} by the "
                    "rounding of its means")
        if study.measure.outcome is ANGLE:
            return ("assumed, so that the paired difference has the paper's "
                    f"{number_or_dash(scatter.sd)}{study.unit}{rounding}")
        if source.endswith(scatter.source):
            return source + rounding
    return source


def _errors(study: Study) -> str:
    """ "8.98 s (paper, F of Haptic; 6.77 to 11.2 by ...), 9.88 s (paper, F of Rotation; ...)"."""
    of_sources = study.assumptions.groupby("error_from", sort=False)["error_sd"]
    return ", ".join(f"{_number_range(sds)}{study.unit} ({_source(study, source)})"
                     for source, sds in of_sources)


def _shares(answers: Answers) -> str:
    assumed = answers.study.assumptions
    text = f"u {_number_range(assumed['share_u'])}, w {_number_range(assumed['share_w'])}"
    if len(assumed) > 1:
        text += f"; {len(assumed)} combinations with the error"
        text += ", all with the same noise" if answers.has_one_noise else ""
    return text


def _pilot(study: Study) -> str:
    pilot = study.pilot
    assert pilot is not None
    u, w, e = (number_or_dash(np.sqrt(pilot.variances[name])) for name in ("u", "w", "e"))
    return (f"{printable(study.request.pilot)}: {pilot.participants} people, {pilot.trials} "
            f"trials, m = {number_or_dash(pilot.m)}; sd of u {u}, of w {w}, of e {e}{study.unit}")


def facts(answers: Answers) -> list[tuple[str, str]]:
    """What was asked, as pairs of a name and a value."""
    study = answers.study
    names = study.measure.design.conditions
    means = ", ".join(f"{n} {number_or_dash(mean)}" for n, mean in zip(names, study.means))
    if study.pilot:
        scatter = [("pilot", _pilot(study))]
    else:
        scatter = [("standard deviation of one trial", _errors(study)),
                   ("shares of its variance", _shares(answers))]
    return [
        ("measure", study.measure.outcome.name),
        ("model", "y = condition + u(person) + w(person, condition) + e(trial), all normal"),
        ("means of the conditions",
         f"{means}{study.unit}{'' if study.request.effect else ' (from the paper)'}"),
        ("trials of a person in a condition", str(study.trials)),
        *scatter,
        ("data sets", f"{answers.sets}, seed {study.request.seed}"),
    ]


def _table(rows: Sequence[Sequence[str]]) -> str:
    """Columns two blanks apart."""
    widths = [max(map(len, column)) + 2 for column in zip(*rows)]
    widths[-1] = 0
    return "".join(
        "".join(cell.ljust(width) for cell, width in zip(row, widths)) + "\n" for row in rows
    )


def pilot_pairs(study: Study) -> list[list[str]]:
    """For each pair its name, and the sd of people's differences in the pilot and in the model."""
    if study.pilot is None:
        return []
    pairs = study.pilot.pairs(study.contrasts)
    return [[str(name), number_or_dash(row["pilot"]), number_or_dash(row["model"])]
            for name, row in pairs.iterrows()]


def terminal_text(answers: Answers, notes: list[str]) -> str:
    """The answer for a terminal."""
    study = answers.study
    text = f"{answer_number(answers)} {answer_rest(answers)}\n\n"
    text += "".join(f"{name}: {value}\n" for name, value in facts(answers)) + "\n"
    rows = [["people for a power of", *heads(answers)]]
    rows += [[f"  {first}", *rest] for first, *rest in lines(answers)]
    text += _table(rows) + "\n"
    if study.pilot:
        unit = f",{study.unit}" if study.unit else ""
        pairs = [[f"sd of people's differences{unit}", "pilot",
                  f"model with m = {number_or_dash(study.pilot.m)}"]]
        pairs += [[f"  {first}", *rest] for first, *rest in pilot_pairs(study)]
        text += _table(pairs) + "\n"
    return text + "".join(f"note: {note}\n" for note in notes)

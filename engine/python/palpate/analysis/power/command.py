"""`palpate experiment power`: how many people an experiment needs."""

from __future__ import annotations

import argparse

from palpate.analysis.numbers import csv_text, json_text
from palpate.analysis.report import Report

from .answers import Answers
from .notes import notes
from .page import page_of
from .question import prepare
from .simulation import simulate
from .texts import terminal_text


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--measure", default="time", help="time, losses, penetration or angle")
    parser.add_argument("--effect", default="", help="means of the conditions; the paper's")
    parser.add_argument("--pilot", default="", help="trials.csv of a pilot")
    parser.add_argument("--following", default="", help="which trials of the pilot; or people")
    parser.add_argument("--error", type=float, help="standard deviation of one trial; the paper's")
    parser.add_argument("--share-u", type=float, help="share of u in its variance; a grid")
    parser.add_argument("--share-w", type=float, help="share of w; a grid")
    parser.add_argument("--trials", type=int, help="of a person in a condition; the pilot's, or 12")
    parser.add_argument("--participants", type=int, default=60, help="largest number of people")
    parser.add_argument("--sets", type=int, default=10_000, help="simulated data sets")
    parser.add_argument("--seed", type=int, default=2005, help="seed of the data sets")
    parser.add_argument("--jobs", type=int, default=1, help="threads")


def run(arguments: argparse.Namespace) -> Report:
    study = prepare(arguments)
    noises = study.assumptions["noise"].to_numpy()
    counts = simulate(study.contrasts, study.means, noises, arguments.participants, arguments.sets,
                      arguments.seed, arguments.jobs)
    answers = Answers(study, counts)
    sentences = notes(study)
    tables = {"needed_people.csv": answers.needed_people(), "power.csv": answers.curves()}
    files = {
        "report.html": page_of(answers, sentences),
        "power.json": json_text(answers.as_json(sentences)),
    }
    for name, table in tables.items():
        files[name] = csv_text(list(table), table.to_numpy().tolist())
    return Report(files, terminal_text(answers, sentences))

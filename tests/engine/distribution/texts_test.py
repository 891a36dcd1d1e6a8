#!/usr/bin/env python3
"""Checks CITATION.cff, SECURITY.md and what run.sh builds.

usage: texts_test.py PROJECT BUILD NINJA VERSION

CITATION.cff must have the form of CFF 1.2.0 and name this version, SECURITY.md no address and only
links that lead somewhere. To build `palpate` must build `palpate-guard` as well, because run.sh builds the
former and a run on a device starts the latter.
"""

import datetime
import pathlib
import re
import subprocess
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "helpers"))
from needs import need  # noqa: E402

try:
    import yaml
except ImportError:
    need(False, "the Python module yaml: apt-get install python3-yaml")

failures = []


def expect(holds, message):
    if not holds:
        failures.append(message)


def check_authors(where, authors):
    expect(isinstance(authors, list) and authors, f"{where}: authors")
    for author in authors:
        person, entity = "family-names" in author, "name" in author
        expect(person != entity, f"{where}: {author} is neither a person nor an entity")
        expect(all(isinstance(value, str) for value in author.values()), f"{where}: {author}")


def check_citation(path, version):
    cff = yaml.safe_load(path.read_text(encoding="utf-8"))
    known = {"abstract", "authors", "cff-version", "commit", "contact", "date-released", "doi",
             "identifiers", "keywords", "license", "license-url", "message", "preferred-citation",
             "references", "repository", "repository-artifact", "repository-code", "title", "type", "url",
             "version"}
    expect(not set(cff) - known, f"CFF 1.2.0 has no {set(cff) - known}")
    expect(cff["cff-version"] == "1.2.0", "cff-version")
    for key in ("message", "title", "abstract"):
        expect(isinstance(cff[key], str) and cff[key], key)
    expect(cff["type"] == "software", "type")
    expect(cff["license"] == "MIT", "license")
    expect(str(cff["version"]) == version, f"version {cff['version']}; the project has {version}")
    expect(len(set(cff["keywords"])) == len(cff["keywords"]), "keywords")
    check_authors("CITATION.cff", cff["authors"])
    papers = [r for r in cff["references"] if r["type"] == "conference-paper"]
    expect(papers, "the paper is missing")
    for paper in papers:
        check_authors(paper["title"], paper["authors"])
        expect(isinstance(paper["year"], int) and 1900 < paper["year"] <= datetime.date.today().year, "year")
        expect(paper["conference"]["name"], "conference")
        expect(re.match(r"https://\S+$", paper["url"]), "url")
    names = [author["family-names"] for author in papers[0]["authors"]]
    expect(names == ["Lécuyer", "Burkhardt", "Le Biller", "Congedo"], f"authors: {names}")


def check_security(project):
    text = (project / "SECURITY.md").read_text(encoding="utf-8")
    expect(not re.search(r"\S+@\S+\.\w", text), "SECURITY.md has an address; the repository has private reports")
    for name in ("SECURITY.md", "NOTICES.md"):
        page = (project / name).read_text(encoding="utf-8")
        for file, anchor in re.findall(r"\]\((?!https?:)([^)#]+)(?:#([^)]+))?\)", page):
            target = project / file
            expect(target.exists(), f"{name}: {file} is missing")
            if anchor and target.exists():
                linked = target.read_text(encoding="utf-8")
                titles = {re.sub(r"[^\w -]", "", t.lower()).replace(" ", "-")
                          for t in re.findall(r"^#+ (.*)$", linked, re.M)}
                expect(anchor in titles or f'id="{anchor}"' in linked, f"{name}: {file} has no #{anchor}")


def check_guard(project, build, ninja):
    commands = subprocess.run([ninja, "-C", build, "--quiet", "-n", "-t", "commands", "palpate"],
                              capture_output=True, text=True, check=True).stdout
    expect(re.search(r"-o palpate-guard\s", commands), "to build palpate does not build palpate-guard")
    script = (project / "run.sh").read_text(encoding="utf-8")
    expect(re.search(r"^build_preset release palpate\b", script, re.M), "run.sh does not build palpate")


def main():
    project, build, ninja, version = sys.argv[1:]
    check_citation(pathlib.Path(project) / "CITATION.cff", version)
    check_security(pathlib.Path(project))
    check_guard(pathlib.Path(project), build, ninja)
    sys.exit("\n".join(failures) if failures else 0)


if __name__ == "__main__":
    main()

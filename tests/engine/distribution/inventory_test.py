#!/usr/bin/env python3
"""Checks the bill of materials and the licences that the build writes (engine/distribution/inventory.py).

usage: inventory_test.py PROJECT BUILD INVENTORY...     INVENTORY: the command that writes both

The bill must have the form of SPDX 2.3, name the owner of every library that the loader maps for the
programs and of every header-only library of NOTICES.md, and say nothing about the machine. Run again,
the command gives the same bytes. A copy of NOTICES.md with a row less, and one with a row too many, must
be complained about.
"""

import getpass
import json
import os
import pathlib
import re
import shutil
import socket
import subprocess
import sys
import tempfile

IDENTIFIER = re.compile(r"SPDXRef-[A-Za-z0-9.-]+")
PURPOSES = {"APPLICATION", "LIBRARY"}
RELATIONS = {"DESCRIBES", "DEPENDS_ON", "STATIC_LINK", "CONTAINS"}
LICENCES = {"MIT", "BSD-2-Clause", "BSD-3-Clause", "BSL-1.0", "Apache-2.0", "MPL-2.0", "Zlib", "IJG",
            "blessing", "LGPL-2.1-or-later", "GPL-2.0-only", "GPL-3.0-or-later", "NOASSERTION"}
EXCEPTIONS = {"GCC-exception-3.1", "Linux-syscall-note"}
HEADERS_ONLY = {"CLI11/": "cli11", "Eigen/": "eigen3", "boost/": "boost", "nlohmann/": "json",
                "tiny_gltf.h": "tinygltf"}

failures = []


def expect(holds, message):
    if not holds:
        failures.append(message)


def is_licence(text):
    """An expression of known identifiers with AND, OR and WITH."""
    parts = re.split(r" (?:AND|OR) ", text)
    return all(name in LICENCES and (not rest or rest[0] in EXCEPTIONS)
               for name, *rest in (part.split(" WITH ") for part in parts))


def write(command, out, project=None, **environment):
    """The bill, its bytes, the licences, and what the command complained about."""
    command = list(command)
    if project:
        command[command.index("--project") + 1] = str(project)
    done = subprocess.run([*command, "--out", str(out)], capture_output=True, text=True,
                          env={**os.environ, **environment})
    if done.returncode != 0:
        sys.exit(f"{' '.join(command)}: exit code {done.returncode}\n{done.stderr}")
    bill = (out / "palpate.spdx.json").read_bytes()
    return json.loads(bill), bill, (out / "NOTICES").read_text(encoding="utf-8"), done.stderr


def check_form(bill):
    """The mandatory fields of SPDX 2.3, and the values that they may have."""
    expect(bill["spdxVersion"] == "SPDX-2.3", "spdxVersion")
    expect(bill["dataLicense"] == "CC0-1.0", "dataLicense")
    expect(bill["SPDXID"] == "SPDXRef-DOCUMENT", "SPDXID of the document")
    expect(bill["name"], "name of the document")
    expect(re.fullmatch(r"https://[\w./-]+", bill["documentNamespace"]), "documentNamespace")
    expect(re.fullmatch(r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\dZ", bill["creationInfo"]["created"]), "created")
    creators = bill["creationInfo"]["creators"]
    expect(creators and all(re.match(r"(Tool|Organization|Person): \S", c) for c in creators), "creators")
    names = [p["SPDXID"] for p in bill["packages"]]
    expect(len(set(names)) == len(names), "two packages have one identifier")
    for package in bill["packages"]:
        name = package["SPDXID"]
        expect(IDENTIFIER.fullmatch(name), f"{name}: is no identifier")
        expect(package["name"] and package["versionInfo"], f"{name}: name or version")
        expect(package["downloadLocation"], f"{name}: downloadLocation")
        expect(package["filesAnalyzed"] is False, f"{name}: filesAnalyzed")
        expect(package["primaryPackagePurpose"] in PURPOSES, f"{name}: purpose")
        for field in ("licenseConcluded", "licenseDeclared"):
            expect(is_licence(package[field]), f"{name}: {field} is {package[field]}")
        expect(package["licenseDeclared"] != "NOASSERTION", f"{name}: has no licence")
        for check in package.get("checksums", []):
            digits = {"SHA256": 64, "SHA512": 128}[check["algorithm"]]
            expect(re.fullmatch(rf"[0-9a-f]{{{digits}}}", check["checksumValue"]), f"{name}: checksum")
        for reference in package.get("externalRefs", []):
            expect(reference["referenceCategory"] == "PACKAGE-MANAGER", f"{name}: category")
            expect(re.fullmatch(r"pkg:(deb/\w+|npm)/[^@\s]+@[^@\s]+", reference["referenceLocator"]),
                   f"{name}: {reference['referenceLocator']} is no package URL")
    known = {"SPDXRef-DOCUMENT", *names}
    for relation in bill["relationships"]:
        expect({relation["spdxElementId"], relation["relatedSpdxElement"]} <= known,
               f"a relation names what is not there: {relation}")
        expect(relation["relationshipType"] in RELATIONS, f"kind of relation: {relation}")


def reached(bill, begin):
    """The packages that `begin` depends on, directly or not."""
    found, queue = set(), [begin]
    while queue:
        one = queue.pop()
        for relation in bill["relationships"]:
            other = relation["relatedSpdxElement"]
            if (relation["spdxElementId"], relation["relationshipType"]) == (one, "DEPENDS_ON") and \
                    other not in found:
                found.add(other)
                queue.append(other)
    return found


def check_libraries(bill, program, identifier):
    """The loader's own list of libraries, and dpkg's owner and version of each file."""
    packages = {p["SPDXID"]: p for p in bill["packages"]}
    depends = {packages[name]["name"]: packages[name]["versionInfo"] for name in reached(bill, identifier)}
    listed = subprocess.run(["ldd", program], capture_output=True, text=True, check=True).stdout
    paths = re.findall(r"(?<=[\s>])(/\S+\.so\S*) ", listed)
    expect(len(paths) >= 2, f"ldd lists only {paths}")  # the C library and the loader
    for path in paths:
        real = os.path.realpath(path)
        found = [subprocess.run(["dpkg-query", "-S", p], capture_output=True, text=True).stdout
                 for p in (real, real.removeprefix("/usr"))]
        owner = re.match(r"([^:,]+)", "".join(found))[1]
        version = subprocess.run(["dpkg-query", "-W", "-f", "${Version}\n", owner], capture_output=True,
                                 text=True, check=True).stdout.split()[0]
        expect(depends.get(owner) == version,
               f"{program.name} loads {path}, but the bill has no {owner} {version} among {sorted(depends)}")


def check_static(bill, licences, build):
    """Header-only libraries, the packages of the page, and the text of every licence."""
    linked = {r["relatedSpdxElement"] for r in bill["relationships"]
              if r["relationshipType"] == "STATIC_LINK" and r["spdxElementId"] == "SPDXRef-palpate"}
    for name in HEADERS_ONLY.values():
        expect(any(name in package for package in linked), f"{name} is not linked statically")
    contained = {r["relatedSpdxElement"] for r in bill["relationships"]
                 if r["relationshipType"] == "CONTAINS" and r["spdxElementId"] == "SPDXRef-palpate-page"}
    has_page = b'id="no-webgl"' in (build / "palpate").read_bytes()
    expected = {"SPDXRef-npm-three", "SPDXRef-npm-uplot"} if has_page else set()
    expect(contained == expected, f"the page has {contained}; expected {expected}")
    for package in bill["packages"]:
        if "externalRefs" in package:
            line = f"{package['name']} {package['versionInfo']}: {package['licenseDeclared']}\n"
            expect(line in licences, f"NOTICES has no line {line}")
    for sentence in ("Permission is hereby granted", "Apache License", "Mozilla Public License",
                     "GNU LESSER GENERAL PUBLIC LICENSE", "Boost Software License"):
        expect(sentence in licences, f"NOTICES has no text with \"{sentence}\"")
    expect("No text of the licence" not in licences, "NOTICES lacks a text")


def without_machine(text, build):
    names = {socket.gethostname(), os.path.expanduser("~"), str(build), str(pathlib.Path.cwd())}
    if getpass.getuser() != "root":
        names.add(getpass.getuser())
    for name in names:
        if len(name) > 1:
            expect(name not in text, f"the bill names the machine: {name}")


def check_complaints(command, project, scratch):
    """A row less, and a row too many."""
    copy = scratch / "project"
    (copy / "engine/viewer/page").mkdir(parents=True)
    for name in ("LICENSE", "engine/viewer/page/package-lock.json"):
        shutil.copy(project / name, copy / name)
    rows = (project / "NOTICES.md").read_text(encoding="utf-8").splitlines()
    fewer = [row for row in rows if "| `draco` |" not in row]
    more = rows + ["| [Unused](https://example.org) | nothing | `unused` | MIT |"]
    for changed, complaint in ((fewer, "has no row for draco"), (more, "unused has a row")):
        (copy / "NOTICES.md").write_text("\n".join(changed) + "\n", encoding="utf-8")
        said = write(command, scratch / "broken", copy, SOURCE_DATE_EPOCH="1")[3]
        expect(complaint in said, f"expected \"{complaint}\"; the command said \"{said}\"")


def main():
    project, build, *command = sys.argv[1:]
    project, build = pathlib.Path(project), pathlib.Path(build)
    with tempfile.TemporaryDirectory() as name:
        scratch = pathlib.Path(name)
        bill, first, licences, said = write(command, scratch / "first", SOURCE_DATE_EPOCH="1700000000")
        expect(not said, said)
        check_form(bill)
        expect(bill["creationInfo"]["created"] == "2023-11-14T22:13:20Z", "created is not the epoch")
        for program in ("palpate", "palpate-guard"):
            check_libraries(bill, build / program, f"SPDXRef-{program}")
        check_static(bill, licences, build)
        without_machine(first.decode(), build)
        again = write(command, scratch / "second", SOURCE_DATE_EPOCH="1700000000")
        expect(again[1] == first and again[2] == licences, "the same build gives other bytes")
        later = write(command, scratch / "third", SOURCE_DATE_EPOCH="1700000001")[0]
        expect(later["documentNamespace"] != bill["documentNamespace"], "two documents have one name")
        check_complaints(command, project, scratch)
    print(f"{len(bill['packages'])} packages, {len(bill['relationships'])} relations")
    sys.exit("\n".join(failures) if failures else 0)


if __name__ == "__main__":
    main()

#!/usr/bin/env python3
"""Writes what the programs that ship consist of: a bill of materials (SPDX 2.3), and the licences in full.

usage: inventory.py --project FOLDER --build FOLDER --version VERSION --ninja NINJA --out FOLDER

Reads the finished build: the headers of the objects of each program from ninja's log of dependencies,
the libraries from the programs themselves (readelf, ldd), and the npm packages of the page from what
esbuild has bundled. dpkg names the package and the version of each file; NOTICES.md names the licence.
Writes palpate.spdx.json and NOTICES into the folder of --out. The same build gives the same bytes: the
time is SOURCE_DATE_EPOCH, or that of the commit, or that of the program.

Prints a line for each component that NOTICES.md lacks, and for each row that no program uses.
"""

import argparse
import base64
import dataclasses
import datetime
import hashlib
import json
import os
import pathlib
import re
import subprocess
import sys
import uuid

PROGRAMS = ("palpate", "palpate-guard")
UNKNOWN = "NOASSERTION"
MAINTAINERS = "Organization: The Palpate maintainers"
COMMON_LICENCES = pathlib.Path("/usr/share/common-licenses")


def run(*command):
    """The output of the command."""
    environment = {**os.environ, "LC_ALL": "C"}
    return subprocess.run([str(part) for part in command], check=True, capture_output=True, text=True,
                          env=environment).stdout


@dataclasses.dataclass(frozen=True, order=True)
class Package:
    """A package that a program contains or loads. `source` is its row in NOTICES.md."""
    name: str
    version: str
    source: str
    url: str  # package URL, or "" if no package manager knows the file
    licence_file: str
    checksum: str = ""


class Licences:
    """The table of NOTICES.md: the licence of each component, by the name of its source package."""

    def __init__(self, path):
        row = re.compile(r"\|\s*\[.*\]\(.*\)\s*\|[^|]*\|\s*(npm )?`([^`]+)`\s*\|\s*([^|]*?)\s*\|")
        found = filter(None, map(row.match, path.read_text(encoding="utf-8").splitlines()))
        self.rows = {(bool(npm), name): licence for npm, name, licence in (m.groups() for m in found)}
        self.used = set()

    def of(self, package):
        """The SPDX expression. Debian appends a version to some names: gcc-12, boost1.74."""
        npm = package.url.startswith("pkg:npm/")
        for name in (package.source, re.sub(r"-?[\d.]+$", "", package.source)):
            if (npm, name) in self.rows:
                self.used.add((npm, name))
                return self.rows[npm, name]
        return UNKNOWN

    def unused(self):
        return sorted(name for npm, name in set(self.rows) - self.used)


class DebianPackages:
    """The packages of files, with their versions."""

    def __init__(self):
        facts = dict(re.findall(r'^(\w+)="?([^"\n]*)"?$',
                                pathlib.Path("/etc/os-release").read_text(encoding="utf-8"), re.M))
        self.supplier = facts.get("ID", "debian")
        self.release = f"{self.supplier}-{facts.get('VERSION_ID', 'unknown')}"

    def of(self, files):
        """{file: package}. A file that no package owns is a package of its own."""
        spelled = {}  # dpkg lists files of old systems below /lib, which is a link to /usr/lib
        for file in files:
            real = os.path.realpath(file)
            for spelling in (real, real.removeprefix("/usr")):
                spelled.setdefault(spelling, set()).add(file)
        owners = {}
        for line in self._search(sorted(spelled)):
            names, path = line.rsplit(": ", 1)
            for file in spelled.get(path, ()):
                owners[file] = names.split(", ")[0]
        known = self._packages(sorted(set(owners.values())))
        return {file: known[owners[file]] if file in owners else self._unowned(file) for file in files}

    @staticmethod
    def _search(paths):
        if not paths:
            return []
        found = subprocess.run(["dpkg-query", "-S", *paths], capture_output=True, text=True,
                               env={**os.environ, "LC_ALL": "C"})
        lines = found.stdout.splitlines()  # exit code 1 if one of the paths has no owner
        return [line for line in lines if not line.startswith("diversion by ")]

    def _packages(self, names):
        if not names:
            return {}
        fields = ("binary:Package", "Package", "Version", "Architecture", "source:Package")
        form = "\\t".join(f"${{{field}}}" for field in fields) + "\\n"
        packages = {}
        for line in run("dpkg-query", "-W", "-f", form, *names).splitlines():
            asked, name, version, architecture, source = line.split("\t")
            text = f"pkg:deb/{self.supplier}/{quoted(name)}@{quoted(version)}" \
                   f"?arch={architecture}&distro={self.release}"
            package = Package(name, version, source, text, f"/usr/share/doc/{name}/copyright")
            packages[asked] = packages[name] = package
        return packages

    @staticmethod
    def _unowned(file):
        name = os.path.basename(file)
        return Package(name, UNKNOWN, name, "", "")


def quoted(text):
    """Percent-encoded for a package URL."""
    return "".join(c if re.match(r"[A-Za-z0-9.~_-]", c) else f"%{ord(c):02X}" for c in text)


def ask_ninja(ninja, build, *tool):
    """The lines of one of ninja's tools. -n: the ninja that runs this script is writing its log."""
    return run(ninja, "-C", build, "--quiet", "-n", "-t", *tool).splitlines()


def compiled_files(ninja, build, program):
    """The system's headers that the objects of the program include, and the static libraries in it."""
    inputs = set(ask_ninja(ninja, build, "inputs", program))
    files = {i for i in inputs if i.startswith("/") and i.endswith(".a")}
    ours = False
    for line in ask_ninja(ninja, build, "deps"):
        if line and not line[0].isspace():
            ours = line.split(":", 1)[0] in inputs
        elif ours and line.startswith("    /"):
            files.add(os.path.normpath(line.strip()))
    places = tuple(os.path.realpath(p) + "/" for p in ("/usr", "/opt"))
    return {f for f in files if os.path.realpath(f).startswith(places) and
            not f.startswith(str(build) + "/")}


def needed_libraries(file):
    """Names of the shared libraries that the file asks for."""
    return set(re.findall(r"\(NEEDED\).*\[(.*)\]", run("readelf", "-d", "-W", file)))


def loaded_libraries(program):
    """{name: path} of all shared libraries that the loader maps for the program."""
    listed = re.findall(r"^\s*(?:(\S+) => )?(/\S+) \(0x", run("ldd", program), re.M)
    return {name or os.path.basename(path): path for name, path in listed}


def page_packages(project, build, ninja):
    """The npm packages of which esbuild has put files into the page; none if the program has no page."""
    if "page/page.js" not in ask_ninja(ninja, build, "inputs", PROGRAMS[0]):
        return []
    lock = json.loads((project / "engine/viewer/page/package-lock.json").read_text(encoding="utf-8"))
    packages = []
    inputs = json.loads((build / "page_inputs.json").read_text(encoding="utf-8"))["inputs"]
    folder = re.compile(r"(?:^|/)(node_modules/(?:.*/node_modules/)?((?:@[^/]+/)?[^/]+))/")
    for place, name in sorted({m.groups() for m in map(folder.search, inputs) if m}):
        entry = lock["packages"][place]
        packages.append(Package(name, entry["version"], name,
                                f"pkg:npm/{name.replace('@', '%40')}@{entry['version']}",
                                str(build / "page_build" / place / "LICENSE"),
                                entry["integrity"]))
    return packages


def git(project, *arguments):
    """The output of git; "" without a repository."""
    try:
        return run("git", "-C", project, *arguments).strip()
    except (OSError, subprocess.CalledProcessError):
        return ""


def created(project, program):
    text = os.environ.get("SOURCE_DATE_EPOCH") or git(project, "log", "-1", "--format=%ct") or \
        str(int(program.stat().st_mtime))
    if not re.fullmatch(r"\d{1,11}", text):
        sys.exit(f"inventory.py: SOURCE_DATE_EPOCH is {text}; expected seconds since 1970")
    time = datetime.datetime.fromtimestamp(int(text), datetime.timezone.utc)
    return time.strftime("%Y-%m-%dT%H:%M:%SZ")


class Document:
    """The bill of materials, in the JSON form of SPDX 2.3."""

    def __init__(self, licences, supplier):
        self.licences = licences
        self.supplier = supplier
        self.packages = {}
        self.relations = set()

    def add(self, package):
        """The identifier of the package."""
        text = re.sub(r"[^A-Za-z0-9.-]", lambda m: f"-x{ord(m[0]):02X}", package.name)
        kind = "npm" if package.url.startswith("pkg:npm/") else "Package"
        identifier = f"SPDXRef-{kind}-{text}"
        if identifier not in self.packages:
            self.packages[identifier] = self._entry(identifier, package)
        return identifier

    def _entry(self, identifier, package):
        entry = {"name": package.name, "SPDXID": identifier, "versionInfo": package.version,
                 "downloadLocation": UNKNOWN, "filesAnalyzed": False, "licenseConcluded": UNKNOWN,
                 "licenseDeclared": self.licences.of(package), "copyrightText": UNKNOWN,
                 "primaryPackagePurpose": "LIBRARY"}
        if package.url.startswith("pkg:deb/"):
            entry["supplier"] = f"Organization: {self.supplier}"
            entry["sourceInfo"] = f"built from the source package {package.source}"
        if package.url:
            entry["externalRefs"] = [{"referenceCategory": "PACKAGE-MANAGER", "referenceType": "purl",
                                      "referenceLocator": package.url}]
        if package.checksum.startswith("sha512-"):
            digest = base64.b64decode(package.checksum.removeprefix("sha512-")).hex()
            entry["checksums"] = [{"algorithm": "SHA512", "checksumValue": digest}]
        return entry

    def add_own(self, name, version, purpose, **more):
        identifier = f"SPDXRef-{name}"
        self.packages[identifier] = {
            "name": name, "SPDXID": identifier, "versionInfo": version, "supplier": MAINTAINERS,
            "downloadLocation": UNKNOWN, "filesAnalyzed": False, "licenseConcluded": "MIT",
            "licenseDeclared": "MIT", "copyrightText": "Copyright (c) 2026 The Palpate maintainers",
            "primaryPackagePurpose": purpose, **more}
        return identifier

    def relate(self, one, kind, other):
        if one != other:
            self.relations.add((one, kind, other))

    def text(self, version, time):
        body = {"spdxVersion": "SPDX-2.3", "dataLicense": "CC0-1.0", "SPDXID": "SPDXRef-DOCUMENT",
                "name": f"palpate-{version}",
                "creationInfo": {"created": time,
                                 "creators": [MAINTAINERS, f"Tool: inventory.py-{version}"]},
                "packages": [self.packages[key] for key in sorted(self.packages)],
                "relationships": [{"spdxElementId": one, "relationshipType": kind,
                                   "relatedSpdxElement": other}
                                  for one, kind, other in sorted(self.relations)]}
        name = uuid.uuid5(uuid.NAMESPACE_URL, json.dumps(body, sort_keys=True))  # of these contents
        body["documentNamespace"] = f"https://spdx.org/spdxdocs/palpate-{version}-{name}"
        return json.dumps(body, indent=1, ensure_ascii=True) + "\n"


def add_program(document, debian, program, ninja, build, identifier):
    """Adds what the program contains and loads. Returns its packages."""
    libraries = loaded_libraries(program)
    headers = compiled_files(ninja, build, program.name)
    owner = debian.of(sorted(headers | set(libraries.values())))
    for header in headers:
        document.relate(identifier, "STATIC_LINK", document.add(owner[header]))
    files = {identifier: program}
    for name, path in libraries.items():
        files[name] = path
    for user, file in files.items():
        one = identifier if user == identifier else document.add(owner[file])
        for name in needed_libraries(file) & set(libraries):
            document.relate(one, "DEPENDS_ON", document.add(owner[libraries[name]]))
    for name in libraries:  # the loader itself, which some libraries do not name
        document.add(owner[libraries[name]])
    return set(owner.values())


def notices(project, packages, licences, version):
    """The licences in full. Packages with the same text share it."""
    texts = {}
    for package in sorted(packages):
        path = pathlib.Path(package.licence_file) if package.licence_file else None
        text = path.read_text(encoding="utf-8", errors="replace") if path and path.exists() else \
            "No text of the licence was found on the system that built the programs.\n"
        texts.setdefault(text, []).append(package)
    line = "=" * 100 + "\n"
    parts = [f"Palpate {version}, and the licences of what its programs contain or load.\n\n", line,
             (project / "LICENSE").read_text(encoding="utf-8")]
    for text, owners in texts.items():
        parts.append("\n" + line)
        parts += [f"{p.name} {p.version}: {licences.of(p)}\n" for p in owners]
        parts.append("\n" + text.strip() + "\n")
    named = sorted(set(re.findall(rf"{COMMON_LICENCES}/([A-Za-z0-9+-]+(?:\.[0-9]+)*)", "".join(parts))))
    for name in named:  # Debian's texts refer to files for the common licences
        path = COMMON_LICENCES / name
        if path.exists():
            parts.append(f"\n{line}{path}\n\n{path.read_text(encoding='utf-8', errors='replace')}")
    return "".join(parts)


def describe(arguments):
    project, build = arguments.project.resolve(), arguments.build.resolve()
    licences = Licences(project / "NOTICES.md")
    debian = DebianPackages()
    document = Document(licences, debian.supplier)
    commit = git(project, "rev-parse", "HEAD")
    source = {"sourceInfo": f"git commit {commit}"} if commit else {}
    packages = set()
    for name in PROGRAMS:
        program = build / name
        digest = hashlib.sha256(program.read_bytes()).hexdigest()
        identifier = document.add_own(name, arguments.version, "APPLICATION", **source, checksums=[
            {"algorithm": "SHA256", "checksumValue": digest}])
        document.relate("SPDXRef-DOCUMENT", "DESCRIBES", identifier)
        packages |= add_program(document, debian, program, arguments.ninja, build, identifier)
    document.relate("SPDXRef-palpate", "DEPENDS_ON", "SPDXRef-palpate-guard")
    bundled = page_packages(project, build, arguments.ninja)
    if bundled:
        page = document.add_own("palpate-page", arguments.version, "APPLICATION")
        document.relate("SPDXRef-palpate", "CONTAINS", page)
        for package in bundled:
            document.relate(page, "CONTAINS", document.add(package))
    packages |= set(bundled)

    for package in sorted(packages):
        if licences.of(package) == UNKNOWN:
            print(f"NOTICES.md: has no row for {package.source} (package {package.name})", file=sys.stderr)
    for name in licences.unused():
        if bundled or (True, name) not in licences.rows:
            print(f"NOTICES.md: {name} has a row, but no program uses it", file=sys.stderr)
    return (document.text(arguments.version, created(project, build / PROGRAMS[0])),
            notices(project, packages, licences, arguments.version))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    for name in ("project", "build", "out"):
        parser.add_argument(f"--{name}", type=pathlib.Path, required=True)
    parser.add_argument("--version", required=True)
    parser.add_argument("--ninja", required=True)
    arguments = parser.parse_args()
    bill, licences = describe(arguments)
    arguments.out.mkdir(parents=True, exist_ok=True)
    (arguments.out / "palpate.spdx.json").write_text(bill, encoding="utf-8")
    (arguments.out / "NOTICES").write_text(licences, encoding="utf-8")


if __name__ == "__main__":
    main()

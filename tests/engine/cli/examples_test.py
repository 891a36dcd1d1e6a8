#!/usr/bin/env python3
"""Every example of a help and every command line of the documents works as it stands.

examples_test.py PALPATE PROJECT_DIR

Collects the command lines below "Example:" of `palpate --help` and of the help of each subcommand,
also of subcommands of subcommands, and the lines in fenced blocks of README.md and of each page in
docs that begin with `./run.sh` or `palpate`. Runs each one by bash in a temporary copy of the project's
folder, whose run.sh starts the built program instead of installing and building. Expects exit code 0,
or 3 from a line whose comment names exit code 3. The lines of one help or document run in one folder,
in order: a later line may read the files of an earlier one. The plan of an experiment or the sweep that
a line has written is made smaller before the next line. A block of `text` below the line
<!-- printed --> quotes what commands of its page print: each of its lines must be one of theirs, or the
begin of one and " ...".
"""

import json
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import time

SECONDS = 300  # of one line
COMMAND = re.compile(r"(\./run\.sh|palpate)(\s|$)")
SHELLS = ("", "sh", "bash", "shell", "console")  # languages of fenced blocks with command lines
PLACEHOLDER = "your-scene.glb"

# What is added to lines that take a minute or more: the test of the report runs the whole study, and
# tests of statistics simulate more.
SHORTER = {
    "./run.sh accuracy models/star.glb --quick --device-mass 0.2 --device-damping 1": "--knob a4_step",
}
POWER = re.compile(r"(\./run\.sh|palpate) experiment power(?!.* --sets)")  # simulates 10,000 data sets

# Lines that do not run here, and why.
NOT_RUN = {
    "./run.sh": "a minute in real time; `./run.sh run models/star.glb --virtual` does the same",
}
ENDLESS = re.compile(r"(\./run\.sh|palpate) (view|devices --simulate \w+$|experiment live (?!.*--script))")
# until Ctrl-C, or the end of an experiment


def without_comment(line):
    return re.sub(r"\s+#.*", "", line).strip()


def document_lines(text):
    """Command lines of the fenced blocks; a backslash continues a line."""
    lines, language = [], None
    for line in re.sub(r"\\\n\s*", " ", text).splitlines():
        fence = re.match(r"\s*```\s*(\w*)", line)
        if fence:
            language = fence[1] if language is None else None
        elif language in SHELLS and COMMAND.match(line.strip().removeprefix("$ ")):
            lines.append(line.strip().removeprefix("$ "))
    return lines


def printed_lines(text):
    """The lines of the blocks below <!-- printed -->, which quote what the page's commands print."""
    blocks = re.findall(r"^<!-- printed -->\n+```text\n(.*?)^```", text, flags=re.M | re.S)
    return [" ".join(line.split()) for block in blocks for line in block.splitlines() if line.strip()]


def help_of(palpate, command):
    done = subprocess.run([palpate, *command, "--help"], capture_output=True, text=True, timeout=60)
    if done.returncode != 0:
        sys.exit(f"palpate {' '.join(command)} --help: exit code {done.returncode}\n{done.stderr}")
    return done.stdout


def subcommands(text):
    """Names in the section of subcommands, one to a line that is indented by two spaces."""
    section = re.split(r"\nsubcommands:\s*\n", text, flags=re.IGNORECASE)
    if len(section) < 2:
        return []
    return re.findall(r"^  (\w+)\s", section[1].split("\n\n")[0], flags=re.MULTILINE)


def all_commands(palpate, command=()):
    """The command and its subcommands, each as a list of words."""
    commands = [list(command)]
    for name in subcommands(help_of(palpate, command)):
        commands += all_commands(palpate, (*command, name))
    return commands


def help_lines(text, name):
    head = re.match(r"Example:\n((?:  \S.*\n)+)\n", text)
    if not head:
        sys.exit(f"the help of {name} does not begin with an example:\n{text[:300]}")
    lines = [line.strip() for line in head[1].splitlines()]
    for line in lines:
        if not COMMAND.match(line):
            sys.exit(f"the help of {name} has an example that is not a command line: {line}")
    return lines


def copy_project(palpate, project, folder):
    """The project's entries as links, except what the lines write or replace."""
    for entry in project.iterdir():
        if entry.name not in ("run.sh", "out", "accuracy", "report", "build", ".git"):
            (folder / entry.name).symlink_to(entry)
    script = folder / "run.sh"
    script.write_text('#!/usr/bin/env bash\n'
                      'set -euo pipefail\n'
                      'if (($# == 0)); then set -- run models/star.glb; fi\n'
                      f'exec "{palpate}" "$@"\n')
    script.chmod(0o755)
    shutil.copy(project / "models" / "star.glb", folder / PLACEHOLDER)
    programs = folder / ".programs"
    programs.mkdir()
    (programs / "palpate").symlink_to(palpate)
    return programs


def shrink_plans(folder):
    """Two participants, one block and one following: the plan and the sweep that ship take minutes."""
    for path in folder.glob("*.json"):
        if path.is_symlink():
            continue
        plan = json.loads(path.read_text())
        if "palpate_plan" in plan:
            plan.update(participants=2, blocks=1, practice_blocks=0, followings=["delayed"])
        elif "palpate_sweep" in plan:
            plan["plan"].update(participants=2, objects={"O1": plan["plan"]["objects"]["O1"]})
            plan["parameters"] = {"align": plan["parameters"]["align"]}
            plan["hypercube"].update(points=2, participants=1)
        else:
            continue
        path.write_text(json.dumps(plan))


def is_printed(line, printed):
    """A quoted line may end with " ..." in place of its rest."""
    return any(each.startswith(line[:-4]) for each in printed) if line.endswith(" ...") else line in printed


def run_lines(palpate, project, source, lines, quoted):
    """Runs the lines, and looks for each quoted line in what they print."""
    failures, printed = [], set()
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        programs = copy_project(palpate, project, folder)
        for line in lines:
            reason = NOT_RUN.get(without_comment(line))
            if ENDLESS.match(without_comment(line)):
                reason = "until Ctrl-C; tests of the command run it"
            if reason:
                print(f"{source}: not run: {line}   ({reason})")
                continue
            added = "--sets 500" if POWER.match(line) else SHORTER.get(without_comment(line))
            typed = f"{without_comment(line)} {added}" if added else line
            allowed = (0, 3) if re.search(r"#.*exit code 3", line) else (0,)
            start = time.monotonic()
            done = subprocess.run(["bash", "-c", f'PATH="{programs}:$PATH"\n{typed}'], cwd=folder,
                                  stdin=subprocess.DEVNULL, capture_output=True, text=True,
                                  timeout=SECONDS)
            print(f"{source}: exit code {done.returncode}, {time.monotonic() - start:.1f} s: {typed}",
                  flush=True)
            shrink_plans(folder)
            printed.update(" ".join(each.split()) for each in (done.stdout + done.stderr).splitlines())
            if done.returncode not in allowed:
                failures.append(f"{source}: {line}: exit code {done.returncode}\n"
                                f"{done.stdout[:1000]}{done.stderr}")
    return failures + [f"{source}: no command of the page prints: {line}"
                       for line in quoted if not is_printed(line, printed)]


def main():
    palpate, project = (pathlib.Path(path).resolve() for path in sys.argv[1:3])
    commands = all_commands(palpate)
    if not {"run", "replay", "info", "accuracy", "experiment", "experiment plan", "experiment run",
            "experiment merge", "experiment sweep"} <= {" ".join(command) for command in commands}:
        sys.exit(f"subcommands in the help: {commands}")
    sources, quoted = [], {}
    for command in commands:
        name = " ".join(command)
        lines = help_lines(help_of(palpate, command), name or "palpate")
        if not any(f"{name} " in line for line in lines):
            sys.exit(f"the example of {name} does not use the command: {lines}")
        sources.append((" ".join(["palpate", *command, "--help"]), lines))
    for path in (project / "README.md", *sorted((project / "docs").rglob("*.md"))):
        text = path.read_text(encoding="utf-8")
        lines, name = document_lines(text), path.relative_to(project).as_posix()
        quoted[name] = printed_lines(text)
        if lines:
            sources.append((name, lines))
        elif quoted[name]:
            sys.exit(f"{name}: quotes what a command prints, and has no command line")
    if "README.md" not in dict(sources) or not quoted["README.md"]:
        sys.exit("README.md has no command line, or does not quote what it prints")
    failures = [f for source, lines in sources
                for f in run_lines(palpate, project, source, lines, quoted.get(source, ()))]
    for failure in failures:
        print("FAILED", failure)
    print(f"{sum(len(lines) for _, lines in sources)} lines, {len(failures)} failures")
    sys.exit(bool(failures))


main()

#!/usr/bin/env python3
"""Writes the parts of the pages that state what stands in tables of the program.

usage: generate.py PALPATE PROJECT [--check]

PALPATE is the program of a build of PROJECT. The build has the program print_tables, too:

    cmake --build build/release --target palpate print_tables
    docs/generate.py build/release/palpate .

A part stands in a page between `<!-- generated:NAME:begin -->` and `<!-- generated:NAME:end -->`:

    commands       the help of every command
    settings       the settings of a run (engine/session/run_setting.cpp), with the defaults of the help
    material_keys, scene_keys, node_keys
                   the keys of extras.palpate (engine/scene/palpate_extras.schema.json)
    record         the members of a tick's record, with the comments of haptics/include/palpate/record.h

--check writes nothing. It prints what a page has in place of what the program says, and fails.
"""

import collections
import difflib
import json
import pathlib
import re
import subprocess
import sys

PAGES = {
    "commands": "docs/reference/commands.md",
    "settings": "docs/reference/settings.md",
    "material_keys": "docs/reference/materials.md",
    "scene_keys": "docs/reference/materials.md",
    "node_keys": "docs/reference/materials.md",
    "record": "docs/reference/record.md",
}


def run(*command):
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True, timeout=60)
    if done.returncode:
        sys.exit(f"{' '.join(map(str, command))}: failed with {done.returncode}\n{done.stderr}")
    return done.stdout


def plain(text):
    """A text of the program as Markdown that shows it unchanged; code in back quotes stays code."""
    text = re.sub(r"(?<![\w`-])--[a-z][\w-]*(?![\w`])", r"`\g<0>`", text)
    pieces = re.split(r"(`[^`]+`)", text)
    return "".join(piece if piece.startswith("`") else re.sub(r"([\\*<>\[\]]|__)", r"\\\1", piece)
                   for piece in pieces).replace("|", "\\|")


def code(text):
    return "`" + text.replace("|", "\\|") + "`" if text else ""


def table(heading, rows):
    lines = ["| " + " | ".join(heading) + " |", "|" + "---|" * len(heading)]
    return "\n".join(lines + ["| " + " | ".join(row) + " |" for row in rows])


# --- Commands ---

Option = collections.namedtuple("Option", "name meaning default")  # name: "--rate NUMBER"


class Help:
    """The help of one command, in parts."""

    def __init__(self, words, text):
        self.words = words
        self.options = {}  # the rows of each group, by its title
        self.subcommands = []
        self.sentence = ""
        self.usage = ""
        self.example = []
        self.prose = []  # paragraphs, and lists of lines of code
        text = text.partition("\nExit codes: 0;")[0]  # they have a page
        head, _, rest = text.partition("\nUsage: ")
        example, _, sentence = head.partition("\n\n")
        self.example = [line.strip() for line in example.splitlines()[1:]]
        self.sentence = " ".join(sentence.split())
        usage, _, rest = rest.partition("\n")
        self.usage = " ".join(["palpate", *words, "[OPTIONS]" + usage.partition("[OPTIONS]")[2]])
        title, paragraph = None, []
        for line in [*rest.splitlines(), ""]:
            is_code = line.startswith("  ")
            if not line:
                title = None
            elif line.endswith(":") and not is_code and not paragraph and self._is_title(line[:-1], rest):
                title = line[:-1]
                continue
            elif title:
                self._add_row(title, line)
                continue
            if not line or paragraph and paragraph[-1].startswith("  ") != is_code:
                if paragraph:
                    self.prose.append(paragraph)
                paragraph = []
            if line:
                paragraph.append(line)
        self.prose = [part for part in self.prose
                      if not re.match(r"\./run\.sh .*COMMAND --help lists", part[0])]

    @staticmethod
    def _is_title(line, text):
        """A title of a group: rows with a column of meanings follow it."""
        after = text.split(f"{line}:\n", 1)[1].split("\n", 1)[0]
        return bool(re.match(r"  (-\S*|[A-Z]+ TEXT|[a-z]+ {2,}|[A-Z]+ \S+)", after))

    def _add_row(self, title, line):
        indent = len(line) - len(line.lstrip())
        rows = self.options.setdefault(title, [])
        if indent > 4 and rows:  # the meaning of a long name
            rows[-1][1] = (rows[-1][1] + " " + line.strip()).strip()
            return
        # Names are padded to a column; a name that reaches it is followed by one blank.
        match = re.match(r"  (.{27}) (\S.*)", line) or re.match(r"  (.*?\S) {2,}(\S.*)", line)
        name, meaning = (match[1].strip(), match[2]) if match else (line.strip(), "")
        rows.append([name, meaning])

    def finish(self):
        self.subcommands = self.options.pop("Subcommands", [])
        self.options = {title: [option_of(*row) for row in rows if not row[0].startswith("-h,")]
                        for title, rows in self.options.items()}
        return self


def option_of(name, meaning):
    """The row of an option. In the help, `--a4 TEXT:{on,off}=off` states choices and default."""
    name, is_required = re.subn(r" REQUIRED$", "", name.replace(" Needs: SCENE", ""))
    if not name.startswith("-"):
        name = name.replace(" TEXT", "")
    match = re.match(r"(.*?)(?::\{([^}]*)\})?(?:=(.*))?$", name)
    default = ""
    if not name.startswith("--device DRIVER"):
        name, default = match[1], match[3] or ""
        if match[2] and not all(re.search(rf"\b{word}\b", meaning) for word in match[2].split(",")):
            meaning += "; one of " + match[2].replace(",", ", ")
    found = re.search(r" \[([^\]:][^\]]*)\](?=;|$)", meaning)
    text = ""
    if found and not default:
        default, text = "", found[1]
        meaning = meaning[:found.start()] + meaning[found.end():]
    if is_required:
        default, text = "", "required"
    return Option(name, meaning, code(default) if default else plain(text))


def all_helps(palpate, words=()):
    found = Help(words, run(palpate, *words, "--help")).finish()
    helps = [found]
    for name, _ in found.subcommands:
        helps += all_helps(palpate, (*words, name))
    return helps


def shared_options(helps):
    """The options that commands share: to each title, to each option without its default, its defaults."""
    users, titles = {}, {}
    for entry in helps:
        for title, options in entry.options.items():
            for option in options:
                if option.name.startswith("--") and title != "Options":
                    users.setdefault(option[:2], {})[" ".join(entry.words)] = option.default
                    titles.setdefault(option[:2], collections.Counter())[title] += 1
    variants = collections.Counter(name for name, _ in users)
    shared = {}
    for option, defaults in users.items():
        if len(defaults) > 2 or len(defaults) == 2 and variants[option[0]] == 1:
            shared.setdefault(titles[option].most_common(1)[0][0], {})[option] = defaults
    return {title: options for title, options in shared.items() if len(options) > 2}


def default_of(users):
    """The default of a shared option: the most frequent one, and those of other commands."""
    counts = collections.Counter(users.values())
    most = max(counts, key=lambda default: (counts[default], bool(default)))
    others = {}
    for command, default in users.items():
        if default != most:
            others.setdefault(default or "none", []).append(code(command))
    return "; ".join([most or "none"] * bool(most or others) +
                     [f"{', '.join(commands)}: {default}" for default, commands in others.items()])


def heading_of(title):
    return "Group: " + title.split(",")[0]


def slug(heading):
    return re.sub(r"[^\w -]", "", heading.lower()).replace(" ", "-")


def option_rows(options):
    return [(code(option.name), plain(option.meaning), option.default) for option in options]


def command_part(entry, shared):
    words = " ".join(entry.words)
    lines = [f"## {words or 'palpate'}", ""]
    lines += [plain(entry.sentence[:1].upper() + entry.sentence[1:]).rstrip(".") + ".", ""]
    lines += ["```text", entry.usage, "```", ""]
    lines += ["Example:" if len(entry.example) == 1 else "Examples:", "", "```text", *entry.example, "```", ""]
    if entry.subcommands:
        rows = [(f"[{name}](#{slug(' '.join([*entry.words, name]))})", plain(meaning))
                for name, meaning in entry.subcommands]
        lines += [table(("command", "does"), rows), ""]
    own, used = [], {}
    for option in [option for options in entry.options.values() for option in options]:
        title = next((title for title, group in shared.items() if option[:2] in group), None)
        if title:
            used.setdefault(title, []).append(option)
        else:
            own.append(option)
    common = []
    for title, options in used.items():
        names = ", ".join(code(option.name.split()[0]) for option in options)
        common.append(f"[{title.split(',')[0]}](#{slug(heading_of(title))}): "
                      f"{'all' if len(options) == len(shared[title]) else names}")
    if own:
        lines += [table(("option", "meaning", "default"), option_rows(own)), ""]
    if common:
        lines += ["Options of groups:", ""] + ["- " + line for line in common] + [""]
    for part in entry.prose:
        if part[0].startswith("  "):
            lines += ["```text", *(line[2:] for line in part), "```", ""]
        else:
            lines += [plain(" ".join(part)), ""]
    return "\n".join(lines).rstrip("\n")


def commands_part(helps):
    shared = shared_options(helps)
    parts = [*(command_part(entry, shared) for entry in helps),
             "## Options that commands share",
             "A command lists the groups that it has. Where a command has another default, the table names the command."]
    for title, options in shared.items():
        parts.append(f"### {heading_of(title)}")
        if "," in title:
            parts.append(plain(title) + ".")
        parts.append(table(("option", "meaning", "default"),
                           [(code(option[0]), plain(option[1]), default_of(users))
                            for option, users in options.items()]))
    return "\n\n".join(parts)


# --- Settings ---


def settings_part(tables, helps):
    defaults = {option[0].split()[0]: default_of(users)
                for options in shared_options(helps).values() for option, users in options.items()}
    rows = []
    for row in tables["settings"]:
        values = with_unit(row["values"], row["unit"]) or f"in {row['unit']}" * bool(row["unit"])
        default = defaults.get(row["option"])
        meaning = re.sub(r" \[[^\]]+\]$", "", row["meaning"]) if default else row["meaning"]
        rows.append((code(row["option"]), plain(meaning),
                     "; ".join(filter(None, (values, f"default: {default}" * bool(default)))), code(row["key"])))
    return table(("option", "meaning", "values", "key"), rows)


# --- Keys of files ---


def number_text(value):
    return f"{value:g}".replace("e+0", "e") if isinstance(value, float) or abs(value) >= 1e5 else str(value)


def with_unit(values, unit):
    """A range with its unit, which never stands alone on a line: no-break spaces."""
    return values + f" {unit}".rstrip().replace(" ", "\N{NO-BREAK SPACE}") if values else ""


def range_of(schema):
    if "enum" in schema:
        return ", ".join(code(json.dumps(value)) for value in schema["enum"])
    if schema["type"] == "array":
        return "`[x, y, z]`, each " + range_of(schema["items"])
    if "exclusiveMinimum" in schema:
        return f"above {number_text(schema['exclusiveMinimum'])}, to {number_text(schema['maximum'])}"
    return f"{number_text(schema['minimum'])} to {number_text(schema['maximum'])}"


def keys_part(schema):
    rows = []
    for key, value in schema["properties"].items():
        meaning = value["description"]
        for other, needs in schema.get("dependentRequired", {}).items():
            if other == key:
                meaning += " It needs " + " and ".join(code(need) for need in needs) + "."
        if "default" in value:
            meaning += f" Default: {code(json.dumps(value['default']))}."
        rows.append((code(key), plain(meaning), with_unit(range_of(value), value.get("unit", ""))))
    return table(("key", "meaning", "range"), rows)


# --- The record of a tick ---


def record_comments(header):
    """The comment of each member of TickRecord: above it, or behind it."""
    body = re.search(r"^struct TickRecord \{\n(.*?)^\};", header, re.M | re.S)[1]
    comments, above = {}, []
    for line in body.splitlines():
        line = line.strip()
        if line.startswith("//"):
            above.append(line[2:].strip())
            continue
        name = re.search(r"(\w+)(?:\[\d\])?\s*=", line)[1]
        behind = line.partition("//")[2].strip()
        comments[name] = " ".join([*above, behind]).strip()
        above = []
    return comments


# Names of the code in a comment: functions, constants, types and files.
NAMES = r"(?<![`\w:/])(?:(?:\w+::)*\w+\(\)|k[A-Z]\w+|T_\w+|[\w/]+\.h|[A-Z][a-z]+[A-Z]\w+|bearing_parts)"


def record_part(tables, header):
    comments = record_comments(header)
    rows = []
    columns = tables["trace_columns"].split(",")
    for row in sorted(tables["record"], key=lambda row: columns.index(columns_of(row, columns)[0])):
        member = f"`{row['name']}` ({row['count']} {row['type']})".replace("(1 ", "(")
        names = columns_of(row, columns)
        column = ", ".join(code(name if name == names[0] else name[len(row["column"]):]) for name in names)
        unit = "" if row["unit"] == "1" else row["unit"]
        if unit == "rad" and row["column"].endswith("_deg"):
            unit = "rad; trace: deg"
        meaning = comments[row["name"]].removeprefix("session: ")
        if not meaning:
            sys.exit(f"haptics/include/palpate/record.h: TickRecord::{row['name']} has no comment")
        meaning = re.sub(NAMES, r"`\g<0>`", meaning)
        rows.append((column, plain(meaning), ", ".join(filter(None, (unit, row["frame"]))), member))
    return table(("column of a trace", "meaning", "unit, frame", "member"), rows)


def columns_of(row, columns):
    if row["count"] == 1:
        return [row["column"]]
    return [name for name in columns if re.fullmatch(re.escape(row["column"]) + "_[wxyz]", name)]


# --- Pages ---


def put(text, name, part, page):
    """The text of a page with a new part."""
    begin, end = f"<!-- generated:{name}:begin -->", f"<!-- generated:{name}:end -->"
    if text.count(begin) != 1 or text.count(end) != 1:
        sys.exit(f"{page}: has {text.count(begin)} times {begin} and {text.count(end)} times {end}; expected both once")
    before, _, rest = text.partition(begin)
    _, _, after = rest.partition(end)
    return f"{before}{begin}\n\n{part}\n\n{end}{after}"


def main():
    arguments = [word for word in sys.argv[1:] if word != "--check"]
    if len(arguments) != 2:
        sys.exit(__doc__)
    palpate, project = map(pathlib.Path, arguments)
    printer = palpate.resolve().parent / "print_tables"
    if not printer.is_file():
        sys.exit(f"{printer} is missing; build the target print_tables")
    tables = json.loads(run(printer))
    schema = json.loads((project / "engine/scene/palpate_extras.schema.json").read_text(encoding="utf-8"))
    header = (project / "haptics/include/palpate/record.h").read_text(encoding="utf-8")
    helps = all_helps(palpate.resolve())
    parts = {
        "commands": commands_part(helps),
        "settings": settings_part(tables, helps),
        "record": record_part(tables, header),
        **{f"{kind}_keys": keys_part(schema["$defs"][kind]) for kind in ("material", "scene", "node")},
    }
    is_wrong = False
    for page in sorted(set(PAGES.values())):
        old = text = (project / page).read_text(encoding="utf-8")
        for name, part in parts.items():
            if PAGES[name] == page:
                text = put(text, name, part, page)
        if text == old:
            continue
        if "--check" in sys.argv[1:]:
            is_wrong = True
            sys.stdout.writelines(line + "\n" for line in difflib.unified_diff(
                old.splitlines(), text.splitlines(), page, "what the program says", lineterm="", n=0))
        else:
            (project / page).write_text(text, encoding="utf-8")
            print(f"{page}: written")
    if is_wrong:
        sys.exit("pages differ from the program: run docs/generate.py PALPATE PROJECT")


if __name__ == "__main__":
    main()

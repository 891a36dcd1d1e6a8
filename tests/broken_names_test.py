#!/usr/bin/env python3
"""Checks that named_test.py finds each kind of name without an object in a small generated project."""

import pathlib
import tempfile
import unittest

import named_test

TEXT = """# Inside

## The loop's parts

`haptics/loop.h`, `loop.h`, `haptics/*.h`, `haptics` and `loop_test` (in `all_test`); see [parts](#the-loops-parts).
`Loop.Turns` calls `HapticLoop::tick()`. `trials.csv` is a file of a user.
"""

FILES = {
    "docs/inside/loop.md": TEXT,
    "haptics/loop.h": "class HapticLoop { void tick(); };\n",
    "tests/CMakeLists.txt": "palpate_test(all_test SOURCES haptics/loop_test.cpp)\n",
    "tests/haptics/loop_test.cpp": "TEST(Loop, Turns) {}\n",
    "tests/haptics/other_test.cpp": "TEST(Other, Turns) {}\n",
    "benchmarks/CMakeLists.txt": "",
}


def faults(changes):
    """The faults found in the project above after some of its files were replaced or added."""
    with tempfile.TemporaryDirectory() as name:
        project = pathlib.Path(name)
        for path, text in {**FILES, **changes}.items():
            (project / path).parent.mkdir(parents=True, exist_ok=True)
            (project / path).write_text(text)
        return named_test.check(project)


class Names(unittest.TestCase):
    def test_what_exists_may_be_named(self):
        self.assertEqual(faults({}), [])

    def test_what_does_not_exist_is_found(self):
        for name, fault in {"haptics/tick.h": "there is no such file or folder",
                            "tick.h": "there is no such file or folder",
                            "haptics/a4": "there is no such file or folder",
                            "haptics/*.cpp": "there is no such file or folder",
                            "tick_test": "there is no such test or program",
                            "Tick.Turns": "there is no such suite of tests",
                            "Tick.*": "there is no such suite of tests",
                            "HapticLoop::turn()": "no source has turn",
                            "tick_time": "no source has tick_time"}.items():
            self.assertEqual(faults({"haptics/README.md": f"# Haptics\n\nIt has `{name}`.\n"}),
                             [f"haptics/README.md:3: `{name}`: {fault}"])

    def test_a_test_is_in_the_program_that_a_text_names(self):
        for text in ("`other_test` in `all_test`", "`other_test` (in `all_test`)",
                     "`loop_test` and `other_test`\nin `all_test`"):
            self.assertEqual(faults({"haptics/README.md": text + "\n"}),
                             ["haptics/README.md: `other_test` in `all_test`: the program does not contain "
                              "this source"])

    def test_links_lead_to_a_heading(self):
        self.assertEqual(faults({"CHANGELOG.md": "[loop](docs/inside/loop.md#the-loop) and [page](PAGE.md)\n"}),
                         ["CHANGELOG.md:1: links docs/inside/loop.md#the-loop, which is no heading there",
                          "CHANGELOG.md:1: links PAGE.md, which does not exist"])

    def test_headings_have_the_names_that_github_gives(self):
        text = ("# NoH, UaH: `a_b()` + [a page](x.md), *now*\n## Same\n## Same\n##### Deep\n"
                "```text\n# No heading\n```\n")
        self.assertEqual(named_test.anchors(text), ["noh-uah-a_b--a-page-now", "same", "same-1"])

    def test_stubs_are_linked_only_from_the_changelog_and_each_other(self):
        stubs = {"MANUAL.md": "[next](GLOSSARY.md)\n", "GLOSSARY.md": "# Glossary\n",
                 "CHANGELOG.md": "[old](MANUAL.md)\n"}
        self.assertEqual(faults(stubs), [])
        self.assertEqual(faults({**stubs, "docs/start/run.md": "[old](../../MANUAL.md)\n"}),
                         ["docs/start/run.md:1: links ../../MANUAL.md, which only leads on; link the page"])

    def test_pages_for_users_name_sources_by_paths_that_exist(self):
        text = "`haptics/loop.h`, `haptics/tick.h`, `out/trace.csv`, `Tick::none()` and `tick.h`\n"
        self.assertEqual(faults({"docs/reference/record.md": text}),
                         ["docs/reference/record.md:1: `haptics/tick.h`: there is no such file or folder"])

    def test_blocks_of_code_are_not_read(self):
        self.assertEqual(faults({"haptics/README.md": "```\n`tick.h` [x](y.md)\n```\n"}), [])


if __name__ == "__main__":
    unittest.main()

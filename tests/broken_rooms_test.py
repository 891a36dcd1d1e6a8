#!/usr/bin/env python3
"""Checks that rooms_test.py finds each kind of fault in a small generated project."""

import pathlib
import tempfile
import unittest

import rooms_test

TABLE = """# Architecture

| room | holds | may include |
|---|---|---|
| `geometry` | triangles | |
| `haptics/a4` | rotations | `geometry` |
| `haptics` | the loop | `haptics/a4`+ |
"""

FILES = {
    "docs/inside/index.md": TABLE,
    "geometry/triangle.h": "#include <array>\n",
    "haptics/a4/rotation.h": '#include "geometry/triangle.h"\n',
    "haptics/loop.cpp": '#include "haptics/a4/rotation.h"\n#include "geometry/triangle.h"\n',
    "tests/loop_test.cpp": '#include "haptics/a4/rotation.h"\n',
}


def faults(changes, libraries=None):
    """The faults found in the project above after some of its files were replaced or added."""
    with tempfile.TemporaryDirectory() as name:
        project = pathlib.Path(name)
        for path, text in {**FILES, **changes}.items():
            (project / path).parent.mkdir(parents=True, exist_ok=True)
            (project / path).write_text(text)
        return rooms_test.check(project, libraries)


class Rooms(unittest.TestCase):
    def test_public_headers_are_resolved_as_users_include_them(self):
        header = {"haptics/include/palpate/record.h": "#include <cstdint>\n",
                  "geometry/triangle.h": '#include "palpate/record.h"\n'}
        table = TABLE + "| `haptics/include/palpate` | public headers | |\n"
        self.assertEqual(
            faults({**header, "docs/inside/index.md": table}),
            ['geometry/triangle.h:1: geometry may not include haptics/include/palpate '
             '("haptics/include/palpate/record.h")'])
        table = table.replace("| triangles | |", "| triangles | `haptics/include/palpate` |")
        self.assertEqual(faults({**header, "docs/inside/index.md": table}), [])

    def test_includes_that_the_table_permits_are_accepted(self):
        self.assertEqual(faults({}), [])

    def test_an_include_that_the_table_lacks_is_refused(self):
        self.assertEqual(
            faults({"haptics/a4/rotation.h": '\n#include "haptics/loop.h"\n',
                    "haptics/loop.h": ""}),
            ['haptics/a4/rotation.h:2: haptics/a4 may not include haptics ("haptics/loop.h")'])

    def test_a_large_room_needs_a_readme(self):
        files = {f"geometry/file_{i}.h": "" for i in range(rooms_test.MOST_FILES)}
        self.assertEqual(faults(files),
                         ["geometry: has 11 sources and no README.md; expected one in each room "
                          "with more than 10"])
        self.assertEqual(faults({**files, "geometry/README.md": "x\n" * 30}), [])
        self.assertEqual(faults({**files, "geometry/README.md": "x\n" * 31}),
                         ["geometry/README.md: has 31 lines; expected at most 30"])

    def test_a_library_that_links_what_its_room_may_not_include_is_refused(self):
        good = "geo geometry Eigen\na4 haptics/a4 geo\nloop haptics a4 geo\n"
        self.assertEqual(faults({"geometry/triangle.cpp": ""}, good), [])
        self.assertEqual(faults({}, good.replace("a4 geo\nloop", "a4 geo loop\nloop")),
                         ["a4: haptics/a4 may not link haptics (loop)"])
        self.assertEqual(faults({"geometry/triangle.cpp": ""}, good.replace("geo geometry Eigen\n", "")),
                         ["geometry: has .cpp files and no library of its own (palpate_room)"])

    def test_a_cycle_is_refused(self):
        table = TABLE.replace("| triangles | |", "| triangles | `haptics` |")
        self.assertEqual(
            faults({"docs/inside/index.md": table}),
            ["docs/inside/index.md: the table has a cycle: "
             "geometry -> haptics -> haptics/a4 -> geometry"])

    def test_a_file_without_a_room_is_refused(self):
        self.assertEqual(faults({"geometry/mesh/weld.h": ""}),
                         ["geometry/mesh/weld.h: belongs to no room of docs/inside/index.md"])

    def test_an_include_of_a_missing_file_is_refused(self):
        self.assertEqual(
            faults({"tests/loop_test.cpp": '#include "loop.h"\n'}),
            ['tests/loop_test.cpp:1: includes "loop.h", which does not exist in the project\'s root'])

    def test_rooms_without_a_source_and_unknown_permissions_are_refused(self):
        table = TABLE + "| `engine` | scenes | |\n"
        self.assertEqual(faults({"docs/inside/index.md": table}),
                         ["docs/inside/index.md: engine has no source"])
        table = TABLE + "| `engine` | scenes | `haptic`+ |\n"
        self.assertEqual(faults({"docs/inside/index.md": table}),
                         ["docs/inside/index.md: engine may include haptic, which is not a room"])

    def test_a_text_without_a_table_is_refused(self):
        self.assertEqual(faults({"docs/inside/index.md": "# Architecture\n"}),
                         ["docs/inside/index.md: has no table `| room | holds | may include |`"])


if __name__ == "__main__":
    unittest.main()

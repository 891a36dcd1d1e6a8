#!/usr/bin/env python3
"""Breaks the list of files of a recipe in one way at a time; recipes_test.py must say so."""

import unittest

import recipes_test

FILES = {"a/list.cpp", "a/CMakeLists.txt", "a/one.h", "b/two.h", "docs/settings.md"}
RECIPE = """**A thing.** Write a header like `b/two.h`. Also edit:
`kThings` in `a/list.cpp`, which lists them; `a/one.h` or
`b/two.h`, for the member; `a/CMakeLists.txt`, if it has a source. The rest follows from `docs/settings.md`.

**Another.** Also edit: `docs/settings.md`.
"""


def faults(changed, recipe=RECIPE, title="A thing"):
    return recipes_test.list_faults(recipe, title, FILES, set(changed))


class BrokenRecipes(unittest.TestCase):
    def test_right_lists_have_no_fault(self):
        self.assertEqual(faults(["a/list.cpp", "a/one.h"]), [])
        self.assertEqual(faults(["a/list.cpp", "b/two.h", "a/CMakeLists.txt"]), [])
        self.assertEqual(faults(["docs/settings.md"], title="Another"), [])

    def test_a_file_that_the_recipe_does_not_name(self):
        self.assertEqual(faults(["a/list.cpp", "a/one.h", "docs/settings.md"]),
                         ['"A thing": the addition edits docs/settings.md, which its recipe does not name'])

    def test_a_file_that_needs_no_change(self):
        self.assertEqual(faults(["a/one.h"]),
                         ['"A thing": its recipe names a/list.cpp; the addition edits 0 of them'])

    def test_both_of_two_files_or_none(self):
        for changed, count in ((["a/one.h", "b/two.h"], 2), ([], 0)):
            self.assertEqual(faults(["a/list.cpp", *changed]),
                             [f'"A thing": its recipe names a/one.h or b/two.h; the addition edits {count} of them'])

    def test_a_file_that_does_not_exist(self):
        self.assertIn('names no existing file in "`kThings` in `a/lost.cpp`, which lists them"',
                      faults(["a/one.h"], RECIPE.replace("a/list.cpp", "a/lost.cpp"))[0])

    def test_a_recipe_or_a_list_that_is_missing(self):
        self.assertEqual(faults([], title="A lost thing"), ['CONTRIBUTING.md: there is no recipe "A lost thing"'])
        self.assertEqual(faults([], "**A thing.** Write it.\n"),
                         ['CONTRIBUTING.md: the recipe "A thing" has no "Also edit: "'])


if __name__ == "__main__":
    unittest.main()

#!/usr/bin/env python3
"""Breaks blocks of code in one way at a time; code_blocks_test.py must say so."""

import unittest

import code_blocks_test


def faults(text, file="docs/a.md"):
    found = (code_blocks_test.fault(file, language, body, ["palpate::engine"])
             for _, language, body in code_blocks_test.blocks(text))
    return [fault for fault in found if fault]


class Blocks(unittest.TestCase):
    def test_good_blocks_have_no_fault(self):
        self.assertEqual(faults('```\n./run.sh\n```\n\n```json\n{"a": 1}\n```\n\n- a\n\n  ```python\n  a = 1\n  ```\n'
                                "```cmake\ntarget_link_libraries(a palpate::engine)\n```\n```text\nany\n```\n"), [])
        self.assertEqual(faults("```cpp\nint a;\n```\n", "docs/start/program.md"), [])

    def test_each_fault_is_found(self):
        for text, fault in {
            "```\n0.5 s: contact\n```\n": "has no language and no command line: '0.5 s: contact'; use text",
            "```json\n{'a': 1}\n```\n": "is no JSON",
            "```python\na = = 1\n```\n": "is no Python",
            "```cpp\nint a;\n```\n": "is C++ that no test compiles",
            "```cmake\nlink(palpate::none)\n```\n": "names palpate::none, which is no target",
            "```none\na\n```\n": "has the language none, of which this test knows nothing",
            "```{figure} a.svg\n```\n": "has the directive {figure}",
        }.items():
            found = faults(text)
            self.assertEqual(len(found), 1, text)
            self.assertTrue(found[0].startswith(fault), found)

    def test_the_program_of_the_readme_is_short(self):
        self.assertEqual(faults("```cpp\n" + "int a;\n" * 31 + "```\n", "README.md"),
                         ["has 31 lines; expected at most 30"])


if __name__ == "__main__":
    unittest.main()

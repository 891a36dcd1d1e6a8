#!/usr/bin/env python3
"""Runs a test of the page of `palpate view` in Node.

run_in_node.py types PROJECT BUILD              checks the types of the page
run_in_node.py logic PROJECT BUILD TEST.ts      bundles the test with the page, and runs it
run_in_node.py browser PROJECT BUILD TEST.mjs [PROGRAM...]
                                                runs a test that opens the page in Chromium
run_in_node.py desktop PROJECT BUILD TEST.mjs [PROGRAM...]
                                                the same, in a window of a desktop (Xvfb)
run_in_node.py pictures PROJECT BUILD FOLDER PROGRAM
                                                makes the pictures of the README in the folder
run_in_node.py frames PROJECT BUILD FOLDER PROGRAM WRITE_MESH
                                                measures frames; writes FOLDER/frames.json
run_in_node.py pointer PROJECT BUILD FOLDER PROGRAM
                                                measures the way of a motion; writes FOLDER/pointer.json

Is not run where Node, the packages, the bundled page or Chromium is missing: setup.sh fetches them for
`./run.sh view` and for .ci/run.
"""

import os
import pathlib
import shutil
import subprocess
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "helpers"))
from browser import need_browser  # noqa: E402
from needs import need  # noqa: E402


def require(path, what):
    need(path.exists(), f"{what} ({path.name}), which ./run.sh view and .ci/run make")
    return path


def run(node, *arguments, **options):
    return subprocess.run([node, *map(str, arguments)], **options).returncode


def logic(node, work, test):
    with tempfile.TemporaryDirectory() as name:
        bundle = pathlib.Path(name) / "test.mjs"
        failed = run(node, work / "node_modules/esbuild/bin/esbuild", test, "--bundle",
                     "--platform=node", "--format=esm", "--log-level=warning",
                     f"--alias:@page={work}", f"--outfile={bundle}",
                     env={**os.environ, "NODE_PATH": str(work / "node_modules")})
        return failed or run(node, "--test", bundle)


def need_desktop():
    """What desktop.mjs starts."""
    for program, package in (("Xvfb", "xvfb"), ("evilwm", "evilwm"), ("xdotool", "xdotool")):
        need(shutil.which(program), f"{program}: apt-get install {package}")


def browser(node, project, build, script, programs, is_test=True):
    chromium = need_browser()
    packages = require(project / "build/browser_packages/node_modules/playwright-core", "the driver of a browser")
    require(build / "page/page.js", "the page")
    only = os.environ.get("PALPATE_ONLY")  # runs the tests whose names match
    pattern = [f"--test-name-pattern={only}"] if only else []
    os.environ.update({
        "PALPATE_CHROMIUM": chromium, "PALPATE_DRIVER": str(packages),
        "PALPATE_PROJECT": str(project), "PALPATE_PROGRAMS": os.pathsep.join(map(os.path.abspath, programs)),
        "PALPATE_PICTURES": str(build / "page_pictures"), "PALPATE_BUILD": str(build)})
    # Replaces this process, so that a signal reaches the test, which ends its programs.
    sys.stdout.flush()
    os.execv(node, [node, *(["--test", *pattern] if is_test else []), str(script)])


def main():
    kind, project, build, *rest = sys.argv[1:]
    project, build = pathlib.Path(project).resolve(), pathlib.Path(build).resolve()
    node = shutil.which("node")
    need(node, "Node, which ./run.sh view installs")
    work = build / "page_build"
    if kind in ("desktop", "pointer"):
        need_desktop()
    if kind in ("browser", "desktop"):
        return browser(node, project, build, rest[0], rest[1:])
    scripts = {"pictures": "make_pictures.mjs", "frames": "measure_frames.mjs",
               "pointer": "measure_pointer.mjs"}
    if kind in scripts:
        os.environ["PALPATE_FOLDER"] = os.path.abspath(rest[0])
        script = pathlib.Path(__file__).resolve().parent / "browser" / scripts[kind]
        return browser(node, project, build, script, rest[1:], is_test=False)
    require(work / "node_modules/three", "the bundled page")
    require(work / "record.ts", "the bundled page")
    if kind == "types":
        return run(node, work / "node_modules/typescript/bin/tsc", "--noEmit", "-p", work)
    return logic(node, work, rest[0])


if __name__ == "__main__":
    sys.exit(main())

#!/usr/bin/env python3
"""Runs `palpate info --json` on every .gltf and .glb below a folder and judges the answers.

usage: corpus_test.py PROGRAM DEFAULT_FOLDER [--sanitized]

PALPATE_CORPUS or the default names the folder; without it the test is skipped (exit code 77).
Each file must be read, or refused with exit code 2 and one line. The line's reason must be known to
this test, and must be true if the test can verify it in the file. A crash, a sanitizer report, more
than 5 s of processor time or more memory than allowed below fails the test. INDEX.tsv in the folder
may name the kind of each file after a tab. A file of kind "real" must be read, unless its reason is
verified or no reader could accept the file.
"""

import base64
import collections
import concurrent.futures
import json
import os
import pathlib
import re
import signal
import struct
import subprocess
import sys
import tempfile
import threading
import urllib.parse

SKIPPED = 77
WORKERS = 2
SECONDS = 5  # of processor time
SANITIZED_SECONDS = 60  # sanitizers slow the program several times
WAITING = 12  # a child that sleeps is killed after this many times SECONDS
BASE_BYTES = 64 << 20
BYTES_PER_BYTE = 40

# Reasons, in the order of the search: the first whose expression occurs in the message applies.
REASONS = [
    ("no regular file, or it cannot be opened", r"cannot be opened|is not a regular file|is a folder"),
    ("buffer is a Git LFS pointer", r"Git LFS pointer"),
    ("buffer outside the folder, or not a path", r"leads out of the folder|not a relative path|is not relative|broken escape"),
    ("buffer without data", r"/buffers/\d+: has no uri"),
    ("buffer too short", r"/buffers/\d+/byteLength: is"),
    ("data URI", r"/buffers/\d+/uri: the data URI"),
    ("not glTF", r"begins neither like|^is empty|is text in UTF-"),
    ("glTF 1.0 or no version", r"/asset/(version|minVersion)|GLB header: its version"),
    ("required extension", r"/extensionsRequired/\d+: requires the extension"),
    ("GLB container", r"GLB (header|chunk \d+): "),
    ("JSON text", r"^JSON"),
    ("limit", r"at most \d+|deeper than|can still be read|not enough memory|reaches farther"),
    ("no data", r"has neither bufferView nor sparse"),
    ("no triangle", r"the scene has no triangle|no node has a triangle with area"),
    ("nodes", r"/nodes/\d+\S*: |is reached twice"),
    ("indices", r"/indices: index|largest of its type"),
    ("position not finite", r"is not finite"),
    ("sparse", r"/sparse"),
    ("views and accessors", r"/(bufferViews|accessors)(/\d+\S*)?: "),
    ("meshes", r"/meshes(/\d+\S*)?: "),
    ("scenes", r"/scenes?(/\d+\S*)?: "),
    ("extensions", r"/extensions\w*(/\S*)?: "),
    ("skins", r"/skins(/\d+\S*)?: "),
    ("animations", r"/animations(/\d+\S*)?: "),
    ("buffers", r"/buffers(/\d+\S*)?: "),
    ("materials", r"/materials(/\d+\S*)?: "),
]
# A real file may be refused for these reasons without verification.
EXCUSES = {"buffer is a Git LFS pointer", "buffer without data", "no triangle"}

Answer = collections.namedtuple("Answer", "code signal timed_out peak_bytes out err")


def run(program, path, seconds):
    """Reads one file in a child process; measures its peak memory."""
    with tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as err:
        limit = f"ulimit -St {seconds}; exec \"$@\""  # beyond it SIGXCPU
        child = subprocess.Popen(["sh", "-c", limit, "sh", program, "info", "--json", path],
                                 stdin=subprocess.DEVNULL, stdout=out, stderr=err)
        timed_out = threading.Event()

        def end():
            timed_out.set()
            child.kill()

        timer = threading.Timer(WAITING * seconds, end)
        timer.start()
        _, status, usage = os.wait4(child.pid, 0)
        timer.cancel()
        child.returncode = status  # wait4() has reaped the child; subprocess must not wait again
        out.seek(0)
        err.seek(0)
        return Answer(os.waitstatus_to_exitcode(status), os.WIFSIGNALED(status) and status & 0x7F,
                      timed_out.is_set(), usage.ru_maxrss * 1024, out.read(),
                      err.read().decode("utf-8", "replace"))


def json_text(path):
    """The bytes of the JSON of a .gltf or .glb; None if the file has no JSON."""
    data = path.read_bytes()
    if data[:4] != b"glTF":
        return data
    if len(data) < 20:
        return None
    length = struct.unpack("<I", data[12:16])[0]
    return data[20:20 + length]  # glTF 1.0 has its JSON at the same place


def parsed(path):
    try:
        root = json.loads(json_text(path))
        return root if isinstance(root, dict) else {}
    except (TypeError, ValueError, RecursionError):
        return {}


def at(container, index):
    try:
        return container[index]
    except (IndexError, KeyError, TypeError):
        return {}


COMPONENT_BYTES = {5120: 1, 5121: 1, 5122: 2, 5123: 2, 5125: 4, 5126: 4}
COMPONENTS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}


def instances_of(node, accessors):
    """How often a node shows its mesh."""
    extension = node.get("extensions", {}).get("EXT_mesh_gpu_instancing")
    if not extension:
        return 1
    counts = [at(accessors, a).get("count", 0) for a in extension.get("attributes", {}).values()]
    return max(counts, default=1)


def referenced_bytes(root):
    """Decoded bytes of the geometry of an asset; every reference counts."""
    accessors = root.get("accessors", [])
    total = 0

    def count(accessor):
        nonlocal total
        accessor = at(accessors, accessor)
        total += (accessor.get("count", 0) * COMPONENT_BYTES.get(accessor.get("componentType"), 4) *
                  COMPONENTS.get(accessor.get("type"), 1))

    # A mesh is referred to by each node, and by each instance of a node: all may differ in scale.
    uses = collections.Counter()
    for node in root.get("nodes", []):
        uses[node.get("mesh")] += instances_of(node, accessors)
    for number, mesh in enumerate(root.get("meshes", [])):
        for primitive in uses[number] * mesh.get("primitives", []):
            for attributes in [primitive.get("attributes", {})] + primitive.get("targets", []):
                for name, accessor in attributes.items():
                    if re.match(r"POSITION|JOINTS|WEIGHTS", name):
                        count(accessor)
            if "indices" in primitive:
                count(primitive["indices"])
    for skin in root.get("skins", []):
        count(skin.get("inverseBindMatrices"))
    for animation in root.get("animations", []):
        for sampler in animation.get("samplers", []):
            count(sampler.get("input"))
            count(sampler.get("output"))
    for node in root.get("nodes", []):
        extension = node.get("extensions", {}).get("EXT_mesh_gpu_instancing", {})
        for accessor in extension.get("attributes", {}).values():
            count(accessor)
    return total


def source_bytes(path, root):
    """Bytes of the file and of the files that it names."""
    total = path.stat().st_size
    for buffer in root.get("buffers", []):
        uri = buffer.get("uri", "data:")
        if not uri.startswith("data:"):
            total += buffer.get("byteLength", 0)
    return total


def buffer_bytes(path, root, number):
    """The bytes of a buffer: BIN chunk, data URI or file."""
    uri = at(root["buffers"], number).get("uri")
    if uri is None:
        data = path.read_bytes()
        return data[20 + struct.unpack("<I", data[12:16])[0] + 8:]
    if uri.startswith("data:"):
        text = uri.split(",", 1)[1]
        return base64.b64decode(text + "=" * (-len(text) % 4))
    return (path.parent / urllib.parse.unquote(uri)).read_bytes()


def has_wrong_index(path, root):
    """Whether any primitive has an index beyond its vertices, or the restart index."""
    for mesh in root["meshes"]:
        for primitive in mesh["primitives"]:
            indices = at(root["accessors"], primitive.get("indices"))
            vertices = at(root["accessors"], primitive["attributes"].get("POSITION"))
            if "bufferView" not in indices or "count" not in vertices:
                continue
            view = root["bufferViews"][indices["bufferView"]]
            size = COMPONENT_BYTES[indices["componentType"]]
            start = view.get("byteOffset", 0) + indices.get("byteOffset", 0)
            data = buffer_bytes(path, root, view["buffer"])[start:start + size * indices["count"]]
            values = memoryview(data).cast({1: "B", 2: "H", 4: "I"}[size])
            if max(values) >= min(vertices["count"], 256 ** size - 1):
                return True
    return False


def has_wrong_node_ids(root):
    """Whether an id of a scene or node is out of range, or a node has two parents."""
    nodes = range(len(root.get("nodes", [])))
    children = [child for node in root.get("nodes", []) for child in node.get("children", [])]
    roots = [node for scene in root.get("scenes", []) for node in scene.get("nodes", [])]
    return (len(set(children)) < len(children) or any(id not in nodes for id in children + roots) or
            root.get("scene", 0) not in range(max(1, len(root.get("scenes", [])))))


def walk(value, pointer):
    """The value at a JSON pointer; None if it does not exist."""
    for key in pointer.split("/"):
        try:
            value = at(value, int(key) if isinstance(value, list) else key)
        except (KeyError, ValueError, TypeError):
            return None
    return value


def is_wrong_id(message, root):
    """Whether the id that a message names is out of range."""
    match = re.match(r"/(\S+): is .*; expected an index into /(\S+),", message)
    if not match:
        return None
    value, target = walk(root, match[1]), walk(root, match[2])
    return type(value) is not int or value not in range(len(target or []))


def is_true(reason, message, path, root):
    """Whether the file confirms the reason; None if this test cannot verify it."""
    if "expected an index into /" in message:
        return is_wrong_id(message, root)
    if reason == "required extension":
        index = re.search(r"/extensionsRequired/(\d+): requires the extension \"(.*?)\"", message)
        return at(root.get("extensionsRequired"), int(index[1])) == index[2]
    if reason == "glTF 1.0 or no version":
        return not str(at(root.get("asset", {}), "version")).startswith("2.")
    if reason == "no regular file, or it cannot be opened":
        uri = at(root.get("buffers"), int(re.match(r"/buffers/(\d+)/uri", message)[1])).get("uri")
        return not (path.parent / urllib.parse.unquote(uri)).is_file()
    if reason == "no data":
        accessor = at(root.get("accessors"), int(re.match(r"/accessors/(\d+)", message)[1]))
        return "bufferView" not in accessor and "sparse" not in accessor
    if reason == "indices":
        return has_wrong_index(path, root)
    if reason in ("nodes", "scenes"):
        return has_wrong_node_ids(root) or None
    return None


def reason_of(message):
    return next((name for name, expression in REASONS if re.search(expression, message)), None)


def kinds_in(folder):
    try:
        lines = (folder / "INDEX.tsv").read_text().splitlines()
    except OSError:
        return {}
    return {line.split("\t")[0]: line.split("\t")[1] for line in lines if "\t" in line}


class Judge:
    def __init__(self, sanitized):
        self.sanitized = sanitized
        self.failures = []
        self.table = collections.Counter()
        self.largest = (0.0, "no file")  # share of the allowed memory

    def fail(self, name, text):
        self.failures.append(f"{name}: {text}")

    def judge(self, name, path, answer, kind):
        if answer.timed_out or answer.signal == signal.SIGXCPU:
            return self.fail(name, "does not terminate")
        if answer.signal or answer.code not in (0, 2) or "Sanitizer" in answer.err or \
                "runtime error" in answer.err:
            return self.fail(name, f"exit code {answer.code}\n{answer.err[-2000:]}")
        try:
            root = parsed(path)
            self.judge_memory(name, path, root, answer)
        except (AttributeError, TypeError, OverflowError):
            root = {}  # not a glTF structure: no expected size
        if answer.code == 0:
            json.loads(answer.out)
            return self.count("read", kind)
        message = answer.err.removeprefix(f"palpate: {path}: ")
        if message.count("\n") != 1:
            self.fail(name, f"its error is not one line: {message}")
        reason = reason_of(message)
        if reason is None:
            return self.fail(name, f"refused for an unknown reason: {message}")
        try:
            truth = is_true(reason, message, path, root)
        except (AttributeError, KeyError, LookupError, TypeError, ValueError):
            truth = None  # the file lacks the expected structure
        if truth is False:
            self.fail(name, f"refused for a false reason: {message}")
        if kind == "real" and not truth and reason not in EXCUSES:
            self.fail(name, f"a real file is refused: {message}")
        self.count(reason, kind)

    def judge_memory(self, name, path, root, answer):
        if self.sanitized:
            return
        allowed = BASE_BYTES + BYTES_PER_BYTE * referenced_bytes(root) + source_bytes(path, root)
        share = answer.peak_bytes / allowed
        self.largest = max(self.largest, (share, name))
        if share > 1:
            self.fail(name, f"takes {answer.peak_bytes >> 20} MiB; expected {allowed >> 20} or less")

    def count(self, reason, kind):
        self.table[reason, kind] += 1

    def print_table(self):
        kinds = sorted({kind for _, kind in self.table})
        print(f"{'':42}" + "".join(f"{kind:>14}" for kind in kinds))
        for reason in ["read"] + [name for name, _ in REASONS]:
            counts = [self.table[reason, kind] for kind in kinds]
            if any(counts):
                print(f"{reason:42}" + "".join(f"{count:>14}" for count in counts))
        if not self.sanitized:
            print(f"largest share of the memory allowed: {self.largest[0]:.0%}, {self.largest[1]}")


def main(program, default_folder, sanitized):
    folder = pathlib.Path(os.environ.get("PALPATE_CORPUS") or default_folder)
    if not folder.is_dir():
        print(f"skipped: there is no folder {folder}; name one by PALPATE_CORPUS")
        return SKIPPED
    paths = sorted(path for path in folder.rglob("*") if path.suffix in (".gltf", ".glb"))
    kinds = kinds_in(folder)
    seconds = SANITIZED_SECONDS if sanitized else SECONDS
    # All runs come first: a child's peak includes the memory of its parent, which judging enlarges.
    with concurrent.futures.ThreadPoolExecutor(WORKERS) as pool:
        answers = list(pool.map(lambda path: run(program, str(path), seconds), paths))
    judge = Judge(sanitized)
    for path, answer in zip(paths, answers):
        name = str(path.relative_to(folder))
        judge.judge(name, path, answer, kinds.get(name, "other"))
    judge.print_table()
    for failure in judge.failures:
        print("FAILED", failure)
    print(f"{len(paths)} files, {len(judge.failures)} failures")
    return 1 if judge.failures else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1], sys.argv[2], "--sanitized" in sys.argv[3:]))

#!/usr/bin/env python3
"""What building costs, by part of the tree.

    build_time.py log BUILD [--dearest 20]            from ninja's log: seconds of wall time that passed
                                                      while each output was made
    build_time.py compare BEFORE AFTER [--every 6]    compiles every sixth source of each target of two
                                                      build folders in turn, and compares processor
                                                      seconds; a busy machine slows both alike
    build_time.py combined BUILD [--every 6]          compiles every sixth combined file, and in turn the
                                                      sources that it stands for, one by one

The folders of `compare` are configured, and their precompiled headers are built. Half of the processor
seconds is the least time that two cores need.
"""
import argparse
import collections
import json
import pathlib
import re
import resource
import shlex
import subprocess
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "scripts"))
from compile_commands import each_source  # noqa: E402


def group(output):
    """The row of the table that an object counts in."""
    if output.endswith(".gch") or output.endswith(".pch"):
        return "precompiled headers"
    if "CMakeFiles/" not in output or not output.endswith(".o"):
        return "libraries, links, other steps"
    folder, rest = output.split("CMakeFiles/", 1)
    target = rest.split(".dir/")[0]
    if "threads" in target:
        return "tests, thread sanitizer"
    if folder.startswith("tests/"):
        room = target.split("_")[0] if target.startswith("core_") else folder.split("/")[1] or "core"
        return f"tests, {room}"
    return folder.split("/")[0]


def table(rows, columns):
    """Prints {name: numbers} as Markdown, the largest first."""
    print("| " + " | ".join(["part", *columns]) + " |")
    print("|---" * (len(columns) + 1) + "|")
    total = [sum(column) for column in zip(*rows.values())]
    for name, numbers in [*sorted(rows.items(), key=lambda row: -row[1][-1]), ("all", total)]:
        cells = [f"{n:.0f}" if float(n).is_integer() else f"{n:.1f}" for n in numbers]
        print("| " + " | ".join([name, *cells]) + " |")


def log(build, dearest):
    spans = {}
    for line in (build / ".ninja_log").read_text().splitlines()[1:]:
        start, end, _, output, _ = line.split("\t")
        spans[output.removeprefix(f"{build.resolve()}/")] = (int(end) - int(start)) / 1000
    rows = collections.defaultdict(lambda: [0, 0.0])
    for output, seconds in spans.items():
        rows[group(output)][0] += 1
        rows[group(output)][1] += seconds
    table(rows, ["outputs", "s"])
    print()
    for output, seconds in sorted(spans.items(), key=lambda item: -item[1])[:dearest]:
        print(f"{seconds:8.1f} s  {output}")


def without_launcher(entry):
    """(the compiler's words, their folder) of an entry of compile_commands.json, without ccache."""
    words = shlex.split(entry["command"])
    compiler = re.compile(r"(.*/)?(c\+\+|cc|g\+\+|gcc|clang\S*)")
    return words[next(i for i, w in enumerate(words) if compiler.fullmatch(w)):], entry["directory"]


def commands(build):
    """{target: {object: (command, folder)}} of the C and C++ sources and precompiled headers."""
    found = collections.defaultdict(dict)
    for entry in json.loads((build / "compile_commands.json").read_text()):
        words, folder = without_launcher(entry)
        output = words[words.index("-o") + 1]
        found[output.split(".dir/")[0]][output] = (words, folder)
    return found


def cost(command, scratch):
    """Processor seconds of a compiler's run whose object is thrown away."""
    words, folder = command
    words = [str(scratch) if word == words[words.index("-o") + 1] else word for word in words]
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run(words, cwd=folder, check=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def compare(before, after, every):
    sides = [commands(before), commands(after)]
    rows = collections.defaultdict(lambda: [0, 0.0, 0, 0.0])
    with tempfile.TemporaryDirectory() as folder:
        scratch = pathlib.Path(folder) / "out.o"
        for target in sorted({*sides[0], *sides[1]}):
            for side, found in enumerate(sides):
                headers = [o for o in found[target] if group(o) == "precompiled headers"]
                objects = sorted(o for o in found[target] if o not in headers)
                sample = objects[len(objects) // 2 % every::every] or objects[:1]
                for chosen, whole in ((sample, objects), (headers, headers)):
                    seconds = [cost(found[target][o], scratch) for o in chosen]
                    if chosen:
                        row = rows[group(whole[0])]
                        row[2 * side] += len(whole)
                        row[2 * side + 1] += sum(seconds) / len(chosen) * len(whole)
    table(rows, ["files before", "s before", "files after", "s after"])


def combined(build, every):
    entries = json.loads((build / "compile_commands.json").read_text())
    rows = collections.defaultdict(lambda: [0, 0.0, 0, 0.0])
    together = [(entry, list(each_source([entry]))) for entry in entries]
    together = [(entry, sources) for entry, sources in together if len(sources) > 1]
    with tempfile.TemporaryDirectory() as folder:
        scratch = pathlib.Path(folder) / "out.o"
        for entry, sources in together[::every]:
            row = rows[group(shlex.split(entry["command"])[-3])]
            for column, parts in ((0, sources), (2, [entry])):
                row[column] += len(parts)
                row[column + 1] += sum(cost(without_launcher(part), scratch) for part in parts)
    table(rows, ["files alone", "s alone", "files combined", "s combined"])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    tasks = parser.add_subparsers(dest="task", required=True)
    task = tasks.add_parser("log")
    task.add_argument("build", type=pathlib.Path)
    task.add_argument("--dearest", type=int, default=20)
    task = tasks.add_parser("compare")
    task.add_argument("before", type=pathlib.Path)
    task.add_argument("after", type=pathlib.Path)
    task.add_argument("--every", type=int, default=6)
    task = tasks.add_parser("combined")
    task.add_argument("build", type=pathlib.Path)
    task.add_argument("--every", type=int, default=6)
    options = vars(parser.parse_args())
    {"log": log, "compare": compare, "combined": combined}[options.pop("task")](**options)


if __name__ == "__main__":
    main()

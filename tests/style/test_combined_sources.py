"""Several source files compiled as one: names of their own do not meet, and each keeps its command."""
import json
import pathlib
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "cmake"), str(ROOT / "scripts")]
from combine_tests import combined  # noqa: E402
from compile_commands import write_commands  # noqa: E402

HEADER = """#pragma once
namespace tactus::reed { struct Valve { int closed = 1; }; }
"""
FIRST = """#include "valve.hpp"
#include <vector>
namespace { int helper() { return tactus::reed::Valve{}.closed; } }
int checks_first() { return helper() + static_cast<int>(std::vector<int>(2).size()); }
"""
SECOND = """#include "valve.hpp"
#include <cmath>
namespace tactus::reed {
namespace { int helper() { return Valve{}.closed + tactus::reed::Valve{}.closed; } }
int checks_second() { return helper() + static_cast<int>(std::sqrt(4.0)); }
}
"""


def write(folder):
    (folder / "valve.hpp").write_text(HEADER)
    for name, text in (("first.cpp", FIRST), ("second.cpp", SECOND)):
        (folder / name).write_text(text)
    return [folder / "first.cpp", folder / "second.cpp"]


def test_files_with_the_same_names_run_in_one_program(tmp_path):
    sources = write(tmp_path)
    main = "int main() { return file_0::checks_first() * 10 + file_1::tactus::reed::checks_second(); }\n"
    (tmp_path / "all.cpp").write_text(combined(sources) + main)
    subprocess.run(["c++", "-std=c++20", "-Wall", "-Wextra", "-Wshadow", "-Werror", "-I", tmp_path,
                    tmp_path / "all.cpp", "-o", tmp_path / "all"], check=True)
    assert subprocess.run([tmp_path / "all"], check=False).returncode == 3 * 10 + 4


def test_each_header_is_included_once_before_the_files(tmp_path):
    lines = combined(write(tmp_path)).splitlines()
    assert lines[:3] == ['#include "valve.hpp"', "#include <vector>", "#include <cmath>"]
    assert lines.count('#include "valve.hpp"') == 1


def test_every_combined_file_keeps_a_command_of_its_own(tmp_path):
    together, alone = tmp_path / "unity_0.cxx", tmp_path / "alone.cpp"
    together.write_text('/* made */\n#include "/src/a.cpp"\n\n#include "/src/b.cpp"\n')
    alone.write_text('#include "a.hpp"\n')
    (tmp_path / "compile_commands.json").write_text(json.dumps(
        [{"directory": "/b", "file": str(path), "command": f"g++ -O3 -o {path.name}.o -c {path}"}
         for path in (together, alone)]))
    entries = json.loads(write_commands(tmp_path).read_text())
    assert [(entry["file"], entry["command"]) for entry in entries] == [
        ("/src/a.cpp", "g++ -O3 -o unity_0/a.cpp.o -c /src/a.cpp"),
        ("/src/b.cpp", "g++ -O3 -o unity_0/b.cpp.o -c /src/b.cpp"),
        (str(alone), f"g++ -O3 -o alone.cpp.o -c {alone}")]

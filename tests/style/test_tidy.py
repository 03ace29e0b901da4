"""scripts/tidy with a stand-in for clang-tidy: what it checks again, and what it does not."""
import importlib.machinery
import importlib.util
import json
import pathlib
import shutil
import subprocess
import sys

import pytest

SCRIPT = pathlib.Path(__file__).resolve().parents[2] / "scripts" / "tidy"
STAND_IN = """#!/bin/sh
[ "$1" = --version ] && { echo stand-in; exit 0; }
for file; do :; done
echo "$file" >> "$(dirname "$0")/checked"
! grep -H bad "$file"
"""


@pytest.fixture(name="run_tidy")
def in_small_checkout(tmp_path, monkeypatch, capsys):
    """A function that runs the script on a checkout of two sources: (status, names checked, output)."""
    loader = importlib.machinery.SourceFileLoader("tidy", str(SCRIPT))
    module = importlib.util.module_from_spec(importlib.util.spec_from_loader("tidy", loader))
    loader.exec_module(module)
    tool = tmp_path / "clang-tidy"
    tool.write_text(STAND_IN)
    tool.chmod(0o755)
    root = tmp_path / "root"
    (root / "core").mkdir(parents=True)
    (root / "build").mkdir()
    (root / ".clang-tidy").write_text("Checks: some\n")
    (root / ".gitignore").write_text("/build/\n")
    (root / "core/a.hpp").write_text("int a();\n")
    (root / "core/a.cpp").write_text('#include "core/a.hpp"\n')
    (root / "core/b.cpp").write_text("int b;\n")
    (root / "build/compile_commands.json").write_text(json.dumps(
        [{"file": str(root / "core" / name), "command": "g++", "directory": str(root)}
         for name in ("a.cpp", "b.cpp")]))
    for name, value in (("ROOT", root), ("TOOL", str(tool)), ("TOOL_WORDS", [str(tool)])):
        monkeypatch.setattr(module, name, value)

    def run(*words):
        module.digest_and_includes.cache_clear()
        monkeypatch.setattr(sys, "argv", ["tidy", "--build", str(root / "build"), *words])
        (tmp_path / "checked").unlink(missing_ok=True)
        status = module.main()
        checked = tmp_path / "checked"
        names = {pathlib.Path(line).name for line in checked.read_text().split()} if checked.exists() else set()
        return status, names, capsys.readouterr().out

    run.root = root
    return run


def commit(root):
    for words in (["init", "-qb", "main"], ["add", "-A"],
                  ["-c", "user.name=a", "-c", "user.email=a@b", "commit", "-qm", "a"]):
        subprocess.run(["git", "-C", str(root), *words], check=True)


def test_a_clean_file_is_checked_once_and_again_when_its_header_changes(run_tidy):
    assert run_tidy()[:2] == (0, {"a.cpp", "b.cpp"})
    assert run_tidy()[:2] == (0, set())
    (run_tidy.root / "core/a.hpp").write_text("int a(int);\n")
    assert run_tidy()[:2] == (0, {"a.cpp"})
    (run_tidy.root / ".clang-tidy").write_text("Checks: others\n")
    assert run_tidy()[:2] == (0, {"a.cpp", "b.cpp"})


def test_a_finding_fails_every_time(run_tidy):
    (run_tidy.root / "core/b.cpp").write_text("bad\n")
    for checked in ({"a.cpp", "b.cpp"}, {"b.cpp"}):
        status, names, output = run_tidy()
        assert (status, names) == (1, checked) and "bad" in output


@pytest.mark.skipif(not shutil.which("git"), reason="git is missing")
def test_only_what_changed_is_checked_with_the_user_of_a_changed_header(run_tidy):
    commit(run_tidy.root)
    (run_tidy.root / "core/a.hpp").write_text("int a(int);\n")
    assert run_tidy("--changed", "HEAD")[:2] == (0, {"a.cpp"})
    assert run_tidy("--changed", "HEAD")[:2] == (0, set())
    (run_tidy.root / "core/b.cpp").write_text("bad\n")
    assert run_tidy("--changed", "HEAD")[:2] == (1, {"b.cpp"})


def test_a_limit_names_what_is_left_and_goes_on_there(run_tidy):
    status, names, output = run_tidy("--limit", "1")
    assert (status, names) == (0, {"a.cpp"}) and "1 files are left" in output and "b.cpp" in output
    assert run_tidy("--limit", "1")[:2] == (0, {"b.cpp"})


def test_without_history_it_says_that_it_checks_nothing(run_tidy):
    status, names, output = run_tidy("--changed")
    assert (status, names) == (0, set()) and "no history" in output

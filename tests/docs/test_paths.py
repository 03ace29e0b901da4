"""Every file of the repository that a page of docs/ or a README names exists."""
import pathlib
import re
import subprocess

ROOT = pathlib.Path(__file__).resolve().parents[2]
ROOMS = "core|files|fem|devices|net|pd|max|externals|programs|patches|help|tests|bench|packaging|data|scripts|cmake"
NAMED = re.compile(rf"`((?:{ROOMS})/[\w~./-]+)`")


def tracked(*patterns):
    return subprocess.run(["git", "ls-files", *patterns], cwd=ROOT, stdout=subprocess.PIPE, text=True,
                          check=True).stdout.split()


def exists(path):
    """A file, a folder, or a header and source named without their ending; NAME stands for any."""
    named = ROOT / path.rstrip("/.")
    return "NAME" in path or named.exists() or named.with_name(named.name + ".hpp").exists()


def test_the_pages_name_files_that_exist():
    pages = [name for name in tracked("*.md") if name != "CHANGELOG.md"]
    assert "docs/architecture.md" in pages
    missing = [f"{page}: {path}" for page in pages for path in NAMED.findall((ROOT / page).read_text())
               if not exists(path)]
    assert not missing, "\n".join(missing)


def test_every_folder_of_tests_is_in_their_readme():
    text = (ROOT / "tests" / "README.md").read_text()
    folders = {name.split("/")[1] for name in tracked("tests") if name.count("/") > 1}
    assert not {folder for folder in folders if f"`{folder}/`" not in text}


def test_scripts_that_need_debians_packages_ask_for_debians_python():
    """Another Python may come first in PATH, and has no numpy."""
    needs = re.compile(r"^(?:import|from) (?:numpy|scipy|matplotlib|PIL)\b", re.M)
    texts = {name: (ROOT / name).read_text(errors="replace") for name in tracked("*.py", "scripts")
             if (ROOT / name).is_file()}
    assert not [name for name, text in texts.items()
                if text.startswith("#!") and needs.search(text) and not text.startswith("#!/usr/bin/python3\n")]

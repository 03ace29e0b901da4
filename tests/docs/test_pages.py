"""scripts/make_pages.py: every page becomes HTML whose links, anchors, pictures and sounds exist; a small site shows
that each kind of broken link is found."""
import pathlib
import re
import shutil
import subprocess
import sys

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))

import make_pages  # noqa: E402
import pages_browser  # noqa: E402

pytestmark = pytest.mark.skipif(not shutil.which("cmark-gfm"), reason="needs cmark-gfm")


def test_no_link_of_any_page_is_broken_and_every_page_of_the_docs_is_reached_from_the_index(tmp_path):
    done = subprocess.run([sys.executable, ROOT / "scripts" / "make_pages.py", "--out", tmp_path], capture_output=True,
                          text=True)
    assert done.returncode == 0, done.stderr
    assert str(tmp_path / "index.html") in done.stdout and (tmp_path / "docs" / "greed.html").is_file()
    site = make_pages.Site(make_pages.tracked(), tmp_path)
    reached, left = set(), ["docs/README.md"]
    while left:
        name = left.pop()
        if name not in reached and name in site.pages:
            reached.add(name)
            targets = (site.target(name, link) for link in re.findall(r'href="([^"]+)"', site.pages[name].body))
            left += [target[0] for target in targets if target]
    lost = {name for name in site.pages if name.startswith("docs/")} - reached
    assert len(site.pages) > 100 and not lost, f"no page leads to {', '.join(sorted(lost))}: link it in docs/README.md, or write the reference (ninja reference)"


FIRST = "# One\n\n## Two words, `code`~\n\n## Two words, `code`~\n\n"
GOOD = ("[a](b.md) [own](#two-words-code) [second](#two-words-code-1) [deep](sub/c.md#see) [file](sub/x.txt) "
        "[folder](sub) [web](https://example.org/x) ![p](p.png) [sound](out/walk/s.wav)")


def small_site(folder, text=GOOD):
    """A checkout of a few files in folder/in, its pages in folder/out."""
    root = folder / "in"
    files = {"README.md": FIRST + text, "b.md": "# B\n", "sub/c.md": "# C\n\n### See?\n", "sub/x.txt": "<&>",
             "p.png": "png", "scripts/scenes/walk.py": ""}
    for name, content in files.items():
        (root / name).parent.mkdir(parents=True, exist_ok=True)
        (root / name).write_text(content)
    return root, list(files)


def faults(folder, text):
    root, files = small_site(folder, text)
    return make_pages.make(folder / "out", root, files).faults


def test_a_small_site_without_faults(tmp_path):
    assert faults(tmp_path, GOOD) == []
    page = (tmp_path / "out" / "README.html").read_text()
    assert "./play makes it" in page and "&lt;&amp;&gt;" in (tmp_path / "out" / "sub" / "x.txt.html").read_text()
    sound = tmp_path / "in" / "out" / "walk" / "s.wav"
    sound.parent.mkdir(parents=True)
    sound.write_text("RIFF")
    assert faults(tmp_path, GOOD) == []
    page = (tmp_path / "out" / "README.html").read_text()
    assert '<audio controls preload="none" src="out/walk/s.wav">' in page and "makes it" not in page


@pytest.mark.parametrize("text, said", [
    ("[a](nothing.md)", "file not found"), ("[a](sub/nothing.txt)", "file not found"),
    ("[a](b.md#nothing)", "b.md has no heading #nothing"), ("[a](#two)", "README.md has no heading #two"),
    ("[a](#two-words-code-2)", "has no heading"), ("![a](q.png)", "file not found"),
    ("[a](../../elsewhere.md)", "file not found"), ("[a](out/swim/s.wav)", "unknown scene swim"),
    ("<img src=\"q.png\" alt=\"\">", "file not found"), ("[a][ref]\n\n[ref]: nothing.md", "file not found")])
def test_a_broken_link_is_one_line_with_its_page(tmp_path, text, said):
    found = faults(tmp_path, text)
    assert len(found) == 1 and found[0].startswith("README.md: (") and said in found[0]


@pytest.mark.slow
@pytest.mark.skipif(not shutil.which("chromium"), reason="Chromium is not installed")
def test_a_browser_shows_every_picture_and_says_which_it_cannot(tmp_path):
    root, files = small_site(tmp_path)
    shutil.copyfile(ROOT / "docs" / "results" / "reed_sound.png", root / "p.png")
    make_pages.make(tmp_path / "out", root, files)
    assert pages_browser.faults(tmp_path / "out", 120) == []
    (tmp_path / "out" / "p.png").write_text("no picture")
    assert pages_browser.faults(tmp_path / "out", 120) == ["README.html: picture p.png"]

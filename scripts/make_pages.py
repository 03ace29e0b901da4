#!/usr/bin/env python3
"""Makes an HTML copy of every Markdown page that works from disk without a network.

    make_pages.py [--out FOLDER] [--photograph] [--browse]

--out         where to, build/pages; open FOLDER/index.html
--photograph  also makes pictures of the help patches and tutorials (needs a built library and what scripts/photograph needs)
--browse      then loads every page in headless Chromium and reports broken pictures, sounds and anchors

Exits with 1 and one line for each broken link. Needs Debian's cmark-gfm. Links to files of the checkout
lead to copies of them; files made by ./play (out/) are copied if they exist and named otherwise.
"""
import argparse
import dataclasses
import html
import os
import pathlib
import re
import shutil
import subprocess
import sys
import urllib.parse

import pages_browser
from pages_style import STYLE

ROOT = pathlib.Path(__file__).resolve().parents[1]
BEGIN = ["docs/README.md", "docs/getting_started.md", "docs/gallery.md", "docs/faq.md", "docs/glossary.md"]
SOUNDS = {".wav", ".flac", ".ogg"}
COPIED = {".png", ".jpg", ".svg", ".npz", ".mid", ".stl", ".step", *SOUNDS}  # copied unchanged; other files are shown
                                                                             # as text


PACKAGED = re.compile(r"packaging/(library/|third_party\.md)")  # files that belong in packages, beside other files


def tracked():
    """Every file of the checkout that its pages may link to, as POSIX paths."""
    names = subprocess.run(["git", "ls-files", "--cached", "--others", "--exclude-standard", "-z"], cwd=ROOT,
                           capture_output=True, text=True, check=True)
    return [name for name in names.stdout.split("\0") if name and (ROOT / name).exists() and not PACKAGED.match(name)]


def slug(text, taken):
    """The anchor that GitHub gives a heading; a second one of the same name gets -1."""
    plain = re.sub(r"[^\w\- ]", "", html.unescape(re.sub(r"<[^>]*>", "", text)).lower()).replace(" ", "-")
    name, count = plain, 0
    while name in taken:
        count += 1
        name = f"{plain}-{count}"
    taken.add(name)
    return name


def with_anchors(body):
    """The HTML with an anchor at each heading, and the set of anchors."""
    taken = set()
    body = re.sub(r"<h([1-6])>(.*?)</h\1>", lambda m: f'<h{m[1]} id="{slug(m[2], taken)}">{m[2]}</h{m[1]}>', body,
                  flags=re.S)
    return body, taken


def rendered(text):
    return subprocess.run(["cmark-gfm", "--unsafe", "-e", "table", "-e", "strikethrough", "-e", "autolink"],
                          input=text, capture_output=True, text=True, check=True).stdout


def title_of(text, name):
    found = re.search(r"^# (.+)$", text, re.M)
    return re.sub(r"[`*]", "", found[1]) if found else name


@dataclasses.dataclass
class Page:
    name: str       # path in the checkout, such as docs/greed.md
    title: str
    body: str       # HTML with anchors, links as in the Markdown
    anchors: set


class Site:
    """All pages, the files that they link to, and the faults of their links."""

    def __init__(self, files, out, root=ROOT):
        self.root, self.out = root, out
        self.files = set(files)
        self.folders = {parent.as_posix() for name in files for parent in pathlib.PurePosixPath(name).parents}
        self.pages, self.copied, self.faults = {}, set(), []
        for name in sorted(n for n in files if n.endswith(".md")):
            text = (root / name).read_text()
            self.pages[name] = Page(name, title_of(text, name), *with_anchors(rendered(text)))

    # Links -----------------------------------------------------------------------------------------------------

    def target(self, page, link):
        """The target of a page's link, as a path in the checkout and an anchor; None if it is not a file."""
        parts = urllib.parse.urlsplit(html.unescape(link))
        if parts.scheme or parts.netloc:
            return None
        path = urllib.parse.unquote(parts.path)
        folder = pathlib.PurePosixPath(page).parent.as_posix()
        named = os.path.normpath(f"{folder}/{path}") if path else page
        return named, urllib.parse.unquote(parts.fragment)

    def written_as(self, name):
        """The file of the copy that shows a file or folder of the checkout; None if there is none."""
        if name.endswith(".md"):
            return name[:-3] + ".html"
        if name in self.folders:
            readme = "README.md" if name == "." else f"{name}/README.md"
            return self.written_as(readme) if readme in self.pages else f"{name}/index.html"
        if name.startswith("out/"):
            return name
        return name if pathlib.PurePosixPath(name).suffix in COPIED else f"{name}.html"

    def fault(self, page, link, reason):
        self.faults.append(f"{page}: ({html.unescape(link)}) {reason}")

    def resolve(self, page, link):
        """The link for the copy; None if it leads to a file that ./play has not made."""
        found = self.target(page, link)
        if not found:
            return link
        name, anchor = found
        if name.startswith("out/"):
            if not self.made_by_play(page, link, name):
                return None
        elif name not in self.files and name not in self.folders:
            self.fault(page, link, "file not found")
            return link
        elif anchor and name in self.pages and anchor not in self.pages[name].anchors:
            self.fault(page, link, f"{name} has no heading #{anchor}")
        if name not in self.pages:
            self.copied.add(name)
        here = pathlib.PurePosixPath(page).parent.as_posix()
        path = os.path.relpath(self.written_as(name), here)
        return urllib.parse.quote(path) + (f"#{urllib.parse.quote(anchor)}" if anchor else "")

    def made_by_play(self, page, link, name):
        """Whether a file of out/ exists and can be copied. A missing scene, or a scene made without the file,
        is a fault.
        The page of ./play is not copied: its links lead into the checkout."""
        parts = pathlib.PurePosixPath(name).parts
        scene = parts[1]
        if len(parts) > 2 and f"scripts/scenes/{scene.replace('-', '_')}.py" not in self.files:
            self.fault(page, link, f"unknown scene {scene}")
        elif (self.root / "out" / scene / "scene.json").exists() and not (self.root / name).exists():
            self.fault(page, link, f"file not written by ./play {scene}")
        return (self.root / name).is_file() and not name.endswith(".html")

    def relinked(self, page, body):
        """The HTML of a page with the links of the copy."""
        def link(match):
            new = self.resolve(page, match[1])
            if new is None:
                return f'<span class="absent">{match[2]} <small>(./play makes it)</small></span>'
            inside = f'<a href="{new}">{match[2]}</a>'
            if pathlib.PurePosixPath(urllib.parse.urlsplit(new).path).suffix in SOUNDS:
                inside += f' <audio controls preload="none" src="{new}"></audio>'
            return inside

        def picture(match):
            new = self.resolve(page, match[1])
            return f'<img src="{new}" {match[2]}>' if new else ""

        body = re.sub(r'<img src="([^"]*)" (.*?) ?/?>', picture, body)
        return re.sub(r'<a href="([^"]*)">(.*?)</a>', link, body, flags=re.S)

    # Writing ---------------------------------------------------------------------------------------------------

    def groups(self):
        """The groups of the sidebar, with their pages."""
        def under(folder):
            return [n for n in self.pages if pathlib.PurePosixPath(n).parent.as_posix() == folder and n not in BEGIN]
        shown = [("Begin", [n for n in BEGIN if n in self.pages]), ("Tutorials", under("docs/tutorials")),
                 ("Models and programs", under("docs")), ("Devices", under("docs/devices")),
                 ("Reference", under("docs/reference")), ("Theory", under("docs/theory")),
                 ("Formats", under("docs/formats")), ("Results", under("docs/results"))]
        known = {name for _, names in shown for name in names}
        return shown + [("The checkout", [n for n in self.pages if n not in known])]

    def side(self, page):
        here = pathlib.PurePosixPath(page).parent.as_posix()
        parts = []
        for group, names in self.groups():
            rows = []
            for name in names:
                path = pathlib.PurePosixPath(name)
                label = (path.stem if group in ("Tutorials", "Reference") else name if group == "The checkout"
                         else self.pages[name].title)
                mark = ' aria-current="page"' if name == page else ""
                rows.append(f'<li><a{mark} href="{urllib.parse.quote(os.path.relpath(self.written_as(name), here))}">'
                            f"{html.escape(label)}</a></li>")
            opened = " open" if page in names or group in ("Begin", "Tutorials") else ""
            if rows:
                parts.append(f"<details{opened}><summary>{group}</summary><ul>{''.join(rows)}</ul></details>")
        return "".join(parts)

    def write(self, name, title, body, page):
        """One HTML file; page is the path in the checkout to which its links are relative."""
        target = self.out / name
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_text(
            f'<!doctype html>\n<html lang="en"><head><meta charset="utf-8"><title>{html.escape(title)}</title>'
            f'<meta name="viewport" content="width=device-width, initial-scale=1"><style>{STYLE}</style></head>'
            f"<body><nav>{self.side(page)}</nav><main>{body}</main></body></html>\n")

    def photographed(self, page, body):
        """A page about an object, with the picture of its patch or the command that opens the patch after the first
        paragraph."""
        path = pathlib.PurePosixPath(page)
        kind = {"docs/reference": "help", "docs/tutorials": "tutorial"}.get(path.parent.as_posix())
        picture = self.out / "pictures" / f"{path.stem}-{kind}.png"
        if not kind or not picture.exists():
            return body
        source = urllib.parse.quote(os.path.relpath(picture, self.out / path.parent))
        end = "</p>" if kind == "help" else "</pre>"
        return body.replace(end, f'{end}\n<p><img src="{source}" alt="the {kind} patch in Pd"></p>', 1)

    def write_all(self):
        for page in self.pages.values():
            body = self.photographed(page.name, self.relinked(page.name, page.body))
            self.write(self.written_as(page.name), page.title, f'<div class="wide">{body}</div>', page.name)
        for name in sorted(self.copied):
            self.write_copy(name)
        begin = self.written_as(BEGIN[0] if BEGIN[0] in self.pages else next(iter(self.pages)))
        (self.out / "index.html").write_text(f'<!doctype html><meta charset="utf-8"><title>tactus</title>'
                                             f'<meta http-equiv="refresh" content="0; url={begin}">'
                                             f'<a href="{begin}">tactus</a>\n')

    def write_copy(self, name):
        source, target = self.root / name, self.out / self.written_as(name)
        if name in self.folders:
            if target.name == "index.html":  # a folder without a README
                entries = sorted(n for n in self.files if pathlib.PurePosixPath(n).parent.as_posix() == name)
                for entry in set(entries) - self.pages.keys():
                    self.write_copy(entry)
                rows = "".join(f'<li><a href="{urllib.parse.quote(os.path.relpath(self.written_as(n), name))}">'
                               f"{html.escape(pathlib.PurePosixPath(n).name)}</a></li>" for n in entries)
                self.write(self.written_as(name), name, f"<h1>{html.escape(name)}</h1><ul>{rows}</ul>", f"{name}/x")
        elif target.suffix == ".html" and not name.endswith(".html"):
            text = source.read_text(errors="replace")
            self.write(self.written_as(name), name,
                       f"<h1>{html.escape(name)}</h1><pre>{html.escape(text)}</pre>", name)
        else:
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(source, target)


def photograph(out, stage):
    """Photographs the help patches and the tutorials' patches into FOLDER/pictures; keeps pictures that are newer than
    their patch."""
    (out / "pictures").mkdir(parents=True, exist_ok=True)
    patches = {f"{p.name.removesuffix('-help.pd')}-help": p for p in stage.glob("*-help.pd")
               if (ROOT / "externals" / p.name.removesuffix("-help.pd")).is_dir()}
    patches.update({p.stem: p for p in (ROOT / "docs" / "tutorials").glob("*-tutorial.pd")})
    for name, patch in sorted(patches.items()):
        picture = out / "pictures" / f"{name}.png"
        if picture.exists() and picture.stat().st_mtime > patch.stat().st_mtime:
            continue
        done = subprocess.run([ROOT / "scripts" / "photograph", patch, picture, "--stage", stage],
                              capture_output=True, text=True)
        print(f"  {name}: {'photographed' if done.returncode == 0 else done.stderr.strip()[-200:]}", flush=True)


def make(out, root=ROOT, files=None):
    """Writes the pages of a checkout; returns the site, whose faults list the broken links."""
    site = Site(tracked() if files is None else files, out, root)
    site.write_all()
    return site


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--out", type=pathlib.Path, default=ROOT / "build" / "pages")
    parser.add_argument("--stage", type=pathlib.Path, default=ROOT / "build" / "tactus")
    parser.add_argument("--photograph", action="store_true")
    parser.add_argument("--browse", action="store_true")
    a = parser.parse_args()
    if not shutil.which("cmark-gfm"):
        raise SystemExit("make_pages: needs Debian's cmark-gfm")
    a.out = a.out.resolve()
    if a.photograph:
        photograph(a.out, a.stage.resolve())
    site = make(a.out)
    faults = site.faults + (pages_browser.faults(a.out) if a.browse else [])
    for fault in faults:
        print(fault, file=sys.stderr)
    print(f"{len(site.pages)} pages: {a.out / 'index.html'}")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())

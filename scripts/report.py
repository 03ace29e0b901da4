#!/usr/bin/env python3
"""Writes out/index.html from the scenes in out/. The page needs only the files beside it.

report.py FOLDER

./play calls write() after each scene: highlighted sounds at the top, then the scenes by section, then the
names
of those still to come.
"""
import html
import json
import pathlib
import re
import sys

import contents

STYLE = (pathlib.Path(__file__).parent / "page.css").read_text()
ROOT = "../"  # relative to the page, which is out/index.html
INTRODUCTION = (
    "tactus is a collection of physical models for Pure Data that you can hear and feel: reeds and lips on a bore, "
    "footsteps on fifteen surfaces, solid bodies by finite elements, particles, strings and membranes. You play them "
    "from a patch, feel them with a haptic device, or render them without a screen. These objects and patches "
    "rendered every sound on this page; nothing was recorded. Begin with the sounds below, then choose a scene.")
LINKS = (("README.md", "README"), ("docs/install.md", "Installing"), ("docs/architecture.md", "Architecture"),
         ("docs/reference/", "Reference of the objects"), ("patches/README.md", "Patches to play"),
         ("CHANGELOG.md", "Changes"))
DOCS = {"greed": "greed.md", "fanfare": "greed.md", "reed": "results/reed_piece.md", "map": "guidance.md",
        "reed-study": "results/reed_study.md", "bodies": "modal_fem.md", "board": "modal_impact_touch.md",
        "rubbing": "contact.md", "disk": "results/modal_disk.md", "disk-hollow": "results/modal_disk.md",
        "footsteps": "footstep.md", "walking": "footstep.md", "walk-on-plate": "footstep.md",
        "particles": "particle.md", "audiohaptics": "audiohaptics.md", "finger": "audiohaptics.md",
        "strike": "scene.md", "spring": "network.md", "design": "stress_haptic.md"}

say = html.escape


def capital(text):
    return text[:1].upper() + text[1:]


def player(link, caption, seconds):
    return (f"<div class=sound><audio controls preload=none src=\"{link}\"></audio>"
            f"<span>{say(caption)} <span class=note>{seconds:.1f} s, <a href=\"{link}\">WAV</a></span></span></div>")


def part(folder, p):
    link = say(f"{folder}/{p.get('file', '')}")
    if p["kind"] == "heading":
        return f"<h4>{say(p['text'])}</h4>"
    if p["kind"] == "text":
        return f"<p>{say(p['text'])}</p>"
    if p["kind"] == "sound":
        return player(link, p["caption"], p["seconds"])
    if p["kind"] == "picture":
        return (f"<figure><a href=\"{link}\"><img loading=lazy src=\"{link}\" "
                f"alt=\"{say(p['caption'])}\"></a><figcaption>{say(p['caption'])}</figcaption></figure>")
    if p["kind"] == "file":
        return f"<p><a href=\"{link}\">{say(p['caption'])}</a></p>"
    head = "".join(f"<th>{say(c)}</th>" for c in p["header"])
    rows = "".join("<tr>" + "".join(f"<td>{say(c)}</td>" for c in r) + "</tr>" for r in p["rows"])
    caption = f"<caption>{say(p['caption'])}</caption>" if p["caption"] else ""
    return f"<div class=wide><table>{caption}<tr>{head}</tr>{rows}</table></div>"


def opening(parts):
    """The indices of the items shown without a click: a scene's first two sounds, its first picture, and the
    text between."""
    shown, sounds = [], 0
    for index, p in enumerate(parts):
        sounds += p["kind"] == "sound"
        if sounds > 2 or p["kind"] not in ("heading", "text", "sound"):
            break
        shown.append(index)
    while shown and parts[shown[-1]]["kind"] == "heading":
        shown.pop()
    picture = next((i for i, p in enumerate(parts) if p["kind"] == "picture"), None)
    return shown if picture is None else shown + [picture]


def paragraphs(text):
    """Converts a text to paragraphs. Blank lines separate them; `words` between back quotes are code."""
    return "".join(f"<p>{re.sub('`(.+?)`', '<code>' + chr(92) + '1</code>', say(t))}</p>"
                   for t in text.split("\n\n") if t)


def scene_section(scene):
    name = scene["name"]
    shown = opening(scene["parts"])
    first = "\n".join(part(name, scene["parts"][index]) for index in shown)
    rest = [p for index, p in enumerate(scene["parts"]) if index not in shown]
    if rest:
        counts = [(sum(p["kind"] == kind for p in rest), kind) for kind in ("sound", "picture", "table")]
        words = ", ".join(f"{n} {kind}{'s' * (n > 1)}" for n, kind in counts if n)
        first += (f"<details><summary>More: {words or 'text'}</summary>" + "\n".join(part(name, p) for p in rest)
                  + "</details>")
    about = [f"<code>./play {say(name)}</code>, {scene['took_seconds']} s"]
    if contents.file(name).is_file() and contents.declared(name, "PATCH"):
        about.insert(0, f"open its patch in Pd: <code>./play --gui {say(name)}</code>")
    if name in DOCS:
        about.insert(0, f"<a href=\"{ROOT}docs/{DOCS[name]}\">read more</a>")
    faults = "".join(f"<p class=fault>{say(f)}</p>" for f in scene.get("faults", ()))
    return (f"<section id=\"{say(name)}\"><h3>{say(capital(scene['title']))}</h3>"
            + f"{paragraphs(scene['description'])}{first}{faults}<p class=note>{'; '.join(about)}</p></section>")


def to_come(name, failed):
    state = "could not be made: the terminal shows the reason" if name in failed else "still to come: load this page again"
    return f"<section id=\"{say(name)}\" class=coming><h3>{say(capital(contents.title(name)))}</h3><p>{state}</p></section>"


def highlights(scenes, coming):
    found = []
    for name, sound, words in contents.HIGHLIGHTS:
        parts = scenes[name]["parts"] if name in scenes else []
        for p in parts:
            if p["kind"] == "sound" and p["file"] == f"{sound}.wav":
                found.append(player(say(f"{name}/{p['file']}"), words, p["seconds"]))
        if not parts and name in coming:
            found.append(f"<div class=\"sound coming\">{say(words)}: still to come</div>")
    return f"<section id=first><h2>Listen first</h2>{''.join(found)}</section>" if found else ""


def sections(shown):
    """[(heading, names)] of the scenes shown, in the page's order."""
    listed = {name for _, names in contents.SECTIONS for name in names}
    return [(heading, found) for heading, names in (*contents.SECTIONS, ("More", sorted(shown - listed)))
            if (found := [name for name in names if name in shown])]


def page(scenes, coming=(), failed=()):
    """The page of {name: scene}; `coming` and `failed` are names of scenes that are being made or could not be made."""
    coming = [name for name in coming if name not in failed]
    made = {name: scene for name, scene in scenes.items() if name not in (*coming, *failed)}
    parts = sections({*made, *coming, *failed})
    best = highlights(made, coming)
    links = ("<a href=\"#first\"><b>Listen first</b></a>" if best else "") + "".join(
        f"<div><b>{say(heading)}</b>" + "".join(
            f"<a href=\"#{say(n)}\"{'' if n in made else ' class=coming'}>{say(n)}</a>" for n in names)
        + "</div>" for heading, names in parts)
    body = "".join(f"<h2>{say(heading)}</h2>" + "".join(
        scene_section(made[n]) if n in made else to_come(n, failed) for n in names) for heading, names in parts)
    state = f"<p class=state>{len(coming)} of {len(made) + len(coming)} scenes are still to come.</p>" if coming else ""
    documents = " ".join(f"<a href=\"{ROOT}{link}\">{say(words)}</a>" for link, words in LINKS)
    return (f"<!doctype html><html lang=en><head><meta charset=utf-8><title>tactus: sounds and pictures</title>"
            f"<meta name=viewport content=\"width=device-width, initial-scale=1\">"
            f"<style>{STYLE}</style></head><body><header><h1>tactus</h1>"
            f"<p>physical models that you can hear and feel</p></header><nav>{links}</nav>"
            f"<main><p class=introduction>{say(INTRODUCTION)}</p><p class=links>{documents}</p>"
            f"<p><code>./play --gui reed</code> opens a patch in Pd, <code>./play --gui greed~</code> an object's "
            f"help patch. <code>./play --list</code> lists the scenes, <code>./play --all</code> also makes the long "
            f"ones.</p>{state}{best}{body}"
            f"<footer>Rendered by ./play through the Pd objects, without a screen or sound card. Take care with "
            f"headphones: the reeds reach full scale.</footer></main></body></html>\n")


def write(out, coming=(), failed=()):
    """Writes index.html of a folder, replacing it atomically. Scenes being made are not read, because they may be
    incomplete."""
    scenes = {p.parent.name: json.loads(p.read_text()) for p in pathlib.Path(out).glob("*/scene.json")
              if p.parent.name not in coming}
    new = pathlib.Path(out) / "index.html.new"
    new.write_text(page(scenes, coming, failed))
    new.replace(pathlib.Path(out) / "index.html")


if __name__ == "__main__":
    write(pathlib.Path(sys.argv[1]))

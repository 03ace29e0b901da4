#!/usr/bin/env python3
"""Writes out/index.html from the scenes in out/: one page that needs nothing but its neighbours.

report.py FOLDER
"""
import html
import json
import pathlib
import sys

STYLE = """
:root { --ink: #22303a; --soft: #5c6b75; --line: #d9e0e4; --paper: #fbfcfc; --accent: #2f4f5f; }
@media (prefers-color-scheme: dark) {
  :root { --ink: #dfe7ea; --soft: #9fb0b9; --line: #33424b; --paper: #161d21; --accent: #8fb8c9; } }
* { box-sizing: border-box; }
body { margin: 0; background: var(--paper); color: var(--ink);
       font: 16px/1.5 system-ui, "DejaVu Sans", sans-serif; }
header { background: #2f4f5f; color: #fff; padding: 2.2rem max(1.2rem, calc(50vw - 34rem)); }
header h1 { margin: 0; font-size: 2.4rem; letter-spacing: .02em; }
header p { margin: .3rem 0 0; opacity: .85; }
nav { padding: .8rem max(1.2rem, calc(50vw - 34rem)); border-bottom: 1px solid var(--line); }
nav a { margin-right: 1.2rem; color: var(--accent); text-decoration: none; font-weight: 600; }
nav a:hover { text-decoration: underline; }
main { max-width: 68rem; margin: 0 auto; padding: 0 1.2rem 4rem; }
section { padding-top: 2rem; }
h2 { color: var(--accent); font-size: 1.7rem; margin: 0; }
h2 + p { color: var(--soft); margin-top: .2rem; }
h3 { margin: 2rem 0 .3rem; border-bottom: 1px solid var(--line); }
figure { margin: 1rem 0; }
figcaption, .note { color: var(--soft); font-size: .92rem; }
img { max-width: 100%; background: #fff; border: 1px solid var(--line); border-radius: 6px; }
.sound { display: flex; flex-wrap: wrap; align-items: center; gap: .8rem; padding: .5rem 0; }
.sound audio { width: min(30rem, 100%); }
.sound span { flex: 1 1 16rem; }
.wide { overflow-x: auto; }
table { border-collapse: collapse; margin: .6rem 0; font-variant-numeric: tabular-nums; }
th, td { padding: .3rem .9rem .3rem 0; text-align: left; border-bottom: 1px solid var(--line); }
th { color: var(--soft); font-weight: 600; }
caption { text-align: left; color: var(--soft); font-size: .92rem; padding-bottom: .3rem; }
footer { color: var(--soft); border-top: 1px solid var(--line); margin-top: 3rem; padding-top: 1rem;
         font-size: .9rem; }
"""


def part(folder, p):
    say = html.escape
    link = say(f"{folder}/{p.get('file', '')}")
    if p["kind"] == "heading":
        return f"<h3>{say(p['text'])}</h3>"
    if p["kind"] == "text":
        return f"<p>{say(p['text'])}</p>"
    if p["kind"] == "sound":
        return (f"<div class=sound><audio controls preload=none src=\"{link}\"></audio>"
                f"<span>{say(p['caption'])} <span class=note>{p['seconds']:.1f} s, "
                f"<a href=\"{link}\">WAV</a></span></span></div>")
    if p["kind"] == "picture":
        return (f"<figure><a href=\"{link}\"><img loading=lazy src=\"{link}\" "
                f"alt=\"{say(p['caption'])}\"></a><figcaption>{say(p['caption'])}</figcaption></figure>")
    if p["kind"] == "file":
        return f"<p><a href=\"{link}\">{say(p['caption'])}</a></p>"
    head = "".join(f"<th>{say(c)}</th>" for c in p["header"])
    rows = "".join("<tr>" + "".join(f"<td>{say(c)}</td>" for c in r) + "</tr>" for r in p["rows"])
    caption = f"<caption>{say(p['caption'])}</caption>" if p["caption"] else ""
    return f"<div class=wide><table>{caption}<tr>{head}</tr>{rows}</table></div>"


def page(scenes):
    say = html.escape
    links = "".join(f"<a href=\"#{say(s['name'])}\">{say(s['name'])}</a>" for s in scenes)
    sections = "".join(
        f"<section id=\"{say(s['name'])}\"><h2>{say(s['name'])}</h2><p>{say(s['title'])}</p>"
        + "".join(f"<p>{say(t)}</p>" for t in s["description"].split("\n\n") if t)
        + "\n".join(part(s["name"], p) for p in s["parts"])
        + f"<p class=note>./play {say(s['name'])}, {s['took_seconds']} s</p></section>" for s in scenes)
    return (f"<!doctype html><html lang=en><head><meta charset=utf-8><title>tactus</title>"
            f"<meta name=viewport content=\"width=device-width, initial-scale=1\">"
            f"<style>{STYLE}</style></head><body><header><h1>tactus</h1>"
            f"<p>instruments and worlds that are heard and felt</p></header><nav>{links}</nav>"
            f"<main>{sections}<footer>Rendered by ./play through the Pd objects, without a screen or "
            f"sound card. Take care with headphones: the reeds are as loud as they like, up to full "
            f"scale.</footer></main></body></html>\n")


def main():
    out = pathlib.Path(sys.argv[1])
    scenes = [json.loads(p.read_text()) for p in sorted(out.glob("*/scene.json"))]
    (out / "index.html").write_text(page(scenes))


if __name__ == "__main__":
    main()

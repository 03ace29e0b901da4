"""The style sheet of make_pages.py; the reader's system setting selects light or dark."""

STYLE = """
:root { color-scheme: light dark; --ink: #22303a; --soft: #5c6b75; --line: #d9e0e4; --paper: #fbfcfc; --side: #f0f4f5;
        --code: #eef2f3; --link: #1f5f7a; }
@media (prefers-color-scheme: dark) {
  :root { --ink: #dfe7ea; --soft: #9fb0b9; --line: #33424b; --paper: #161d21; --side: #1b2429; --code: #222d33;
          --link: #8fc3d8; } }
* { box-sizing: border-box; }
body { margin: 0; background: var(--paper); color: var(--ink); font: 16px/1.55 system-ui, "DejaVu Sans", sans-serif;
       display: grid; grid-template-columns: 16rem minmax(0, 1fr); }
nav { background: var(--side); border-right: 1px solid var(--line); padding: 1rem; font-size: .9rem; height: 100vh;
      overflow-y: auto; position: sticky; top: 0; }
nav ul { list-style: none; margin: .2rem 0 .8rem; padding: 0; }
nav li { margin: .15rem 0; }
nav a { text-decoration: none; }
nav a[aria-current] { font-weight: 700; color: var(--ink); }
summary { font-weight: 600; color: var(--soft); cursor: pointer; }
main { padding: 1.5rem 2rem 5rem; max-width: 62rem; }
h1, h2, h3 { line-height: 1.25; }
h2 { margin-top: 2.2rem; border-bottom: 1px solid var(--line); padding-bottom: .2rem; }
a { color: var(--link); }
code, pre { font-family: "DejaVu Sans Mono", ui-monospace, monospace; font-size: .88em; background: var(--code); }
code { padding: .1em .3em; border-radius: 3px; overflow-wrap: anywhere; }
pre { padding: .8rem 1rem; border-radius: 6px; overflow-x: auto; line-height: 1.4; }
pre code { padding: 0; background: none; overflow-wrap: normal; }
table { border-collapse: collapse; margin: 1rem 0; display: block; overflow-x: auto; max-width: 100%; }
th, td { border-bottom: 1px solid var(--line); padding: .35rem 1rem .35rem 0; text-align: left; vertical-align: top; }
th { color: var(--soft); }
td:first-child code { white-space: nowrap; }
img { max-width: 100%; background: #fff; border: 1px solid var(--line); border-radius: 6px; }
audio { vertical-align: middle; height: 2rem; max-width: 100%; }
.absent { color: var(--soft); }
@media (max-width: 52rem) { body { display: block; } nav { position: static; height: auto; max-height: 40vh; } main { padding: 1rem; } }
"""

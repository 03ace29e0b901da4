"""Loads every page of make_pages.py in headless Chromium, like a reader's browser, and reports faults."""
import contextlib
import json
import os
import pathlib
import re
import select
import shutil
import signal
import subprocess
import tempfile
import time
import urllib.parse

PROBE = """<!doctype html><meta charset="utf-8"><body><script>
const pages = PAGES, faults = [];
function show(page) { return new Promise(done => {
  const frame = document.createElement("iframe");
  frame.onload = () => done(frame);
  frame.src = page;
  frame.width = 1200; frame.height = 900;
  document.body.append(frame); }); }
function heard(audio) { return new Promise(done => {
  audio.onloadedmetadata = () => done(true);
  audio.onerror = () => done(false);
  audio.preload = "metadata"; audio.load(); }); }
async function run() {
  for (const page of pages) {
    const frame = await show(page), seen = frame.contentDocument;
    if (!seen || !seen.querySelector("main")) { faults.push(page + ": has no text"); frame.remove(); continue; }
    for (const image of seen.images) {
      try { await image.decode(); } catch (wrong) { faults.push(page + ": picture " + image.getAttribute("src")); } }
    for (const audio of seen.querySelectorAll("audio"))
      if (!await heard(audio)) faults.push(page + ": sound " + audio.getAttribute("src"));
    if (seen.documentElement.scrollWidth > 1210) faults.push(page + ": wider than its window");
    frame.remove(); }
  console.log("pages-browser " + encodeURIComponent(JSON.stringify({ loaded: pages.length, faults: faults }))); }
run();
</script>"""


@contextlib.contextmanager
def running(command):
    """Chromium with its children, which end with it."""
    process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
                               start_new_session=True)
    try:
        yield process
    finally:
        with contextlib.suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
        process.wait()
        process.stderr.close()


def answer_of(process, seconds):
    """The probe's output on the console (None after a timeout or Chromium's end), and all of Chromium's output."""
    said, end = b"", time.monotonic() + seconds
    while time.monotonic() < end:
        ready, _, _ = select.select([process.stderr], [], [], 1)
        if not ready:
            continue
        piece = os.read(process.stderr.fileno(), 1 << 16)
        if not piece:
            break
        said += piece
        found = re.search(rb"pages-browser (\S+?)[\", ]", said)
        if found:
            return json.loads(urllib.parse.unquote(found[1].decode())), said
    return None, said


def faults(out, seconds=900):
    """One line for each item that Chromium could not display; a separate error if Chromium is missing or prints
    nothing."""
    browser = shutil.which("chromium")
    if not browser:
        return ["--browse: needs Debian's chromium"]
    pages = sorted(p.relative_to(out).as_posix() for p in out.rglob("*.html") if p != out / "index.html")
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        probe = pathlib.Path(folder) / "probe.html"
        probe.write_text(PROBE.replace("PAGES", json.dumps([(out / page).as_uri() for page in pages])))
        command = [browser, "--headless", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--no-first-run",
                   "--allow-file-access-from-files", "--enable-logging=stderr", "--remote-debugging-port=0",
                   f"--user-data-dir={folder}/profile", probe.as_uri()]
        with running(command) as process:
            answer, said = answer_of(process, seconds)
    if not answer:
        return [f"--browse: no answer from Chromium within {seconds} s: {said.decode(errors='replace').strip()[-400:]}"]
    print(f"  Chromium loaded {answer['loaded']} pages")
    return [fault.replace(out.as_uri() + "/", "") for fault in answer["faults"]]

"""Loads every page of make_pages.py in headless Chromium, as a reader's browser does, and says what is broken there."""
import json
import pathlib
import re
import shutil
import subprocess
import tempfile

PROBE = """<!doctype html><meta charset="utf-8"><body><pre id="said">running</pre><script>
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
  document.getElementById("said").textContent = JSON.stringify({ loaded: pages.length, faults: faults }); }
run();
</script>"""


def faults(out, seconds=600):
    """What Chromium could not show, one line each; an error of its own if it is missing or says nothing."""
    browser = shutil.which("chromium")
    if not browser:
        return ["--browse: needs Debian's chromium"]
    pages = sorted(p.relative_to(out).as_posix() for p in out.rglob("*.html") if p != out / "index.html")
    urls = [(out / page).as_uri() for page in pages]
    with tempfile.TemporaryDirectory() as folder:
        probe = pathlib.Path(folder) / "probe.html"
        probe.write_text(PROBE.replace("PAGES", json.dumps(urls)))
        try:
            done = subprocess.run([browser, "--headless", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage",
                                   "--allow-file-access-from-files", f"--user-data-dir={folder}/profile",
                                   f"--timeout={1000 * seconds}", "--virtual-time-budget=100000000", "--dump-dom",
                                   probe.as_uri()], capture_output=True, text=True, timeout=seconds + 30)
        except subprocess.TimeoutExpired:
            return [f"--browse: Chromium did not end within {seconds} s"]
    said = re.search(r'<pre id="said">(.*?)</pre>', done.stdout, re.S)
    if not said or not said[1].startswith("{"):
        return [f"--browse: Chromium gave no answer: {done.stderr.strip()[-400:]}"]
    answer = json.loads(said[1].replace("&amp;", "&").replace("&lt;", "<").replace("&gt;", ">"))
    print(f"  Chromium loaded {answer['loaded']} pages")
    return [fault.replace(out.as_uri() + "/", "") for fault in answer["faults"]]

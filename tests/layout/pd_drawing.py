"""What Pd itself draws: a socket stands in for Pd's window and reads the drawing commands of every canvas.

No screen is needed. The commands are those of Pd 0.53; `drawings` returns None for other versions.
"""
import importlib.machinery
import importlib.util
import os
import pathlib
import re
import socket
import subprocess
import tempfile
import time

_loader = importlib.machinery.SourceFileLoader(
    "photograph", str(pathlib.Path(__file__).resolve().parents[2] / "scripts" / "photograph"))
photograph = importlib.util.module_from_spec(importlib.util.spec_from_loader("photograph", _loader))
_loader.exec_module(photograph)

FONTS = "8 5 10 10 6 13 12 7 15 16 10 19 24 14 29 37 22 44 16 10 20 20 12 25 24 14 29 32 20 36 48 28 56 72 44 86"
NUMBERS = r"((?:-?\d+ )+)"


def commands(stage, path, sub_patches, seconds=20):
    """What Pd says to its window while it opens the patch and the named sub-patches."""
    with socket.socket() as server, tempfile.TemporaryDirectory(prefix="tactus-") as folder:
        server.bind(("127.0.0.1", 0))
        server.listen(1)
        server.settimeout(seconds)
        process = subprocess.Popen(
            ["pd", "-noprefs", "-nosound", "-nomidi", "-guiport", str(server.getsockname()[1]), "-path", str(stage),
             "-open", str(path)], stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
            env=photograph.with_localhost(dict(os.environ), folder))
        try:
            window, _ = server.accept()
            with window:
                window.settimeout(0.3)
                window.sendall(f"pd init /tmp 0 {FONTS};\n".encode())
                return _listen(window, sub_patches, seconds)
        finally:
            process.kill()
            process.wait()


def _listen(window, sub_patches, seconds):
    said, mapped, asked, end = b"", set(), False, time.monotonic() + seconds
    while time.monotonic() < end:
        try:
            chunk = window.recv(1 << 16)
            if not chunk:
                break
            said += chunk
        except socket.timeout:
            if mapped and asked:
                break
            if mapped:
                asked = True
                for name in sub_patches:
                    window.sendall(f"pd-{name} vis 1;\n".encode())
        for name in re.findall(rb"pdtk_canvas_new (\.x\w+) ", said):
            if name not in mapped:
                mapped.add(name)
                window.sendall(name + b" map 1;\n")
    return said.decode(errors="replace")


def canvases(said):
    """Of each canvas its title, its frames as (kind, corners, tag), the cords, and the texts of boxes with their
    places."""
    found = {}
    for name in re.findall(r"pdtk_canvas_new (\.x\w+) ", said):
        title = re.search(rf"pdtk_canvas_reflecttitle {re.escape(name)} {{.*?}} {{(.*?)}} ", said)
        drawn = {"title": title.group(1) if title else "", "frames": [], "cords": []}
        drawn["texts"] = [((int(x), int(y)), re.sub(r"\\(.)", r"\1", text)) for x, y, text in re.findall(
            rf"pdtk_text_new {re.escape(name)}\.c {{.*?}} }} (-?\d+) (-?\d+) {{(.*)", said)]
        start = f"{name}.c "
        for line in said.splitlines():
            if not line.startswith(start):
                continue
            rest = line[len(start):]
            if shape := re.match(rf"create line {NUMBERS}.*-tags {{{{(\S+)R}} {{(\w+)}} }}", rest):
                drawn["frames"].append((shape.group(3), [int(v) for v in shape.group(1).split()], shape.group(2)))
            elif shape := re.match(rf"coords {{(\w+?)(BASE\d*|RECT)}} {NUMBERS}", rest):
                drawn["frames"].append((shape.group(2), [int(v) for v in shape.group(3).split()], shape.group(1)))
            elif shape := re.match(rf"create line {NUMBERS}.*{{cord}}", rest):
                drawn["cords"].append(tuple(int(v) for v in shape.group(1).split()))
        found[name] = drawn
    return list(found.values())

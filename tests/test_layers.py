"""Includes go down the house's floors alone, as docs/architecture.md draws them; the core includes the
standard library alone and reads no file; a library's header stays in the room that wraps it; nothing waits
by what loses wake-ups on Windows."""
import pathlib
import re

ROOT = pathlib.Path(__file__).resolve().parent.parent
# Whose headers the sources of a room may include.
ROOMS = {
    "core": {"core"},
    "files": {"files", "core"},
    "fem": {"fem", "files", "core"},
    "devices": {"devices", "files", "core"},
    "net": {"net", "files", "core"},
    "pd": {"pd", "core"},
    "max": {"max", "files", "core"},
    "externals": {"externals", "devices", "net", "files", "core"},
    "programs": {"programs", "externals", "fem", "devices", "net", "files", "core"},
}
# Parts of [phantom], from the bottom up: each may include those before it.
PARTS = ("servo", "device", "force", "network", "scene", "output")
# Headers in angle brackets, and the only files that may include them.
HOMES = {
    "m_pd.h": r"pd/.*",
    "nlohmann/json.hpp": r"(files|devices/haply)/[^/]*\.cpp",
    "(cblas|cholmod|gmsh).h": r"fem/.*",
    "boost/.*": r"(net|devices/haply)/.*",
    "(hidapi|libusb).h": r"devices/.*",
    "(petsc|slepc).*": r"programs/.*",
    "doctest/.*|benchmark/.*": r"-",
    r"(ext|ext_.*|z_dsp|jpatcher_.*)\.h": r"-",  # of Max's SDK: max/abi declares what is used
}
STANDARD = re.compile(r"[a-z_0-9]+")  # <vector>; <unistd.h> has a point
INSTRUCTIONS = {"immintrin.h", "emmintrin.h", "xmmintrin.h", "arm_neon.h"}
FILES = {"fstream", "filesystem", "iostream", "syncstream"}
READS = re.compile(r"\b(fopen|freopen|fread|fwrite|fgets|fputs|tmpfile|FILE)\b")
# Waits by std::atomic's own: GCC's library on Windows looks outside of the lock and then waits in it, so that a
# thread may wait for ever (docs/cross_build.md). A condition_variable_any with a stop_token has a stop_callback.
# Objects speak of no host: each says where it looks, and what it wants, in the words of all of them.
HOST = re.compile(r"\"(?:[^\"\\\n]|\\.)*\b(?:Pd|Pure Data|Max|MSP)\b(?:[^\"\\\n]|\\.)*\"")
SPEAK_OF_NO_HOST = ("core", "files", "devices", "net", "externals")
LOSES = re.compile(r"\b(condition_variable_any|stop_callback)\b|<(semaphore|latch|barrier)>|\.wait\([^;]*memory_order")
INCLUDE = re.compile(r"^\s*#\s*include\s*([<\"])([^>\"]+)[>\"]", re.M)


def wrong_in(room, path, text):
    """What a source of a room includes that it may not, one sentence each; path is from the root."""
    for kind, header in INCLUDE.findall(text):
        if kind == '"':
            first = header.split("/")[0]
            parts = [re.match(r"externals/phantom/(\w+)/", name) for name in (path, header)]
            if all(parts) and PARTS.index(parts[1][1]) > PARTS.index(parts[0][1]):
                yield f'{path} includes "{header}", a part above it'
            # A header without a folder, or one that CMake makes, lies beside its source.
            if "/" in header and first not in ROOMS[room]:
                yield f'{path} includes "{header}": {room}/ may include {", ".join(sorted(ROOMS[room]))}'
            continue
        homes = [home for pattern, home in HOMES.items() if re.fullmatch(pattern, header)]
        if any(not re.fullmatch(home, path) for home in homes):
            yield f"{path} includes <{header}>, whose place is {' '.join(homes)}"
        if room != "core":
            continue
        if header in FILES or not (STANDARD.fullmatch(header) or header in INSTRUCTIONS):
            yield f"{path} includes <{header}>: the core includes the standard library alone, and reads no file"
    if room == "core" and (found := READS.search(re.sub(r"//.*", "", text))):
        yield f"{path} uses {found[0]}: the core reads no file"
    if room in SPEAK_OF_NO_HOST and (found := HOST.search(re.sub(r"//.*", "", INCLUDE.sub("", text)))):
        yield f"{path} says {found[0]}: the text of an object names no host"
    if not path.endswith("_posix.cpp") and (found := LOSES.search(re.sub(r"//.*", "", text))):
        yield f"{path} uses {found[0]}, which loses wake-ups on Windows: a std::condition_variable, or WakeCount"


def violations(root):
    for room in ROOMS:
        for path in sorted((root / room).rglob("*")):
            if path.suffix in (".cpp", ".hpp", ".h", ".c", ".in") and path.is_file():
                yield from wrong_in(room, path.relative_to(root).as_posix(), path.read_text(errors="replace"))


def test_includes_go_down_alone():
    assert all((ROOT / room).is_dir() for room in ROOMS)
    assert list(violations(ROOT)) == []


def test_what_goes_up_or_sideways_is_found(tmp_path):
    lines = {
        "core/a.cpp": '#include "files/npz.hpp"\n#include <fstream>\n#include <unistd.h>\n#include <cmath>\n',
        "core/b.hpp": "#include <nlohmann/json.hpp>\n",
        "core/c.cpp": '#include <cstdio>\nauto* f = std::fopen("x", "r"); // FILE\n',
        "core/d.cpp": '#include <cstdio>\n#include <immintrin.h>\n#include "core/b.hpp"\n// a FILE in words\n',
        "files/a.hpp": '#include "fem/io/npz.hpp"\n  #  include <nlohmann/json.hpp>\n',
        "files/b.cpp": '#include "files/a.hpp"\n#include <nlohmann/json.hpp>\n#include <fstream>\n',
        "fem/a.cpp": '#include "devices/a.hpp"\n#include "files/a.hpp"\n',
        "externals/x/a.cpp": '#include "fem/a.hpp"\n#include <m_pd.h>\n',
        "externals/x/b.hpp": '#include "max/abi/max_abi.h"\n',
        "max/shell/a.cpp": '#include "max/abi/max_abi.h"\n#include "pd/shell.hpp"\n#include <ext_obex.h>\n',
        "externals/x/c.hpp": "std::condition_variable wake_;\nstd::condition_variable_any wakes_;\n",
        "devices/a.cpp": "count_.wait(seen,\n            std::memory_order_acquire); // in a stop_callback\n",
        "devices/b_posix.cpp": "count_.wait(seen, std::memory_order_acquire);\n",
        "net/a.cpp": "#include <semaphore>\n",
        "externals/x/d.cpp": 'error("no such file in Pd\'s path"); // "of Pd"\nlog("Maximum in \\"all\\"");\n',
        "devices/c.cpp": '// "the Max shell"\nerror("in \\"Max\\"");\n',
        "externals/phantom/servo/a.hpp": '#include "externals/phantom/device/a.hpp"\n',
        "externals/phantom/output/a.hpp": '#include "externals/phantom/device/a.hpp"\n',
        "pd/a.cpp": 'error("tactus: Pd knows no such thing");\n',
        "programs/x/a.cpp": '#include "externals/x/a.hpp"\n#include "pd/shell.hpp"\n',
    }
    for name, text in lines.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text)
    found = list(violations(tmp_path))
    words = [("core/a.cpp", "files/npz.hpp"), ("core/a.cpp", "fstream"), ("core/a.cpp", "unistd.h"),
             ("core/b.hpp", "place"), ("core/b.hpp", "standard"), ("core/c.cpp", "fopen"),
             ("files/a.hpp", "fem/io"), ("files/a.hpp", "nlohmann"), ("fem/a.cpp", "devices/a.hpp"),
             ("externals/x/a.cpp", "fem/a.hpp"), ("externals/x/a.cpp", "m_pd.h"),
             ("externals/x/b.hpp", "max/abi"), ("max/shell/a.cpp", "pd/shell"), ("max/shell/a.cpp", "ext_obex"),
             ("programs/x/a.cpp", "pd/shell"), ("externals/x/c.hpp", "condition_variable_any"),
             ("devices/a.cpp", "memory_order"), ("net/a.cpp", "<semaphore>"),
             ("externals/phantom/servo/a.hpp", "above"), ("externals/x/d.cpp", "Pd's path"), ("devices/c.cpp", "names no host")]
    assert len(found) == len(words), found
    for name, word in words:
        assert any(name in sentence and word in sentence for sentence in found), (name, word)

#!/usr/bin/env python3
"""What modules for another system take and give: nothing that only the compiler's machine has.

    check_imports.py --objdump OBJDUMP --definitions pd/pd.def STAGE
    check_imports.py --objdump OBJDUMP --definitions BUILD/max/abi/MaxAPI.def --definitions BUILD/max/abi/MaxAudio.def EXTERNALS

Windows: libraries of the system and the host's DLLs alone, of these only what the .def files list. Linux:
libraries that every system with Pd and FFTW has. macOS (OBJDUMP is LLVM's): libSystem, and of the program that loads
the module only what the .def files list; every part is signed, and what is signed is what the file holds. Everywhere a
module gives one function, its set-up.
"""
import argparse
import hashlib
import pathlib
import re
import struct
import subprocess
import sys

WINDOWS = {"kernel32.dll", "msvcrt.dll", "ws2_32.dll", "mswsock.dll", "advapi32.dll", "shell32.dll", "user32.dll",
           "api-ms-win-core-synch-l1-2-0.dll"}
LINUX = {"libc.so.6", "libm.so.6", "ld-linux-aarch64.so.1", "libfftw3.so.3"}
MACOS = {"/usr/lib/libSystem.B.dylib"}
PROCESSORS = {0x01000007: "amd64", 0x0100000c: "arm64"}  # mach/machine.h
SIGNATURE = 0x1d  # LC_CODE_SIGNATURE, mach-o/loader.h


def setup_of(module):
    if module.name.endswith(".mxe64"):
        return "ext_main"
    name = re.sub(r"\.(m_amd64|l_arm64|d_\w+|(windows-amd64|linux-arm64|darwin-\w+)-64\.(dll|so))$", "", module.name)
    return name.replace("~", "_tilde") + "_setup"


def hosts_of(module, definitions):
    """DLL of the host -> names that may be taken of it."""
    if module.name.endswith("-64.dll"): # Pd's DLL for doubles, by another name
        return {"pd64.dll": definitions["pd.dll"]}
    return definitions


def check_windows(module, text, definitions):
    """Yields what is wrong with the module."""
    hosts = hosts_of(module, definitions)
    imports = re.split(r"DLL Name: ", text)[1:]
    libraries = {part.split("\n", 1)[0].strip().lower() for part in imports}
    for library in sorted(libraries - WINDOWS - set(hosts)):
        yield f"needs {library}"
    if not libraries & set(hosts):
        yield f"does not load into {' and '.join(hosts)}"
    for part in imports:
        host = part.split("\n", 1)[0].strip().lower()
        if host in hosts:
            names = re.findall(r"^\s+[0-9a-f]+\s+\d+\s+(\w+)\s*$", part.split("DLL Name")[0], re.M)
            if not names:
                yield f"takes nothing of {host}, as far as objdump's output was understood"
            for name in sorted(set(names) - hosts[host]):
                yield f"takes {name} of {host}, which no .def file lists"
    exports = re.search(r"\[Ordinal/Name Pointer\] Table\n((?:\s+\[.*\n)*)", text)
    yield from check_exports(module, re.findall(r"\]\s+(?:\+base\[\s*\d+\]\s+)?(?:[0-9a-f]+\s+)?(\w+)$",
                                                exports.group(1) if exports else "", re.M))


def check_linux(module, text, objdump):
    for library in sorted(set(re.findall(r"NEEDED\s+(\S+)", text)) - LINUX):
        yield f"needs {library}"
    symbols = subprocess.run([objdump, "-T", module], capture_output=True, text=True, check=True).stdout
    names = [line.split()[-1] for line in symbols.splitlines() if re.search(r"\sg\s+D[FO]\s+\.", line)]
    yield from check_exports(module, names)


def parts_of(data):
    """The processor and the bytes of each part of a Mach-O file (mach-o/fat.h)."""
    parts = [(0, len(data))]
    if data[:4] == b"\xca\xfe\xba\xbe":
        parts = [struct.unpack_from(">8x2I", data, 8 + 20 * part) for part in range(struct.unpack_from(">I", data, 4)[0])]
    for offset, size in parts:
        part = data[offset:offset + size]
        yield PROCESSORS.get(struct.unpack_from("<4xI", part)[0], "unknown"), part


def is_signed(part):
    """Whether the hashes of a signature without a certificate are those of the part's pages (kern/cs_blobs.h)."""
    at = 32
    for _ in range(struct.unpack_from("<I", part, 16)[0]):
        command, size = struct.unpack_from("<2I", part, at)
        if command == SIGNATURE:
            break
        at += size
    else:
        return False
    begin = struct.unpack_from("<I", part, at + 8)[0]
    directory = begin + struct.unpack_from(">I", part, begin + 16)[0]
    flags, hashes, _, _, count, limit = struct.unpack_from(">12x6I", part, directory)
    kind, page = struct.unpack_from(">xBxB", part, directory + 36)
    pages = [part[first:min(first + (1 << page), limit)] for first in range(0, limit, 1 << page)]
    signed = [part[directory + hashes + 32 * index:][:32] for index in range(count)]
    return flags & 2 != 0 and kind == 2 and limit == begin and signed == [hashlib.sha256(one).digest() for one in pages]


def check_macos(module, objdump, definitions):
    expected = [name for name in ("amd64", "arm64") if name in module.name] or ["amd64", "arm64"]
    parts = list(parts_of(module.read_bytes()))
    if sorted(name for name, _ in parts) != expected:
        yield f"is for {', '.join(name for name, _ in parts)}"
    for name, part in parts:
        if not is_signed(part):
            yield f"is not signed as it is ({name})"

    def listed(*what):
        lines = subprocess.run([objdump, "--macho", "--arch=all", *what, module], capture_output=True, text=True,
                               check=True).stdout.splitlines()
        return [line.split() for line in lines]

    for library in sorted({words[0] for words in listed("--dylibs-used") if len(words) > 1 and "compatibility" in words[1]}
                          - MACOS):
        yield f"needs {library}"
    binds = listed("--bind", "--lazy-bind", "--weak-bind")
    taken = {words[-1] for words in binds if "flat-namespace" in words}
    if not taken:
        yield "takes nothing of Pd, as far as objdump's output was understood"
    for name in sorted(taken - {"_" + known for known in definitions["pd.dll"]}):
        yield f"takes {name} of Pd, which no .def file lists"
    exports = {words[1] for words in listed("--exports-trie") if len(words) == 2 and words[0].startswith("0x")}
    yield from check_exports(module, sorted(name[1:] for name in exports))


def check_exports(module, names):
    if names != [setup_of(module)]:
        yield f"gives {sorted(names)}, not {setup_of(module)} alone"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("stage", type=pathlib.Path)
    parser.add_argument("--objdump", required=True)
    parser.add_argument("--definitions", type=pathlib.Path, required=True, action="append")
    arguments = parser.parse_args()
    known = {file.stem.lower() + ".dll": {line.split()[0] for line in file.read_text().split("EXPORTS\n")[1].splitlines()
                                          if line} for file in arguments.definitions}
    modules = [file for file in sorted(arguments.stage.iterdir())
               if file.name.endswith((".m_amd64", "-64.dll", ".l_arm64", "-64.so", ".mxe64", ".d_amd64", ".d_arm64", ".d_fat"))]
    wrong = []
    for module in modules:
        if ".d_" in module.name or ".darwin-" in module.name:
            found = check_macos(module, arguments.objdump, known)
        else:
            text = subprocess.run([arguments.objdump, "-p", module], capture_output=True, text=True, check=True).stdout
            found = check_windows(module, text, known) if "file format pei" in text else \
                check_linux(module, text, arguments.objdump)
        wrong += [f"{module.name} {one}" for one in found]
    print("\n".join(wrong + [f"{len(modules)} modules, {len(wrong)} faults"]))
    sys.exit(1 if wrong or not modules else 0)


if __name__ == "__main__":
    main()

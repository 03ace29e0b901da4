"""No function that a newer processor's file of the core defines may be taken for an older one's.

    check_instruction_sets.py OBJECT...     objects of the core; those named *_avx2*, *_avx512* count

The linker keeps one copy of an inline function, whoever compiled it. In a file compiled with newer
instructions every function that other files could share must therefore name its instruction set in
its type; otherwise an older processor meets an instruction it does not know.
"""
import pathlib
import subprocess
import sys

# Data without code.
HARMLESS = ("typeinfo for", "typeinfo name for", "vtable for", "guard variable", "DW.ref.")


def shared_code(path):
    listing = subprocess.run(["nm", "-C", str(path)], check=True, capture_output=True, text=True)
    for line in listing.stdout.splitlines():
        kind, _, name = line[17:].partition(" ")
        if kind in "WVu" and not name.startswith(HARMLESS):
            yield name


def main(objects):
    newer = {o: tag for o in objects for tag in ("Avx2", "Avx512") if f"_{tag.lower()}." in o.name}
    if not newer:
        sys.exit("no file of a newer instruction set among the objects")
    wrong = [f"{o.name}: {name}" for o, tag in newer.items() for name in shared_code(o)
             if f"simd::{tag}" not in name]
    if wrong:
        sys.exit("code that other files could take:\n" + "\n".join(wrong))


main([pathlib.Path(argument) for argument in sys.argv[1:]])

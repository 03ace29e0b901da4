"""The core's results are the same bits on every machine: core and externals call none of the C library's
functions whose last bits differ from system to system, nor the compiler's quotients of complex numbers.

    check_elementary.py ROOT FOLDER... -- LIBRARY...

The sources below these folders, which core/dsp/elementary.hpp and complex.hpp serve, and what the libraries
import: that finds calls that the compiler adds.
"""
import pathlib
import re
import subprocess
import sys

FUNCTIONS = ("exp exp2 exp10 expm1 log log2 log10 log1p pow cbrt hypot sin cos tan asin acos atan atan2 sinh cosh tanh "
             "asinh acosh atanh erf erfc tgamma lgamma cyl_bessel_i cyl_bessel_j sincos")
CALL = re.compile(r"\bstd::(" + "|".join([*FUNCTIONS.split(), "polar", "arg", "complex<double>"]) + r")(?!\w)")
IMPORTS = {name + kind for name in FUNCTIONS.split() for kind in ("", "f", "l")} | {
    part + kind for part in ("cexp", "clog", "cpow", "csqrt", "cabs", "carg", "csin", "ccos", "ctan") for kind in ("", "f")
} | {"__divdc3", "__divsc3"}


def calls(root, folder):
    for path in sorted((root / folder).rglob("*.[ch]pp")):
        for number, line in enumerate(path.read_text().splitlines(), 1):
            if found := CALL.search(line.partition("//")[0]):
                yield f"{path.relative_to(root)}:{number}: {found[0]}: take tactus::math's"


def imports(libraries):
    listing = subprocess.run(["nm", "-u", "-A", *libraries], check=True, capture_output=True, text=True)
    for line in listing.stdout.splitlines():
        name = line.split()[-1].partition("@")[0]
        if name in IMPORTS:
            yield f"{line.partition(':')[0]} calls the library's {name}: take tactus::math's"


def main(arguments):
    at = arguments.index("--")
    root = pathlib.Path(arguments[0])
    wrong = [sentence for folder in arguments[1:at] for sentence in calls(root, folder)]
    wrong += imports(arguments[at + 1:])
    if wrong:
        sys.exit("\n".join(wrong))


main(sys.argv[1:])

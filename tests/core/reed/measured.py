#!/usr/bin/python3
"""The table of docs/theory/greed.md: what the reed's tests assert, and how near to it they come.

    tests/core/reed/measured.py --program build/tests/core_reed_test [--rows ring-down,Raman]

Runs the unit tests with every check printed and takes, of each expression below, the bound that it
asserts and the value that comes nearest to the bound."""
import argparse
import dataclasses
import re
import subprocess
import sys


@dataclasses.dataclass(frozen=True)
class Row:
    case: str      # beginning of the test case's name
    what: str
    against: str
    checks: tuple  # (text of the checked expression, unit: % of 1, or a unit as it is)
    asserted: str = ""  # where it is no plain number


ROWS = (
    Row("the valve rests", "θ and U at rest (clarinet, trumpet, voice)", "static solution",
        (("r.theta.back() / state.theta", "%"), ("r.flow.back() / state.flow", "%"))),
    Row("a bore closed by its reed rings", "ring-down of the shut bore, L = 0.3 to 1 m",
        "poles of Y_in: frequency, decay", (("f / frequency - 1", "%"), ("/ decay - 1", "%"))),
    Row("oscillation", "oscillation thresholds of 10 instruments", "linear theory: pressure, frequency",
        (("threshold - 1", "%"), ("f / start.frequency_hz", "%"))),
    Row("small", "growth rates near threshold", "linear theory",
        (("slope - rate_per_s", "1/s"),), "6 % or 0.3/s"),
    Row("Raman", "pressure plateaus of Raman's model, R₀ = 0.9, 0.95", "closed form: upper, lower",
        (("median(above) / high", "%"), ("median(below) / low", "%"))),
    Row("playing states", "15 playing states", "the same equations at 768 kHz: pitch, p_b rms, harmonics",
        (("cents(f0, state.pitch_hz)", "cents"), ("rms(p) / state.rms_pa", "%"),
         ("harmonic_db(p, rate, f0, number) - level", "dB"))),
    Row("playing states", "pitch at 44.1, 48, 96 kHz", "each other",
        (("cents(f0, pitches[0])", "cents"),)),
    Row("playing without", "clarinet without inertance, 4 pressures",
        "OpenWInD 0.12, finite elements: pitch, p_b rms",
        (("cents(f0, pitch_hz)", "cents"), ("rms(bore) / rms_pa", "%"))),
    Row("what theory", "sound after 3 s in 6 states that theory calls stable, as a share of the onset", "silence",
        (("rms(end) < 1e-6 * loudest", ""),)),
    Row("two hundred", "200 random valves on a lossless bore",
        "energy gained in one step, as a share of the initial energy", (("worst < 1e-10", ""),)),
)
CHECK = re.compile(r"SUCCESS: CHECK\( (.*) \) is correct!\s*\n\s*values: CHECK\( (\S+)\s+<\s+(\S+) \)")


def asserted(expression, bound):
    """The bound as it stands in the test where it is a multiple of something measured."""
    factor = re.search(r"< (\S+) \* ", expression)
    return float(factor[1]) if factor else bound


def figure(value, bound, unit):
    """A value in its unit with two digits; how small it is, where that depends on the machine."""
    if value < 1e-3 * bound:
        return "below a thousandth of the limit"
    return f"{100 * value if unit == '%' else value:.2g}{' ' if unit else ''}{unit}"


def cells(row, checks):
    """The bounds and the values nearest to them."""
    bounds, values = [], []
    for text, unit in row.checks:
        found = [(value / bound, expression, bound) for expression, value, bound in checks
                 if text in expression]
        if not found:
            sys.exit(f"no check of '{text}' in the tests that begin with '{row.case}'")
        share, expression, bound = max(found)
        bound = asserted(expression, bound)
        bounds.append(f"{100 * bound if unit == '%' else bound:.3g}{' ' if unit else ''}{unit}")
        values.append(figure(share * bound, bound, unit))
    return [row.asserted or ", ".join(bounds), ", ".join(values)]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--program", required=True)
    parser.add_argument("--rows", default="", help="words that the wanted rows' first cells contain")
    arguments = parser.parse_args()
    words = list(filter(None, arguments.rows.split(",")))
    rows = [row for row in ROWS if not words or any(word in row.what for word in words)]
    cases = ",".join(dict.fromkeys([*(row.case + "*" for row in rows), "*at every sample rate"]))
    done = subprocess.run([arguments.program, "-s", f"-tc={cases}"], capture_output=True, text=True)
    if done.returncode:
        sys.exit(f"{arguments.program} -tc=\"{cases}\" fails")
    checks = [(expression, float(value), float(bound))
              for expression, value, bound in CHECK.findall(done.stdout)]
    print("| quantity | reference | asserted limit | worst measured |\n|---|---|---|---|")
    for row in rows:
        print("| " + " | ".join([row.what, row.against, *cells(row, checks)]) + " |")


if __name__ == "__main__":
    main()

"""What ./test --quick leaves out exists."""
import os
import pathlib
import re
import subprocess

ROOT = pathlib.Path(__file__).resolve().parents[2]


def test_every_slow_test_is_one():
    listed = subprocess.run(["ctest", "--test-dir", os.environ["TACTUS_BUILD"], "-N"], capture_output=True,
                            text=True, check=True).stdout
    tests = set(re.findall(r"Test +#\d+: (\S+)", listed))
    slow = [line for line in (ROOT / "tests" / "slow_tests.txt").read_text().splitlines() if not line.startswith("#")]
    assert len(tests) > 100 and slow and sorted(set(slow)) == slow
    # A build without finite elements, devices, Max or a screen has none of their tests.
    rooms = {name.partition("_")[0] for name in tests}
    assert {name for name in slow if name.partition("_")[0] in rooms} <= tests

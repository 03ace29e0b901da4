"""The udev rules hold together: by udevadm where it can verify, and by the grammar of udev(7)."""
import os
import pathlib
import re
import shutil
import subprocess

import pytest

RULES = pathlib.Path(os.environ["TACTUS_SOURCE"]) / "packaging/udev/70-tactus.rules"
MATCHES = ("ACTION", "KERNEL", "KERNELS", "SUBSYSTEM", r"ATTR\{[\w/]+\}", r"ATTRS\{[\w/]+\}",
           r"ENV\{\w+\}")
TERM = re.compile(r'(?:(?:%s)(?:==|!=)"[^"]*"|TAG\+="uaccess"|GROUP="(?:plugdev|dialout|input)"|MODE="0660"|GOTO="\w+"|LABEL="\w+")$'
                  % "|".join(MATCHES))


def lines():
    return [line for line in RULES.read_text().splitlines() if line and not line.startswith("#")]


def test_every_line_is_a_rule_that_matches_before_it_gives_access_also_without_a_seat():
    """uaccess gives nothing over ssh or without a screen; a group does."""
    text = RULES.read_text()
    assert set(re.findall(r'GOTO="(\w+)"', text)) == set(re.findall(r'LABEL="(\w+)"', text))
    for line in lines():
        for term in line.split(", "):
            assert TERM.match(term), f"{term!r} in {line!r}"
        if "TAG+=" in line:
            group = ("dialout" if "tty" in line else "input" if 'SUBSYSTEM=="input"' in line else "plugdev")
            assert "==" in line and line.endswith(f'GROUP="{group}", MODE="0660", TAG+="uaccess"'), line


def test_the_devices_of_the_documentation_are_in():
    text = RULES.read_text()
    for vendor in ("0403", "046d", "256f", "2988", "1451"):
        assert f'"{vendor}"' in text
    number = int(RULES.name.split("-")[0])
    assert number < 73  # 73-seat-late.rules gives the access


def test_udevadm_agrees():
    udevadm = shutil.which("udevadm")
    if not udevadm:
        pytest.skip("udevadm is missing")
    if "verify" not in subprocess.run([udevadm, "--help"], capture_output=True, text=True).stdout:
        pytest.skip("this udevadm cannot verify (systemd 254 or newer can)")
    done = subprocess.run([udevadm, "verify", "--no-style", RULES], capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr

"""Which packages the two commands install: scripts/packages, read by scripts/common.sh."""
import pathlib
import subprocess

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
# A Debian in which `have` is installed and `offered` could be; `mentioned` is a name without a package.
DEBIAN = """root=$1 command=./test; shift; . "$root/scripts/common.sh"
fetch_lists() { :; }; installed() { [ "$1" = have ]; }; 
apt-cache() { case $2 in offered) echo "Package: offered" ;; mentioned) ;; *) return 100 ;; esac; }
choose_packages "$@" """


@pytest.mark.parametrize("asked, chosen", [
    ("missing|have missing|offered|have offered|have mentioned|offered", "have offered offered offered"),
    ("missing? mentioned? offered? have?", "offered have"),  # what is optional is left out where Debian lacks it
    ("missing have", "missing have"),  # but not a plain name, so that installing it fails and says so
])
def test_the_first_alternative_that_debian_has_is_taken(asked, chosen):
    done = subprocess.run(["bash", "-c", DEBIAN, "bash", ROOT, *asked.split()], capture_output=True, text=True, check=True)
    assert done.stdout.split() == chosen.split()


def test_every_line_of_the_list_is_a_group_of_words():
    lines = [line for line in (ROOT / "scripts" / "packages").read_text().splitlines() if not line.startswith("#")]
    assert lines and all(line.partition(": ")[0].isalpha() and line.partition(": ")[2] for line in lines)


MISSING = """root=$1 command=./play; . "$root/scripts/common.sh"
missing_packages() { echo "$lacking"; }; as_root() { :; }; set_up() { sleep 0.2; return "$status"; }
begin_set_up play; [ -z "$installer" ] && echo none || { wait "$installer"; echo "ended with $?"; }"""


@pytest.mark.parametrize("missing, status, said", [
    ("", 0, "none"), ("python3-numpy", 0, "ended with 0"), ("python3-numpy", 2, "ended with 2")])
def test_a_set_up_in_the_background_is_waited_for_by_its_process(missing, status, said):
    done = subprocess.run(["bash", "-c", MISSING, "bash", ROOT], capture_output=True, text=True, check=True,
                          env={"lacking": missing, "status": str(status), "PATH": "/usr/bin:/bin"})
    assert done.stdout.strip() == said


def test_a_set_up_in_the_background_says_what_is_missing_where_nobody_may_install():
    """Before any password is asked for, or sudo is called that is not there."""
    script = MISSING.replace("as_root() { :; }", 'id() { echo 1000; }; as_root() { echo "asked for root"; }'
                             '; command() { [ "$2" != sudo ]; }')
    done = subprocess.run(["bash", "-c", script, "bash", ROOT], capture_output=True, text=True,
                          env={"lacking": "python3-numpy", "status": "0", "PATH": "/usr/bin:/bin"})
    assert done.returncode == 2 and done.stdout == ""
    assert done.stderr == "./play: needs root or sudo to install: python3-numpy\n"

"""Which packages the two commands install: scripts/packages, read by scripts/common.sh."""
import pathlib
import subprocess

ROOT = pathlib.Path(__file__).resolve().parents[2]
# A Debian in which `have` is installed and `offered` could be; `mentioned` is a name without a package.
DEBIAN = """root=$1 command=./test; shift; . "$root/scripts/common.sh"
fetch_lists() { :; }; installed() { [ "$1" = have ]; }; 
apt-cache() { case $2 in offered) echo "Package: offered" ;; mentioned) ;; *) return 100 ;; esac; }
choose_packages "$@" """


def chosen(*words):
    return subprocess.run(["bash", "-c", DEBIAN, "bash", ROOT, *words], capture_output=True, text=True,
                          check=True).stdout.split()


def test_the_first_alternative_that_debian_has_is_taken():
    assert chosen("missing|have", "missing|offered|have", "offered|have") == ["have", "offered", "offered"]


def test_what_is_optional_is_left_out_where_debian_lacks_it():
    assert chosen("missing?", "mentioned?", "offered?", "have?") == ["offered", "have"]
    assert chosen("mentioned|offered") == ["offered"]


def test_a_plain_name_is_asked_for_even_where_debian_lacks_it():
    """So that installing it fails and says so."""
    assert chosen("missing", "have") == ["missing", "have"]


def test_every_line_of_the_list_is_a_group_of_words():
    lines = [line for line in (ROOT / "scripts" / "packages").read_text().splitlines() if not line.startswith("#")]
    assert lines and all(line.partition(": ")[0].isalpha() and line.partition(": ")[2] for line in lines)


MISSING = """root=$1 command=./play; . "$root/scripts/common.sh"
missing_packages() { echo "$missing"; }; as_root() { :; }; set_up() { sleep 0.2; return "$status"; }
begin_set_up play; [ -z "$installer" ] && echo none || { wait "$installer"; echo "ended with $?"; }"""


def begun(missing, status=0):
    return subprocess.run(["bash", "-c", MISSING, "bash", ROOT], capture_output=True, text=True, check=True,
                          env={"missing": missing, "status": str(status), "PATH": "/usr/bin:/bin"}).stdout.strip()


def test_a_set_up_in_the_background_is_waited_for_by_its_process():
    assert begun("") == "none"
    assert begun("python3-numpy") == "ended with 0"
    assert begun("python3-numpy", 2) == "ended with 2"

"""Programs that the tests start, ended with them."""
import pathlib
import sys

import pytest

ROOT = pathlib.Path(__file__).parents[2]
sys.path[:0] = [str(ROOT / "scripts"), str(ROOT / "tests/devices/live"), str(ROOT / "tests/patches")]
from emulated_network import EmulatedNetwork, NoNamespaces  # noqa: E402
from pd_process import Pd  # noqa: E402
from peer import Program  # noqa: E402
from relay import Relay  # noqa: E402


@pytest.fixture
def program(tmp_path):
    """Starts haptic_server with these options; its `relay` is a line to it, good at first."""
    running = []

    def start(*options, **more):
        folder = tmp_path / f"server{len(running)}"
        folder.mkdir()
        server = Program(folder, *options, **more)
        server.relay = Relay(server.port)
        running.append(server)
        return server
    yield start
    for server in running:
        server.relay.close()
        server.process.kill()
        server.process.wait()


@pytest.fixture
def pd(tmp_path):
    """Starts a Pd that plays these lines of a patch."""
    running = []

    def start(*lines, **options):
        running.append(Pd(tmp_path, *lines, **options))
        return running[-1]
    yield start
    for one in running:
        one.close()


@pytest.fixture
def network():
    """Two computers, `near` and `far`, in network namespaces with a line between them."""
    try:
        opened = EmulatedNetwork(["near", "far"], seed=3)
    except NoNamespaces as missing:
        pytest.skip(f"no network namespaces here: {missing}")
    with opened:
        yield opened


@pytest.fixture
def token(tmp_path):
    """A file with a token, sixteen bytes ok."""
    file = tmp_path / "token"
    file.write_text("sixteen bytes ok\n")
    file.chmod(0o600)
    return str(file)

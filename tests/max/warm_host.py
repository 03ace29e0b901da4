"""Wine takes seconds to start after its last program ended: one host waits while others run."""
import contextlib
import subprocess


@contextlib.contextmanager
def warm(host):
    """Starts a host, waits until it answers, and ends it when the block is left."""
    waiting = subprocess.Popen(host, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    waiting.stdin.write("echo ready\n")
    waiting.stdin.flush()
    waiting.stdout.readline()
    try:
        yield
    finally:
        waiting.communicate("")

"""A client of `part_stress serve` and `modal_fem serve`."""
import struct
import subprocess

MAGIC, SOLVE, QUIT, READY, STRESS, REFUSED, MODES = 0x31525354, 1, 2, 16, 17, 18, 19


class Server:
    """The program in its role as a child: messages to its stdin and from its stdout."""

    def __init__(self, program, folder, table, *words):
        self.process = subprocess.Popen([program, "serve", table, *words], cwd=folder, stdin=subprocess.PIPE,
                                        stdout=subprocess.PIPE, stderr=subprocess.PIPE)

    def send(self, kind, payload=b"", magic=MAGIC, size=None):
        self.process.stdin.write(struct.pack("<IIQ", magic, kind, len(payload) if size is None else size) + payload)
        self.process.stdin.flush()

    def read(self):
        header = self.process.stdout.read(16)
        assert len(header) == 16, self.process.stderr.read()
        magic, kind, size = struct.unpack("<IIQ", header)
        assert magic == MAGIC
        payload = self.process.stdout.read(size)
        assert len(payload) == size
        return kind, payload

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.kill()
        self.process.wait()
        for pipe in (self.process.stdin, self.process.stdout, self.process.stderr):
            try:
                pipe.close()
            except BrokenPipeError:
                pass

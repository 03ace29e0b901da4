"""Computers on one machine: network namespaces, joined by lines with a delay, jitter and loss.

    with EmulatedNetwork(["device", "sound"], delay_ms=10, loss=0.05) as network:
        network.start("device", ["haptic_server", "--listen", network.address("device"), ...])

Each computer is a network namespace with one interface, a TUN device whose packets a process of this
module carries to the others: every packet waits delay_ms one way, plus an exponential jitter of mean
jitter_ms (so that packets overtake each other), and is lost with the probability `loss`. What the
kernels do about it, retransmissions and congestion control, is their own; netem is not needed.
Needs root (or CAP_NET_ADMIN and CAP_SYS_ADMIN) and /dev/net/tun.
"""
import argparse
import ctypes
import fcntl
import heapq
import os
import pathlib
import random
import select
import signal
import socket
import struct
import subprocess
import sys
import time

CLONE_NEWNET = 0x40000000
PR_SET_PDEATHSIG = 1
TUNSETIFF, IFF_TUN, IFF_NO_PI = 0x400454CA, 0x0001, 0x1000
FORWARD = pathlib.Path(__file__).with_name("tcp_forward.py")
PREFIX = "10.78.0"
MTU = 1500
QUEUE_BYTES = 1 << 20  # of one line; what is more is dropped, as a router does


class NoNamespaces(RuntimeError):
    """This machine or account cannot make network namespaces; the text says what is missing."""


def ip(*words):
    """The command `ip`; raises NoNamespaces with its complaint."""
    try:
        subprocess.run(["ip", *words], capture_output=True, text=True, check=True)
    except FileNotFoundError as missing:
        raise NoNamespaces("the command ip (package iproute2) is missing") from missing
    except subprocess.CalledProcessError as refused:
        raise NoNamespaces(f"ip {' '.join(words)}: {refused.stderr.strip()}; network namespaces need "
                           "root") from refused


class EmulatedNetwork:
    """Open from its construction on. Namespaces are named after this process, so that several can
    run at once; raises NoNamespaces."""

    def __init__(self, computers, delay_ms=0.0, jitter_ms=0.0, loss=0.0, seed=1, nice=0):
        """nice: of every process of this network; a measurement beside other work takes -10."""
        self.computers = list(computers)
        self.nice = ["nice", "-n", str(nice)] if nice else []
        self.line = {"delay_ms": delay_ms, "jitter_ms": jitter_ms, "loss": loss, "seed": seed}
        self.router, self.processes = None, []
        self._open()

    def namespace(self, computer):
        return f"tactus{os.getpid()}{self.computers.index(computer)}"

    def address(self, computer):
        return f"{PREFIX}.{self.computers.index(computer) + 1}"

    def _open(self):
        try:
            for computer in self.computers:
                name = self.namespace(computer)
                ip("netns", "add", name)
                ip("-n", name, "link", "set", "lo", "up")
            if self.computers[1:]:
                self._join()
        except BaseException:
            self.close()
            raise

    def _join(self):
        names = [self.namespace(computer) for computer in self.computers]
        words = [f"--{key.replace('_', '-')}={value}" for key, value in self.line.items()]
        self.router = subprocess.Popen([*self.nice, sys.executable, __file__, *words, *names],
                                       stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        if self.router.stdout.readline() != "ready\n":
            raise NoNamespaces(self.router.communicate()[1].strip().splitlines()[-1])
        for computer, name in zip(self.computers, names):
            ip("-n", name, "addr", "add", f"{self.address(computer)}/24", "dev", "line")
            ip("-n", name, "link", "set", "line", "mtu", str(MTU), "up")

    def inside(self, computer):
        """What is put before a command that is to run on that computer."""
        return [*self.nice, "ip", "netns", "exec", self.namespace(computer)]

    def start(self, computer, command, **options):
        """subprocess.Popen on that computer; ended with the network."""
        process = subprocess.Popen([*self.inside(computer), *map(str, command)], **options)
        self.processes.append(process)
        return process

    def socket(self, computer, kind=socket.SOCK_DGRAM):
        """A socket of this process on that computer's network."""
        return inside_namespace(self.namespace(computer), lambda: socket.socket(socket.AF_INET, kind))

    def tunnel(self, near, far, port):
        """Port `port` of 127.0.0.1 on `near` becomes that of 127.0.0.1 on `far`, as
        `ssh -L port:127.0.0.1:port far` on `near` does it."""
        if near == far:
            return
        for computer, words in (
                (far, [self.address(far), port, "127.0.0.1", port]),
                (near, ["127.0.0.1", port, self.address(far), port])):
            process = self.start(computer, [sys.executable, FORWARD, *words], stdout=subprocess.PIPE)
            process.stdout.readline()

    def close(self):
        for process in self.processes:
            process.kill()
            process.wait()
        if self.router:
            self.router.send_signal(signal.SIGTERM)
            self.router.wait()
        for computer in self.computers:
            subprocess.run(["ip", "netns", "del", self.namespace(computer)], capture_output=True)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()


def inside_namespace(namespace, make):
    """What `make` returns, called with this thread in that network namespace."""
    libc = ctypes.CDLL(None, use_errno=True)

    def enter(here):
        if libc.setns(here.fileno(), CLONE_NEWNET) != 0:
            raise OSError(ctypes.get_errno(), f"cannot enter the network namespace {namespace}")
    with open("/proc/thread-self/ns/net") as home, open(f"/run/netns/{namespace}") as there:
        enter(there)
        try:
            return make()
        finally:
            enter(home)


def open_tun():
    """The end of the interface `line`, from which packets are read."""
    tun = os.open("/dev/net/tun", os.O_RDWR | os.O_NONBLOCK)
    fcntl.ioctl(tun, TUNSETIFF, struct.pack("16sH", b"line", IFF_TUN | IFF_NO_PI))
    return tun


def route(tuns, delay_ms, jitter_ms, loss, seed):
    """Carries packets until SIGTERM. The last byte of an IPv4 destination chooses the line."""
    chance = random.Random(seed)
    waiting, number = [], 0
    queued = [0] * len(tuns)
    while True:
        pause = max(0.0, waiting[0][0] - time.monotonic()) if waiting else None
        readable, _, _ = select.select(tuns, [], [], pause)
        now = time.monotonic()
        for tun in readable:
            while True:
                try:
                    packet = os.read(tun, 65536)
                except BlockingIOError:
                    break
                to = packet[19] - 1 if len(packet) >= 20 and packet[0] >> 4 == 4 else -1
                if not 0 <= to < len(tuns) or chance.random() < loss or \
                        queued[to] + len(packet) > QUEUE_BYTES:
                    continue
                wait = delay_ms + (chance.expovariate(1 / jitter_ms) if jitter_ms else 0.0)
                number += 1
                queued[to] += len(packet)
                heapq.heappush(waiting, (now + wait / 1e3, number, to, packet))
        while waiting and waiting[0][0] <= now:
            _, _, to, packet = heapq.heappop(waiting)
            queued[to] -= len(packet)
            try:
                os.write(tuns[to], packet)
            except OSError:  # an interface that is down loses what it is given
                pass


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--delay-ms", type=float, default=0)
    parser.add_argument("--jitter-ms", type=float, default=0)
    parser.add_argument("--loss", type=float, default=0)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("namespaces", nargs="+")
    words = parser.parse_args()
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(0))
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the terminal's; whoever started this ends it
    ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGTERM)  # or dies
    try:
        tuns = [inside_namespace(namespace, open_tun) for namespace in words.namespaces]
    except OSError as refused:
        sys.exit(f"/dev/net/tun: {refused.strerror}; lines between namespaces need root and TUN devices")
    print("ready", flush=True)
    route(tuns, words.delay_ms, words.jitter_ms, words.loss, words.seed)


if __name__ == "__main__":
    main()

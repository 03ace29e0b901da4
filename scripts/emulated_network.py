"""Computers on one machine: network namespaces, connected with a delay, jitter and loss.

    with EmulatedNetwork(["device", "sound"], delay_ms=10, loss=0.05) as network:
        network.start("device", ["haptic_server", "--listen", network.address("device"), ...])

Each computer is a network namespace with one interface, a TUN device whose packets a process of this module carries to
the others. Every packet waits delay_ms one way, plus an exponential jitter of mean jitter_ms (so that packets overtake
each other), and is lost with the probability `loss`. While the connection is `held`, no packet passes; when that ends,
all waiting packets pass at once. While it is `cut`, packets are dropped without notice (half-open connections).
set_line changes these settings at any time. set_link takes a computer's interface down and notifies the kernel.
Retransmission and congestion control are those of the real kernels; netem is not needed. Needs root (or CAP_NET_ADMIN
and CAP_SYS_ADMIN) and /dev/net/tun.
"""
import argparse
import ctypes
import fcntl
import heapq
import json
import os
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
PREFIX = "10.78.0"
MTU = 1500
QUEUE_BYTES = 1 << 20  # per connection; packets beyond that are dropped, as by a router
LINE = {"delay_ms": 0.0, "jitter_ms": 0.0, "loss": 0.0, "held": False, "cut": False}


class NoNamespaces(RuntimeError):
    """This machine or account cannot make network namespaces; the text says what is missing."""


def ip(*words):
    """The command `ip`; raises NoNamespaces with the command's error text."""
    try:
        subprocess.run(["ip", *words], capture_output=True, text=True, check=True)
    except FileNotFoundError as missing:
        raise NoNamespaces("the command ip (package iproute2) is missing") from missing
    except subprocess.CalledProcessError as refused:
        raise NoNamespaces(f"ip {' '.join(words)}: {refused.stderr.strip()}; network namespaces need "
                           "root") from refused


class EmulatedNetwork:
    """The network is open from construction on. Namespaces are named after this process, so that several can run at
    once; raises NoNamespaces."""

    def __init__(self, computers, seed=1, nice=0, **line):
        """line: see set_line. nice: niceness of every process of this network; use -10 to measure beside other work."""
        self.computers = list(computers)
        self.nice = ["nice", "-n", str(nice)] if nice else []
        self.router, self.processes, self.opened = None, [], []
        self._open(seed, line)

    def namespace(self, computer):
        return f"tactus{os.getpid()}{self.computers.index(computer)}"

    def address(self, computer):
        return f"{PREFIX}.{self.computers.index(computer) + 1}"

    def _open(self, seed, line):
        try:
            for computer in self.computers:
                name = self.namespace(computer)
                ip("netns", "add", name)
                self.opened.append(name)
                ip("-n", name, "link", "set", "lo", "up")
            if self.computers[1:]:
                self._join(seed)
                self.set_line(**line)
        except BaseException:
            self.close()
            raise

    def _join(self, seed):
        names = [self.namespace(computer) for computer in self.computers]
        self.router = subprocess.Popen([*self.nice, sys.executable, __file__, str(seed), *names], text=True,
                                       stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        if self.router.stdout.readline() != "ready\n":
            raise NoNamespaces(self.router.communicate()[1].strip().splitlines()[-1])
        for computer, name in zip(self.computers, names):
            ip("-n", name, "addr", "add", f"{self.address(computer)}/24", "dev", "line")
            ip("-n", name, "link", "set", "line", "mtu", str(MTU), "up")

    def set_line(self, **line):
        """delay_ms, jitter_ms: for packets sent from now on; loss: fraction that is dropped; held, cut: also for
        waiting packets. Settings that are not given keep their values. The settings are in effect when this returns."""
        if unknown := set(line) - set(LINE):
            raise TypeError(f"unknown setting {', '.join(sorted(unknown))}: expected {', '.join(LINE)}")
        if self.router:
            self.router.stdin.write(json.dumps(line) + "\n")
            self.router.stdin.flush()
            self.router.stdout.readline()

    def set_link(self, computer, up):
        """Takes a computer's interface up or down, like plugging in or pulling its cable."""
        ip("-n", self.namespace(computer), "link", "set", "line", "up" if up else "down")

    def inside(self, computer):
        """The words put before a command to run it on that computer."""
        return [*self.nice, "ip", "netns", "exec", self.namespace(computer)]

    def start(self, computer, command, **options):
        """subprocess.Popen on that computer; the process ends with the network."""
        process = subprocess.Popen([*self.inside(computer), *map(str, command)], **options)
        self.processes.append(process)
        return process

    def socket(self, computer, kind=socket.SOCK_DGRAM):
        """A socket of this process on that computer's network."""
        return inside_namespace(self.namespace(computer), lambda: socket.socket(socket.AF_INET, kind))

    def close(self):
        for process in self.processes:
            process.kill()
            process.wait()
        if self.router:
            self.router.send_signal(signal.SIGTERM)
            self.router.communicate()
        for name in self.opened:
            subprocess.run(["ip", "netns", "del", name], capture_output=True)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()


def inside_namespace(namespace, make):
    """Calls `make` with this thread in that network namespace; returns its result."""
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
    """Opens the end of the interface `line` from which packets are read."""
    tun = os.open("/dev/net/tun", os.O_RDWR | os.O_NONBLOCK)
    fcntl.ioctl(tun, TUNSETIFF, struct.pack("16sH", b"line", IFF_TUN | IFF_NO_PI))
    return tun


def route(tuns, seed, orders):
    """Carries packets until SIGTERM. The last byte of an IPv4 destination selects the interface. Each text line of the
    descriptor `orders` is JSON that changes LINE and is answered on the standard output."""
    chance, line = random.Random(seed), dict(LINE)
    waiting, number = [], 0
    queued = [0] * len(tuns)
    while True:
        due_s = waiting[0][0] if waiting and not line["held"] else None
        pause = None if due_s is None else max(0.0, due_s - time.monotonic())
        readable, _, _ = select.select([orders, *tuns], [], [], pause)
        for tun in readable:
            if tun is orders:
                if not (text := orders.readline()):
                    return
                line.update(json.loads(text))
                print("set", flush=True)
                continue
            while True:
                try:
                    packet = os.read(tun, 65536)
                except BlockingIOError:
                    break
                read_s = time.monotonic()  # after the packet was sent, so that delays are not too short
                to = packet[19] - 1 if len(packet) >= 20 and packet[0] >> 4 == 4 else -1
                if not 0 <= to < len(tuns) or chance.random() < line["loss"] or \
                        queued[to] + len(packet) > QUEUE_BYTES:
                    continue
                jitter_ms = line["jitter_ms"]
                wait_ms = line["delay_ms"] + (chance.expovariate(1 / jitter_ms) if jitter_ms else 0.0)
                number += 1
                queued[to] += len(packet)
                heapq.heappush(waiting, (read_s + wait_ms / 1e3, number, to, packet))
        now = time.monotonic()
        while waiting and (line["cut"] or waiting[0][0] <= now and not line["held"]):
            _, _, to, packet = heapq.heappop(waiting)
            queued[to] -= len(packet)
            if line["cut"]:
                continue
            try:
                os.write(tuns[to], packet)
            except OSError:  # an interface that is down drops packets
                pass


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("seed", type=int)
    parser.add_argument("namespaces", nargs="+")
    words = parser.parse_args()
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(0))
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # ignores the terminal's interrupt, since the parent ends this process
    ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGTERM)  # ends with its parent
    try:
        tuns = [inside_namespace(namespace, open_tun) for namespace in words.namespaces]
    except OSError as refused:
        sys.exit(f"/dev/net/tun: {refused.strerror}; connections between namespaces need root and TUN devices")
    print("ready", flush=True)
    route(tuns, words.seed, sys.stdin)


if __name__ == "__main__":
    main()

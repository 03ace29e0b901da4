"""Two network namespaces and a line of IP packets between them that this process carries: packets are
delayed, lost and overtake each other below TCP, which repeats and sorts them as on a real line."""
import fcntl
import heapq
import os
import random
import select
import struct
import subprocess
import threading
import time

TUNSETIFF, IFF_TUN, IFF_NO_PI = 0x400454CA, 0x0001, 0x1000
ADDRESSES = ("10.78.0.1", "10.78.0.2")


class Refused(Exception):
    """This machine makes no namespaces or no TUN devices."""


class Tunnel:
    """delay_s, jitter_s: of each packet, so that packets overtake each other; loss: share of packets
    that vanish; cut: nothing passes and nobody is told. Settings may change at any time."""

    def __init__(self, seed=1):
        self.delay_s = self.jitter_s = self.loss = 0.0
        self.cut, self.ended = False, threading.Event()
        self.chance = random.Random(seed)
        self.names = [f"tactus{os.getpid()}{end}" for end in "cd"]
        self.devices = [f"tact{os.getpid() % 100000}{end}" for end in "cd"]
        self.files = []
        try:
            for name, device, address in zip(self.names, self.devices, ADDRESSES):
                self.ip("netns", "add", name)
                self.files.append(os.open("/dev/net/tun", os.O_RDWR | os.O_NONBLOCK))
                fcntl.ioctl(self.files[-1], TUNSETIFF,
                            struct.pack("16sH22x", device.encode(), IFF_TUN | IFF_NO_PI))
                self.ip("link", "set", device, "netns", name)
                self.ip("-n", name, "addr", "add", f"{address}/24", "dev", device)
                self.ip("-n", name, "link", "set", device, "up")
                self.ip("-n", name, "link", "set", "lo", "up")
        except (subprocess.CalledProcessError, OSError) as refused:
            self.close()
            raise Refused(getattr(refused, "stderr", None) or refused) from refused
        self.thread = threading.Thread(target=self.carry, daemon=True)
        self.thread.start()

    @staticmethod
    def ip(*words):
        subprocess.run(["ip", *words], capture_output=True, text=True, check=True)

    def inside(self, end):
        """Words in front of a program that runs at that end, 0 or 1."""
        return ["ip", "netns", "exec", self.names[end]]

    def carry(self):
        waiting, count = [], 0  # (time, number, end, packet)
        while not self.ended.is_set():
            pause = max(0.0, min(0.05, waiting[0][0] - time.monotonic())) if waiting else 0.05
            for file in select.select(self.files, [], [], pause)[0]:
                packet = os.read(file, 65536)
                if self.cut or self.chance.random() < self.loss:
                    continue
                due = time.monotonic() + self.delay_s + self.jitter_s * self.chance.random()
                count += 1
                heapq.heappush(waiting, (due, count, 1 - self.files.index(file), packet))
            while waiting and waiting[0][0] <= time.monotonic():
                _, _, end, packet = heapq.heappop(waiting)
                try:
                    if not self.cut:
                        os.write(self.files[end], packet)
                except OSError:  # full, or the device is down: lost
                    pass

    def close(self):
        self.ended.set()
        if hasattr(self, "thread"):
            self.thread.join()
        for file in self.files:
            os.close(file)
        for name in self.names:
            subprocess.run(["ip", "netns", "del", name], capture_output=True)

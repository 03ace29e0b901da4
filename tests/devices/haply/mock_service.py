"""A stand-in for Haply's inverse service, by another WebSocket and JSON library than the driver's.

Keeps the service's rules: an inventory first, then one state for each message, force that lives for
one message. Says "port N", then obeys lines on its standard input: `place X Y Z` (m, service's axes),
`calibrated 0|1`, `garbage N` (answers that are no JSON), `unplug`, `plug`, `quiet` (no answers),
`drop`, `report`.
"""
import asyncio
import json
import sys

import websockets

PERIOD_S, MASS_KG = 1e-3, 0.1


class Service:
    def __init__(self, kind):
        self.kind = kind
        self.position = [0.0, -0.12, 0.15]
        self.velocity = [0.0, 0.0, 0.0]
        self.force = [0.0, 0.0, 0.0]
        self.calibrated, self.plugged, self.quiet = True, True, False
        self.garbage = 0
        self.sessions = self.messages = self.wrong = 0
        self.profile = ""
        self.basis = ""
        self.clients = set()

    def vector(self, v):
        return dict(zip("xyz", v))

    def device(self, full):
        state = {"cursor_position": self.vector(self.position),
                 "cursor_velocity": self.vector(self.velocity),
                 "current_cursor_force": self.vector(self.force), "control_mode": "idle"}
        answer = {"device_id": "049D", "state": state, "status": {"calibrated": self.calibrated}}
        if full:
            answer["config"] = {"type": "inverse3", "handedness": "right",
                                "extended_firmware_version": "7.4"}
        elif self.messages % 2:
            del answer["status"]  # nothing new in it
        return answer

    def all(self, full):
        if self.kind == "empty" or not self.plugged:
            return json.dumps({"inverse3": []})
        grip = {"device_id": "61D6", "state": {"orientation": {"w": 0.7071067811865476, "x": 0.0,
                "y": 0.0, "z": 0.7071067811865475}, "buttons": {"a": False, "b": True, "c": False}}}
        return json.dumps({"session_id": self.sessions, "inverse3": [self.device(full)],
                           "wireless_verse_grip": [grip]})

    def obey(self, text, first):
        message = json.loads(text)
        if first:
            configure = message["session"]["configure"]
            self.profile = configure["profile"]["name"]
            self.basis = configure["basis"]["permutation"]
        elif "session" in message:
            self.wrong += 1
        (device,) = message["inverse3"]
        wanted = device["commands"]["set_cursor_force"]["vector"]
        if device["device_id"] != "049D" or set(wanted) != set("xyz"):
            self.wrong += 1
        self.force = [float(wanted[axis]) for axis in "xyz"]
        for i in range(3):
            self.velocity[i] += PERIOD_S * (self.force[i] - self.velocity[i]) / MASS_KG
            self.position[i] += PERIOD_S * self.velocity[i]

    async def talk(self, socket):
        self.sessions += 1
        self.clients.add(socket)
        try:
            if self.kind == "prose":
                await socket.send("hello, who is there?")
            else:
                await socket.send(self.all(True))
            first = True
            async for text in socket:
                self.messages += 1
                try:
                    self.obey(text, first)
                except (KeyError, TypeError, ValueError):
                    self.wrong += 1
                first = False
                if self.quiet:
                    continue
                if self.garbage > 0:
                    self.garbage -= 1
                    await socket.send('{"inverse3": [{"device_id": "049D", "state": {"cursor_pos')
                else:
                    await socket.send(self.all(False))
        except websockets.ConnectionClosed:
            pass
        finally:
            self.clients.discard(socket)

    async def command(self, words):
        if words[0] == "place":
            self.position, self.velocity = [float(w) for w in words[1:4]], [0.0] * 3
        elif words[0] == "calibrated":
            self.calibrated = words[1] == "1"
        elif words[0] == "garbage":
            self.garbage = int(words[1])
        elif words[0] in ("unplug", "plug"):
            self.plugged = words[0] == "plug"
        elif words[0] == "quiet":
            self.quiet = True
        elif words[0] == "drop":
            for socket in list(self.clients):
                await socket.close()
        print("report", *self.force, self.messages, self.sessions, self.wrong,
              self.profile or "-", self.basis or "-", flush=True)


async def main(kind, port):
    service = Service(kind)
    loop = asyncio.get_running_loop()
    reader = asyncio.StreamReader()
    await loop.connect_read_pipe(lambda: asyncio.StreamReaderProtocol(reader), sys.stdin)
    async with websockets.serve(service.talk, "127.0.0.1", port, compression=None) as server:
        print("port", server.sockets[0].getsockname()[1], flush=True)
        while line := await reader.readline():
            await service.command(line.decode().split())


asyncio.run(main(sys.argv[1], int(sys.argv[2])))

"""A stand-in for Haply's inverse service, by another WebSocket and JSON library than the driver's.

Keeps the service's rules: an inventory first, then one state for each message, force that lives for
one message. Says "port N", then obeys lines on its standard input: `begin KIND` (all anew), `place X Y Z` (m,
service's axes), `workspace [scale S] [quarter] [offset X Y Z]` (as navigation sets it), `calibrated 0|1`,
`garbage N` (answers that are no JSON), `unplug`, `plug`, `quiet` (no answers), `drop`, `pad N` (so many
letters more in each answer), `report`. A service of kind `old` knows no presets and no axes and takes
a force by the key `values`, as public clients of version 3.1 send it (isaac-sim/IsaacLab,
source/isaaclab/isaaclab/devices/haply/se3_haply.py), the others by `vector` (docs.haply.co, 3.5); `two` has a
Minverse, 04BA, too, and no grip; `late` shows its configuration one message late; `scaled` has a mount
that shows everything twice as large; `empty` has no device, `prose` no JSON.
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
        self.garbage = self.pad = 0
        self.sessions = self.messages = self.wrong = 0
        self.profile = ""
        self.basis = "-ZXY"  # another program's
        self.preset = "defaults"
        self.full = False
        self.workspace = {}
        self.clients = set()
        self.config = {"type": "inverse3"}

    def vector(self, v):
        return dict(zip("xyz", v))

    def placed(self, v, point):
        """Device's base to application: preset's mount, then the workspace transform."""
        if point and self.preset == "arm_front_centered":
            v = [v[0], v[1] + 0.12, v[2] - 0.15]
        if self.kind == "scaled":
            v = [2 * c for c in v]
        scale = self.workspace.get("scale", 1.0)
        v = [scale * c for c in v]
        if "quarter" in self.workspace:  # about z
            v = [-v[1], v[0], v[2]]
        if point:
            v = [c + o for c, o in zip(v, self.workspace.get("offset", [0.0] * 3))]
        return v

    def transform(self):
        parts = {}
        if "scale" in self.workspace:
            parts["scale"] = self.vector([self.workspace["scale"]] * 3)
        if "quarter" in self.workspace:
            half = 0.7071067811865476
            parts["rotation"] = {"w": half, "x": 0.0, "y": 0.0, "z": half}
        if "offset" in self.workspace:
            parts["position"] = self.vector(self.workspace["offset"])
        return parts

    def device(self, full):
        state = {"cursor_position": self.vector(self.placed(self.position, True)),
                 "cursor_velocity": self.vector(self.placed(self.velocity, False)),
                 "transform": self.transform(),
                 "current_cursor_force": self.vector(self.force), "control_mode": "idle"}
        answer = {"device_id": "049D", "state": state, "status": {"calibrated": self.calibrated}}
        if full:
            answer["config"] = {"type": "inverse3", "handedness": "right",
                                "extended_firmware_version": "7.4", "preset": self.preset,
                                "basis": {"permutation": self.basis},
                                "mount": {"position": self.vector([0.0] * 3)}}
            if self.kind == "scaled":
                answer["config"]["mount"]["scale"] = self.vector([2.0] * 3)
            if self.kind == "old":
                answer["config"] = {"type": "inverse3"}
            if self.kind == "late":
                answer["config"], self.config = self.config, answer["config"]
        elif self.messages % 2:
            del answer["status"]  # nothing new in it
        return answer

    def all(self, full):
        if self.kind == "empty" or not self.plugged:
            return json.dumps({"inverse3": []})
        grip = {"device_id": "61D6", "state": {"orientation": {"w": 0.7071067811865476, "x": 0.0,
                "y": 0.0, "z": 0.7071067811865475}, "buttons": {"a": False, "b": True, "c": False}}}
        if self.kind == "two":
            other = self.device(full)
            other["device_id"], other["state"]["cursor_position"] = "04BA", self.vector([0.02, 0.0, 0.0])
            if full:
                other["config"]["type"] = "minverse"
            return json.dumps({"inverse3": [self.device(full), other]})
        return json.dumps({"session_id": self.sessions, "inverse3": [self.device(full)],
                           "wireless_verse_grip": [grip]})

    def obey(self, text, first):
        message = json.loads(text)
        session = message.pop("session", {})
        configure = session.pop("configure", {})
        self.full = session.pop("force_render_full_state", None) is not None
        if first:
            self.profile = configure["profile"]["name"]
        if self.kind != "old":
            self.basis = configure.get("basis", {}).get("permutation", self.basis)
        if session:
            self.wrong += 1
        (device,) = message["inverse3"]
        preset = device.get("configure", {}).get("preset", {}).get("preset")
        if preset and self.kind != "old":
            self.preset, self.basis = preset, "XZY"  # a preset may bring its axes
        wanted = device["commands"]["set_cursor_force"]["values" if self.kind == "old" else "vector"]
        if (preset or self.full) and any(wanted.values()):
            self.wrong += 1  # a force before the frame is known
        if device["device_id"] not in ("049D", "04BA"[:4 * (self.kind == "two")]) or set(wanted) != set("xyz"):
            self.wrong += 1
        self.force = [float(wanted[axis]) for axis in "xyz"]
        if "quarter" in self.workspace:  # said in the application's space
            self.force = [self.force[1], -self.force[0], self.force[2]]
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
                    text = self.all(self.full)
                    await socket.send(text[:-1] + f', "pad": "{"x" * self.pad}"}}' if self.pad else text)
        except websockets.ConnectionClosed:
            pass
        finally:
            self.clients.discard(socket)

    async def command(self, words):
        if words[0] == "begin":
            for socket in list(self.clients):
                await socket.close()
            self.__init__(words[1])
        elif words[0] == "place":
            self.position, self.velocity = [float(w) for w in words[1:4]], [0.0] * 3
        elif words[0] == "workspace":  # scale S, quarter, offset X Y Z; nothing ends it
            self.workspace = {}
            if "scale" in words:
                self.workspace["scale"] = float(words[words.index("scale") + 1])
            if "quarter" in words:
                self.workspace["quarter"] = True
            if "offset" in words:
                at = words.index("offset")
                self.workspace["offset"] = [float(w) for w in words[at + 1:at + 4]]
        elif words[0] == "calibrated":
            self.calibrated = words[1] == "1"
        elif words[0] == "garbage":
            self.garbage = int(words[1])
        elif words[0] == "pad":
            self.pad = int(words[1])
        elif words[0] in ("unplug", "plug"):
            self.plugged = words[0] == "plug"
        elif words[0] == "quiet":
            self.quiet = True
        elif words[0] == "drop":
            for socket in list(self.clients):
                await socket.close()
        print("report", *self.force, self.messages, self.sessions, self.wrong,
              self.profile or "-", self.basis or "-", self.preset, flush=True)


async def main(port):
    service = Service("one")
    loop = asyncio.get_running_loop()
    reader = asyncio.StreamReader()
    await loop.connect_read_pipe(lambda: asyncio.StreamReaderProtocol(reader), sys.stdin)
    async with websockets.serve(service.talk, "127.0.0.1", port, compression=None) as server:
        print("port", server.sockets[0].getsockname()[1], flush=True)
        while line := await reader.readline():
            await service.command(line.decode().split())


asyncio.run(main(int(sys.argv[1])))

"""Rewrites parts of a converted netlist that Max users would draw in another way; what they do is the same.

Many messages into one box, in Pd many cords, become messages with a receiver (`;name words`). What a [sel]
chooses from stands in steps, so that no cord runs through a message.
"""
from patcher import Box
import text_size

FEWEST = 3  # messages into one [s] that get its name instead
FEWEST_ELSEWHERE = 4
STEP = 24
LONG = 200  # pixels of a message that is in the way of cords


def address(box, name):
    """Sends each part of a message to a name."""
    parts = [part.strip() for part in box.text.split(",")]
    box.text = ";\n" + ";\n".join(f"{name} {part}" for part in parts)
    box.width, box.height = text_size.box_size(box.text, "message", max(box.width, 560))


def share_targets(patcher):
    """Messages that all go to the same several inlets meet in one [t]."""
    ends, order = {}, []
    for source, _, destination, inlet, _ in patcher.cords:
        if source.maxclass == "message" and ";" not in source.text:
            if id(source) not in ends:
                order.append(source)
            ends.setdefault(id(source), []).append((destination, inlet))
    groups = {}
    for source in order:
        key = tuple((id(d), i) for d, i in ends[id(source)])
        groups.setdefault(key, []).append(source)
    for key, sources in groups.items():
        if len(key) < 2 or len(sources) < FEWEST:
            continue
        targets = ends[id(sources[0])]
        trigger = patcher.add(Box("newobj", " ".join(["t"] + ["l"] * len(targets))))
        low = max(b.pd[1] for b in sources)
        trigger.pd = (targets[0][0].pd[0], max(low, targets[0][0].pd[1] - 30) + 1, 60, 12)
        patcher.cords = [c for c in patcher.cords if c[0] not in sources]
        for source in sources:
            patcher.connect(source, 0, trigger, 0)
        for i, (destination, inlet) in enumerate(targets):
            patcher.connect(trigger, len(targets) - 1 - i, destination, inlet)


def fan_ins(patcher):
    """{(box, inlet): [message boxes whose only cord enters there]}."""
    out = {}
    for cord in patcher.cords:
        out.setdefault(id(cord[0]), []).append(cord)
    groups = {}
    for source, _, destination, inlet, _ in patcher.cords:
        if source.maxclass == "message" and len(out[id(source)]) == 1 and ";" not in source.text:
            groups.setdefault((id(destination), inlet), (destination, []))[1].append(source)
    return groups


def name_fan_ins(patcher, stem):
    count = 0
    for (_, inlet), (destination, messages) in fan_ins(patcher).items():
        is_send = (destination.text or "").startswith("s ")
        if len(messages) < (FEWEST if is_send else FEWEST_ELSEWHERE):
            continue
        if is_send:
            name = destination.text.split(" ")[1]
        else:
            count += 1
            name = f"{stem}-{count}"
            receiver = patcher.add(Box("newobj", f"r {name}"))
            receiver.pd = (destination.pd[0] + 60 * (inlet > 0) + 2, destination.pd[1] - 21,
                           receiver.width / 1.12, 19)
            patcher.connect(receiver, 0, destination, inlet)
        patcher.cords = [c for c in patcher.cords if not (c[0] in messages and c[2] is destination)]
        for message in messages:
            address(message, name)
        if is_send and not any(c[2] is destination for c in patcher.cords):
            patcher.boxes.remove(destination)


def name_beside_receivers(patcher):
    """A long message into an inlet that an [r NAME] reaches as well goes to that name."""
    for source, _, destination, inlet, _ in list(patcher.cords):
        if source.maxclass != "message" or ";" in source.text or source.width < LONG or \
                sum(c[0] is source for c in patcher.cords) > 1:
            continue
        names = [c[0].text.split(" ")[1] for c in patcher.cords if c[2] is destination and c[3] == inlet
                 and (c[0].text or "").startswith("r ") and sum(o[0] is c[0] for o in patcher.cords) == 1]
        if names:
            patcher.cords = [c for c in patcher.cords if c[0] is not source]
            address(source, names[0])


def staircases(patcher):
    """The messages of a [sel] in steps from its right outlet at the top to its left at the bottom."""
    for box in [b for b in patcher.boxes if (b.text or "").startswith("sel ")]:
        cords = sorted((c for c in patcher.cords if c[0] is box), key=lambda c: c[1])
        targets = [c[2] for c in cords]
        if len(targets) < 2 or any(t.maxclass != "message" for t in targets) or any(
                c[0] in targets for c in patcher.cords):
            continue
        below = [b for b in patcher.boxes if b is not box and b not in targets and b.pd[1] > box.pd[1] + 10]
        end = box.pd[1] + 22 + 21 * len(targets) + 20
        room = max(0, end - min((b.pd[1] for b in below), default=end))
        for other in below:  # what stands below makes room
            other.pd = (other.pd[0], other.pd[1] + room, *other.pd[2:])
        count = len(box.outlets)
        box.width = max(box.width, STEP * 1.12 * (count - 1) + 18)
        box.pd = (*box.pd[:2], box.width / 1.12, box.pd[3])
        for i, target in enumerate(targets):
            target.pd = (box.pd[0] + STEP * cords[i][1], box.pd[1] + 22 + 21 * (len(targets) - 1 - i),
                         target.pd[2], 15)


def simplify(patcher, stem):
    share_targets(patcher)
    name_fan_ins(patcher, stem)
    name_beside_receivers(patcher)
    staircases(patcher)

"""Makes NAME.maxhelp from the example of the Pd help patch and from tabs with the declaration's texts.

The tabs: the example; every parameter as an attrui; every message; inlets and outlets. A tab is a
subpatcher with `showontab` in a patcher that shows its subpatchers as tabs.
"""
import max_objects
import pd_to_max
import text_size
from patcher import Box, Patcher

WIDTH = 780
LEFT = 16
TITLE_COLOUR = [0.184, 0.31, 0.373, 1.0]
WHITE = [1.0, 1.0, 1.0, 1.0]
MORE_ROWS = 24  # rows in a column of attributes


def number(value):
    return f"{value:.10g}"


def with_unit(text, unit):
    return f"{text} {unit}" if unit else text


def range_text(p):
    if p["choices"]:
        return ", ".join(p["choices"])
    if p["values"]:
        return with_unit(", ".join(map(number, p["values"])), p["unit"])
    return with_unit(f"{number(p['lowest'])} to {number(p['highest'])}", p["unit"])


def initial_text(p):
    return p["choices"][int(p["initial"])] if p["choices"] else number(p["initial"])


def ports_of(declaration, side):
    """The declared ports as the Max box has them, with a message inlet, and with the info outlet at the right."""
    listed = list(declaration[side])
    if side == "outlets" and "info" not in (p["name"] for p in listed):
        listed.append({"kind": "control", "name": "info", "unit": "",
                       "text": "answers to `get`, `dump` and other queries"})
    return listed


def paragraph(patcher, text, x, y, width, **extra):
    """Adds a comment as high as its text; returns the y below it."""
    size = extra.get("fontsize", text_size.FONT_SIZE)
    bold = extra.get("fontface") == 1
    wide, _ = text_size.box_size(text, "comment", width, size, bold)
    return patcher.comment(text, x, y, width=min(wide, width), **extra).bottom


def title(patcher, declaration, subtitle=None):
    patcher.comment(f"{declaration['name']}", LEFT, 12, width=WIDTH - 2 * LEFT, fontsize=22.0, fontface=1,
                    bgcolor=TITLE_COLOUR, textcolor=WHITE)
    return paragraph(patcher, subtitle or declaration["title"], LEFT, 56, WIDTH - 2 * LEFT, fontface=1) + 2


def example_tab(pd_path, declaration, names, abstractions, without):
    """The Pd help patch below a title and the declaration's paragraph, and the name to which its [r] listens."""
    tab = Patcher(WIDTH, 0, tab=True)
    y = title(tab, declaration)
    y = paragraph(tab, declaration["description"], LEFT, y, WIDTH - 2 * LEFT)
    tab, left_out = pd_to_max.convert_file(pd_path, names, abstractions, without, y + 14, tab)
    y = max(b.bottom for b in tab.boxes if not b.hidden)
    for what, reason in left_out:
        y = paragraph(tab, f"In Pd only: {what}: {reason}", LEFT, y + 8, WIDTH - 2 * LEFT)
    return tab.fit(), listening_name(tab, declaration["name"])


def listening_name(patcher, object_name):
    """The name whose [r] is connected to the object's left inlet."""
    for source, _, destination, inlet, _ in patcher.cords:
        if (inlet == 0 and (destination.text or "").split(" ")[0] == object_name
                and (source.text or "").startswith("r ")):
            return source.text.split(" ")[1]
    return None


def attribute_tab(declaration, listener):
    """One attrui per parameter, connected to an object in this tab and sent to the example's object."""
    tab = Patcher(WIDTH, 0, tab=True)
    y = title(tab, declaration, "attributes")
    text = (f"Type them with @ in the box ({declaration['name']} @{declaration['parameters'][0]['name']} "
            f"{initial_text(declaration['parameters'][0])}), send them as messages, query them with get, "
            "or use the inspector. Each menu here is wired to the object below")
    y = paragraph(tab, text + (" and to the example object." if listener else "."), LEFT, y,
                  WIDTH - 2 * LEFT) + 10
    menu_width = min(max(text_size.width(p["name"]) for p in declaration["parameters"]) + 110, 260)
    menus = []
    for p in declaration["parameters"]:
        menu = tab.add(Box("attrui", None, LEFT, y, width=round(menu_width), height=22, attr=p["name"],
                           text_width=round(menu_width) - 90.0, parameter_enable=0))
        menus.append(menu)
        text = f"{p['text']}: {range_text(p)}; initially {initial_text(p)}"
        bottom = paragraph(tab, text, menu.right + 10, y + 1, WIDTH - LEFT - menu.right - 10)
        y = max(menu.bottom, bottom) + 4
    instance = tab.object(declaration["name"], LEFT, y + 20)
    sender = tab.object(f"s {listener}", instance.right + 40, y + 20) if listener else None
    for menu in menus:
        tab.connect(menu, 0, instance, 0, hidden=True)
        if sender:
            tab.connect(menu, 0, sender, 0, hidden=True)
    _info_to_console(tab, instance, declaration)
    return tab.fit()


def _info_to_console(tab, instance, declaration):
    names = [p["name"] for p in ports_of(declaration, "outlets")]
    printer = tab.object(f"print {declaration['name']}", instance.x, instance.bottom + 22)
    tab.connect(instance, names.index("info"), printer, 0)


def message_tab(declaration, listener):
    """All messages. A message that needs no argument is a message box to click."""
    tab = Patcher(WIDTH, 0, tab=True)
    y = title(tab, declaration, "messages") + 6
    clickable = []
    for m in max_objects.messages(declaration):
        shown = f"{m['name']} {m['arguments']}".strip()
        if m["fewest"] == 0:
            box = tab.message(m["name"], LEFT, y)
            clickable.append(box)
            y = _arguments(tab, m, box, y)
        else:
            shown = shown.replace("|", " | ") if len(shown) > 36 else shown
            wide, _ = text_size.box_size(shown, "comment", 280, bold=True)
            box = tab.comment(shown, LEFT, y, width=min(wide, 280), fontface=1)
        bottom = paragraph(tab, m["text"], 310, box.y + 1, WIDTH - LEFT - 310)
        y = max(box.bottom, bottom) + 4
    target = f"s {listener}" if listener else declaration["name"]
    instance = tab.object(target, LEFT, y + 20)
    for box in clickable:
        tab.connect(box, 0, instance, 0, hidden=True)
    note = "to the example object" if listener else "receives the messages above"
    paragraph(tab, note, instance.right + 12, y + 21, 360)
    if not listener:
        _info_to_console(tab, instance, declaration)
    return tab.fit()


def _arguments(tab, message, box, y):
    if message["arguments"] and message["name"] != message["arguments"]:
        wide, _ = text_size.box_size(message["arguments"], "comment", 290 - box.right)
        if 290 - box.right > 60:
            tab.comment(message["arguments"], box.right + 6, y + 1, width=min(wide, 290 - box.right))
    return y


def port_tab(declaration):
    tab = Patcher(WIDTH, 0, tab=True)
    y = title(tab, declaration, "inlets and outlets") + 6
    for side in ("inlets", "outlets"):
        y = paragraph(tab, side, LEFT, y, 200, fontface=1) + 4
        for i, p in enumerate(ports_of(declaration, side)):
            label = f"{i + 1}  {p['kind'] if p['kind'] == 'signal' else 'messages'}"
            tab.comment(label, LEFT, y)
            text = f"{with_unit(p['name'], p['unit'] and '(' + p['unit'] + ')')}: {p['text']}"
            y = paragraph(tab, text, 130, y, WIDTH - LEFT - 130) + 3
        if side == "inlets":
            y += 6
            box = tab.object(declaration["name"], LEFT, y)
            box.width = max(box.width, 16.0 * max(len(box.inlets), len(box.outlets)))
            y = box.bottom + 12
    if declaration["arguments"]:
        y = paragraph(tab, "arguments, in this order, before any @", LEFT, y + 8, 400, fontface=1) + 4
        by_name = {p["name"]: p for p in declaration["parameters"]}
        for i, name in enumerate(declaration["arguments"]):
            about = by_name.get(name, {}).get("text") or f"same as the message {name}"
            tab.comment(f"{i + 1}  {name}", LEFT, y)
            y = paragraph(tab, about, 130, y, WIDTH - LEFT - 130) + 3
    return tab.fit()


def help_patcher(pd_path, declaration, names, abstractions=(), without=None):
    """The whole .maxhelp as a Patcher with tabs."""
    example, listener = example_tab(pd_path, declaration, names, abstractions, without)
    tabs = [("example", example)]
    if declaration["parameters"]:
        tabs.append(("attributes", attribute_tab(declaration, listener)))
    tabs += [("messages", message_tab(declaration, listener)), ("inlets outlets", port_tab(declaration))]
    width = max(tab.width for _, tab in tabs)
    height = min(max(tab.height for _, tab in tabs), 900)
    root = Patcher(width, height + 26, with_tabs=True)
    root.extra["digest"] = declaration["title"]
    root.extra["description"] = declaration["description"]
    for i, (name, tab) in enumerate(tabs):
        tab.width, tab.height = width, height
        tab.boxes[0].width = width - 2 * LEFT  # the title, across the window
        root.subpatcher(name, tab, 20 + 110 * i, 20)
    return root

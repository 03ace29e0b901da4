"""Writes NAME.maxref.xml: the page that Max shows as an object's reference, made only from its declaration."""
import xml.etree.ElementTree as xml

import max_objects
from help_patcher import initial_text, ports_of, range_text

AUTHOR = "the tactus authors"


def described(parent, tag, digest, description=None, **attributes):
    element = xml.SubElement(parent, tag, attributes)
    xml.SubElement(element, "digest").text = digest
    xml.SubElement(element, "description").text = description or digest
    return element


def page(declaration):
    """The element tree of one page."""
    d = declaration
    root = xml.Element("c74object", name=d["name"], module="tactus", category="tactus")
    xml.SubElement(root, "digest").text = d["title"]
    xml.SubElement(root, "description").text = d["description"]
    metadata = xml.SubElement(root, "metadatalist")
    xml.SubElement(metadata, "metadata", name="author").text = AUTHOR
    for tag in ["tactus"] + d["keywords"].replace(",", " ").split():
        xml.SubElement(metadata, "metadata", name="tag").text = tag
    _ports(root, d)
    _arguments(root, d)
    _methods(root, d)
    _attributes(root, d)
    return root


def _ports(root, d):
    for side, tag in (("inlets", "inlet"), ("outlets", "outlet")):
        listed = xml.SubElement(root, tag + "list")
        for i, port in enumerate(ports_of(d, side)):
            signal = port["kind"] == "signal"
            kind = ("signal/message" if side == "inlets" else "signal") if signal else "message"
            unit = f" ({port['unit']})" if port["unit"] else ""
            described(listed, tag, f"{port['name']}{unit}", f"{port['name']}{unit}: {port['text']}",
                      id=str(i), type=kind)


def _arguments(root, d):
    listed = xml.SubElement(root, "objarglist")
    by_name = {p["name"]: p for p in d["parameters"]}
    for name in d["arguments"]:
        parameter = by_name.get(name)
        digest = parameter["text"] if parameter else f"same as the message {name}"
        if parameter:
            kind = "symbol" if parameter["choices"] else "float"
        else:
            kind = "list" if next(m["most"] for m in d["messages"] if m["name"] == name) > 1 else "symbol"
        described(listed, "objarg", digest, name=name, optional="1", type=kind)


def _methods(root, d):
    listed = xml.SubElement(root, "methodlist")
    for m in max_objects.messages(d):
        name, arguments, fewest, most, text = (m[key] for key in ("name", "arguments", "fewest", "most", "text"))
        count = "" if most == 0 else f" Takes {fewest} to {most} arguments." if fewest != most else (
            f" Takes {fewest} argument{'s' if fewest != 1 else ''}.")
        method = xml.SubElement(listed, "method", name=name)
        given = xml.SubElement(method, "arglist")
        for i, word in enumerate(arguments.split()):
            xml.SubElement(given, "arg", name=word, optional="0" if i < fewest else "1", type="any")
        xml.SubElement(method, "digest").text = text
        xml.SubElement(method, "description").text = f"{name} {arguments}".strip() + f": {text}.{count}"


def _attributes(root, d):
    listed = xml.SubElement(root, "attributelist")
    for p in d["parameters"]:
        kind = "symbol" if p["choices"] else "float64"
        attribute = xml.SubElement(listed, "attribute", name=p["name"], get="1", set="1", type=kind, size="1")
        xml.SubElement(attribute, "digest").text = p["text"]
        xml.SubElement(attribute, "description").text = (
            f"{p['text']}: {range_text(p)}; initially {initial_text(p)}.")
        nested = xml.SubElement(attribute, "attributelist")
        for name, value in (("default", initial_text(p)), ("label", p["name"]), ("units", p["unit"])):
            if value:
                xml.SubElement(nested, "attribute", name=name, get="1", set="1", type="symbol", size="1",
                               value=value)
        if p["choices"]:
            choices = xml.SubElement(attribute, "enumlist")
            for word in p["choices"]:
                described(choices, "enum", word, name=word)


def page_text(declaration):
    root = page(declaration)
    xml.indent(root, "\t")
    return '<?xml version="1.0" encoding="utf-8" standalone="yes"?>\n' + xml.tostring(root, "unicode") + "\n"

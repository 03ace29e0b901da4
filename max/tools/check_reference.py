"""Checks the reference pages: well-formed, and complete and true against the declarations."""
import xml.etree.ElementTree as xml

from help_patcher import ports_of


def check_page(text, d):
    """Findings about one page of the declared object d."""
    try:
        root = xml.fromstring(text)
    except xml.ParseError as error:
        return [f"{d['name']}: not well-formed XML: {error}"]
    findings = []

    def expect(what, got, wanted):
        if got != wanted:
            missing, more = set(wanted) - set(got), set(got) - set(wanted)
            findings.append(f"{d['name']}: {what}: lacks {sorted(missing)}, has too much {sorted(more)}, "
                            f"or another order")

    if root.tag != "c74object" or root.get("name") != d["name"]:
        findings.append(f"{d['name']}: the root is not c74object name=\"{d['name']}\"")
    for tag, wanted in (("digest", d["title"]), ("description", d["description"])):
        if (root.findtext(tag) or "") != wanted:
            findings.append(f"{d['name']}: its {tag} is not the declaration's")
    for side, tag in (("inlets", "inlet"), ("outlets", "outlet")):
        expect(side, [e.findtext("digest") for e in root.findall(f"{tag}list/{tag}")],
               [p["name"] + (f" ({p['unit']})" if p["unit"] else "") for p in ports_of(d, side)])
    expect("arguments", [e.get("name") for e in root.findall("objarglist/objarg")], list(d["arguments"]))
    messages = [m["name"] for m in d["messages"]]
    expect("messages", [e.get("name") for e in root.findall("methodlist/method")],
           messages + [m for m in ("get", "dump") if m not in messages])
    expect("attributes", [e.get("name") for e in root.findall("attributelist/attribute")],
           [p["name"] for p in d["parameters"]])
    for p in d["parameters"]:
        _attribute(root.find(f"attributelist/attribute[@name='{p['name']}']"), p, d, findings)
    return findings


def _attribute(element, p, d, findings):
    if element is None:
        return
    text = element.findtext("description") or ""
    bounds = p["choices"] or [f"{v:.10g}" for v in p["values"] or (p["lowest"], p["highest"])]
    for word in list(bounds) + ([p["unit"]] if p["unit"] else []):
        if word not in text:
            findings.append(f"{d['name']}: attribute {p['name']} does not say {word}")
    if [e.get("name") for e in element.findall("enumlist/enum")] != list(p["choices"]):
        findings.append(f"{d['name']}: attribute {p['name']} lists other choices than the declaration")


def check_folder(folder, declarations):
    findings = []
    for d in declarations:
        path = folder / f"{d['name']}.maxref.xml"
        if not path.exists():
            findings.append(f"{d['name']}: no {path.name}")
        else:
            findings += check_page(path.read_text(encoding="utf-8"), d)
    names = {d["name"] for d in declarations}
    return findings + [f"{path.name}: no such object" for path in sorted(folder.glob("*.maxref.xml"))
                       if path.name.removesuffix(".maxref.xml") not in names]

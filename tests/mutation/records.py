"""What a run of mutate.py leaves: results (JSON), the list of equivalent changes, and the table in docs/."""
import json
import tomllib
from datetime import date
from pathlib import Path

from changes import Change
from workshop import COUNTED, ROOT

EQUIVALENT = Path(__file__).with_name("equivalent.toml")
HEAD = ["| room | seed | changes | noticed by ./test | by ./test --full | equivalent | date |", "|---|---|---|---|---|---|---|"]


def line_of(change):
    return (ROOT / change.path).read_text().split("\n")[change.line - 1]


class Equivalents:
    """Changes that no test can notice, each with its reason (equivalent.toml)."""

    def __init__(self):
        self.entries = tomllib.loads(EQUIVALENT.read_text()).get("change", []) if EQUIVALENT.exists() else []
        for entry in self.entries:
            path = ROOT / entry["path"]
            lines = [line.strip() for line in path.read_text().split("\n")] if path.exists() else []
            times = lines.count(entry["line"])
            if times == 0 or times > 1 and not entry.get("every"):
                raise SystemExit(f"{EQUIVALENT.name}: {entry['path']} has the line `{entry['line']}` {times} times; "
                                 "expected once: write the entry anew, drop it, or say `every = true`")

    def reason(self, change):
        """Why a change is equivalent, or None. `nth` (from 0) tells equal words of a line apart."""
        whole = line_of(change)
        nth = whole[:change.column].count(change.old)
        for entry in self.entries:
            if (entry["path"], entry["line"], entry["old"], entry["new"], entry.get("nth", 0)) == (
                    change.path, whole.strip(), change.old, change.new, nth):
                return entry["reason"]
        return None


def save(path, room, seed, full, tested):
    """Results of a room as JSON: [{path, line, column, old, new, kind, text, verdict}]."""
    changes = [{**vars(change), "text": line_of(change), "verdict": verdict} for change, verdict in tested]
    path.write_text(json.dumps({"room": room, "seed": seed, "full": full, "changes": changes}, indent=1))


def load(path):
    """(room, seed, full, [(change, verdict)]) of a former run.

    Each change is found again by its line's text, nearest to where it was; what is gone is left out.
    """
    former, tested = json.loads(Path(path).read_text()), []
    for kept in former["changes"]:
        text, verdict = kept.pop("text"), kept.pop("verdict")
        source = ROOT / kept["path"]
        lines = source.read_text().split("\n") if source.exists() else []
        matching = [i + 1 for i, line in enumerate(lines) if line == text]
        if not matching:
            print(f"the source has changed: {Change(**kept)} is left out")
            continue
        kept["line"] = min(matching, key=lambda line_number: abs(line_number - kept["line"]))
        tested.append((Change(**kept), verdict))
    return former["room"], former["seed"], former["full"], tested


def share(part, total):
    return f"{part} ({100 * part / max(total, 1):.0f} %)"


def row(room, seed, full, tested):
    verdicts = [v for _, v in tested]
    total, quick = sum(v in COUNTED for v in verdicts), verdicts.count("quick")
    by_all = share(quick + verdicts.count("slow"), total) if full else "not run"
    return (f"| {room} | {seed} | {total} | {share(quick, total)} | {by_all} | {verdicts.count('equivalent')} "
            f"| {date.today()} |")


def report(rooms):
    """The table and the changes that were missed; rooms: [(room, seed, full, tested)]."""
    lines = HEAD + [row(*room) for room in rooms]
    for title, verdict in (("Missed", "missed"), ("Noticed by slow cases only", "slow")):
        found = [str(c) for *_, tested in rooms for c, v in tested if v == verdict]
        if found:
            lines += ["", f"{title}:", ""] + [f"- {change}" for change in found]
    return "\n".join(lines) + "\n"


def record(path, rooms):
    """Puts rows into the table of a page, in the place of older ones of the same room and seed."""
    lines = path.read_text().split("\n")
    for room in rooms:
        begin = end = lines.index(HEAD[0]) + 2
        while end < len(lines) and lines[end].startswith("|"):
            end += 1
        key = f"| {room[0]} | {room[1]} |"
        at = next((i for i in range(begin, end) if lines[i].startswith(key)), None)
        lines[end if at is None else at:end if at is None else at + 1] = [row(*room)]
    path.write_text("\n".join(lines))

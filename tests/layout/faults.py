#!/usr/bin/python3
"""Lists the faults of patches.

    faults.py [PATCH.pd...] [--stage FOLDER] [--declarations FILE]
"""
import argparse
import pathlib

import rules
from pd_canvas import ROOT, Stage, drawings, pd_file

parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
parser.add_argument("patches", nargs="*", type=pathlib.Path)
parser.add_argument("--stage", type=pathlib.Path, default=ROOT / "build" / "tactus")
parser.add_argument("--declarations", type=pathlib.Path, default=ROOT / "build" / "declarations.json")
a = parser.parse_args()
stage = Stage(a.stage, a.declarations)
for path in a.patches or stage.patches():
    for drawing in drawings(pd_file.read(path), stage):
        for fault in rules.faults(drawing):
            print(f"{path.name}: {drawing.where}: {fault.rule}: {fault.text}")

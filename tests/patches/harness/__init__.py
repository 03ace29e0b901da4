"""Headless Pd for tests and demonstrations: draw a patch in Python, render it, look at the numbers.

tests/patches/README.md shows its use.
"""
from .patch import Canvas, Node, Patch
from .run import PdFailure, Render, read_trace, run_pd, stage_folder

__all__ = ["Canvas", "Node", "Patch", "PdFailure", "Render", "read_trace", "run_pd", "stage_folder"]

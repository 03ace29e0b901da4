"""What tests of patches import beside the harness."""
import sys

from harness.run import ROOT

sys.path[:0] = [str(ROOT / folder) for folder in ("scripts", "scripts/scenes", "max/tools", "tests/net")]

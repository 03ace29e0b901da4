#!/usr/bin/env python3
"""What OpenBLAS's kernels of 2004 cost, which a processor newer than the library is given:
    fem_blas.py [BUILD]     processor seconds of modal_fem with them and as it chooses, in turn; the ratio
"""
import os
import pathlib
import subprocess
import sys
import tempfile

BUILD = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else "build")
AIR = "--radiation body --acoustic-triangles 600"
BODIES = {"bowl with its air": f"bowl --diameter 160 --thickness 3 --angle 80 --material brass --h 12 {AIR}",
          "tube with its air": f"tube --outer-diameter 25 --inner-diameter 21 --length 400 --material steel --h 10 {AIR}",
          "plank": "board --length 1200 --width 400 --thickness 20 --fix x=-600 --fix x=600 --modes 40"}


def processor_seconds(words, **environment):
    """Of one run."""
    before = os.times()
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run([BUILD / "programs" / "modal_fem" / "modal_fem", *words.split(), "--quiet", "-o",
                        f"{folder}/x.modal.npz"], check=True, stdout=subprocess.DEVNULL,
                       env=dict(os.environ, OPENBLAS_NUM_THREADS="1", **environment))
    after = os.times()
    return after.children_user + after.children_system - before.children_user - before.children_system


print("body                 Prescott, s   chosen, s   ratio")
for name, words in BODIES.items():
    runs = [(processor_seconds(words, OPENBLAS_CORETYPE="Prescott"), processor_seconds(words)) for _ in range(3)]
    slow, fast = (min(column) for column in zip(*runs))
    print(f"{name:20s} {slow:11.1f} {fast:11.1f} {slow / fast:7.2f}")

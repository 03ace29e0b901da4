"""Boxes that stand better elsewhere in Max than in the Pd patch: {patch: {"text@x,y": (x, y)}}, in Pd's
pixels. In Pd a cord may run behind a box or upwards; here none does (check_patcher.py)."""

POSITIONS = {
    "struck_disk": {
        "tabwrite~ struck-sound@190,670": (120, 560),
        "vib acts along the surface's normal , only while the hand touches@20,560": (430, 660),
        "tabwrite~ struck-vib@22,670": (430, 606),
    },
    "reed_haptic": {
        "reed_sigma@14,248": (-12, 248), "greed~@14,362": (-12, 362), "s~ reed-sound@14,484": (6, 484),
        "*~ 0.3@14,540": (-12, 540), "dac~@14,592": (-12, 592), "r reed-volume@44,566": (24, 516),
        "slave y + D@148,298": (174, 298), "slave y - D@282,298": (308, 298),
        "slave z + D@416,298": (442, 298), "slave z - D@550,298": (576, 298),
    },
    "playability~-help": {
        "80 , 900 12000 ; playability-restart bang@14,136": (163, 136),
        "line~@14,176": (160, 250), "or by hand: pressure , lips@70,178": (14, 178),
        "<- lips: Hz , in 12 s@220,138": (196, 162), "; pd dsp 1@80,100": (14, 150),
    },
    "modal_impact~-help": {
        "listener 1 -100 200 500 , listener 2 100 200 500@460,80": (460, 112),
        "listener 1 -1500 0 300 , listener 2 100 200 500@460,108": (760, 80),
    },
    "greed~-help": {
        "r greed-note@210,232": (210, 300), "s greed-f_b@210,300": (210, 356),
        "expr if ($f1 > 0 , mtof($f1) , 0)@210,258": (210, 328),
        "Brass: a tube with a bell instead of one for each note. preset trumpet or trombone ends it."
        "@20,346": (20, 378),
    },
}


def move(canvas, positions):
    """Moves the boxes of a canvas and its subpatches; returns the keys that were found."""
    found = set()
    for box in canvas.boxes:
        key = f"{' '.join(box.plain_words())}@{box.x},{box.y}"
        if key in positions:
            found.add(key)
            box.x, box.y = positions[key]
        if box.canvas:
            found |= move(box.canvas, positions)
    return found

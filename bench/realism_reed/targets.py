"""Notes to be matched: H1..H10 in dB, centroid over f0 and attack in ms of recorded instruments."""

TARGETS = {  # (instrument, MIDI key): (attack, centroid, harmonics)
    ("clarinet", 53): (113, 6.8, [-3, -38, -4, -43, -6, -41, 0, -19, -9, -24]),
    ("clarinet", 60): (151, 5.9, [-6, -43, -10, -41, 0, -25, -2, -15, -8, -12]),
    ("tenor sax", 58): (37, 4.4, [-3, 0, -4, -9, -8, -10, -10, -19, -17, -9]),
    ("oboe", 64): (133, 3.6, [-12, -6, 0, -1, -10, -15, -33, -24, -23, -28]),
    ("trumpet", 58): (31, 5.6, [-2, -4, 0, -2, -4, 0, -4, -7, -9, -10]),
    ("trumpet", 67): (18, 3.9, [-3, 0, -1, 0, -2, -7, -9, -12, -11, -14]),
    ("trombone", 50): (111, 5.8, [-15, -17, 0, -7, -1, -7, -9, -5, -18, -7]),
}
PRESETS = {"clarinet": "clarinet", "sax": "tenor sax", "oboe": "oboe", "trumpet": "trumpet",
           "trombone": "trombone"}

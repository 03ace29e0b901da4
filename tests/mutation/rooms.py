"""Rooms of the house, their sources, and the tests that answer for each.

`unit`: programs of tests that call the room itself; `all`: a regular expression of ctest names, tests of
the objects and programs that use it.
"""


def core(name, everything, **more):
    return {"sources": [f"core/{name}"], "unit": [f"core_{name}_test"], "all": everything, **more}


def device(name):
    return {"sources": [f"devices/{name}"], "unit": [f"devices_{name}_test"], "all": f"^devices_{name}"}


ROOMS = {
    "modal": core("modal", "^(patches_(modal|true_sound|struck_disk)|core_haptic|guard)"),
    "contact": core("contact", "^(core_footstep|patches_(contact|footstep)|guard)"),
    "particle": core("particle", "^(core_footstep|patches_footstep)"),
    "footstep": core("footstep", "^patches_footstep"),
    "reed": core("reed", "^patches_(greed|playability|reed)"),
    "haptic": core("haptic", "^(patches_(phantom|mass_spring)|devices_haptic_check)"),
    "dsp": core("dsp", "^core_"),
    "falcon": device("falcon"),
    "force_dimension": device("force_dimension"),
    "haply": device("haply"),
    "hid": device("hid"),
    "evdev": device("evdev"),
    "openhaptics": device("openhaptics"),
    "fem": {"sources": ["fem"], "unit": ["fem_element_test", "fem_solids_test", "fem_error_test", "fem_msh_test",
                                         "fem_files_test", "fem_radiation_test", "fem_remesh_test", "fem_cost_test"],
            "all": "^fem_"},
}

"""Rooms of the house, their sources, and the tests that answer for each.

`unit`: programs of tests that call the room itself, or (program, double, arguments...) for one that runs
on a double of a device; `all`: a regular expression of ctest names, tests of the objects and programs
that use it.
"""


def core(name, everything, **more):
    return {"sources": [f"core/{name}"], "unit": [f"core_{name}_test"], "all": everything, **more}


def device(name, *more, everything=""):
    units = [f"devices_{name}_test", *more]
    return {"sources": [f"devices/{name}"], "unit": units, "all": f"^(devices_{name}{everything})"}


ROOMS = {
    "modal": core("modal", "^(patches_(modal|true_sound|struck_disk)|core_haptic|guard)"),
    "contact": core("contact", "^(core_footstep|patches_(contact|footstep)|guard)"),
    "particle": core("particle", "^(core_footstep|patches_(footstep|particle))"),
    "footstep": core("footstep", "^patches_footstep"),
    "reed": core("reed", "^patches_(greed|playability|reed)"),
    "haptic": core("haptic", "^(patches_(phantom|mass_spring)|devices_haptic_check)"),
    "dsp": core("dsp", "^core_", unit=["core_dsp_test", "core_dsp_avx2_test"]),
    "files": {"sources": ["files"], "unit": ["files_test"],
              "all": "^(fem_files|externals|core_footstep|patches_(modal|stress|phantom|footstep))"},
    "falcon": device("falcon", "devices_falcon_stream_test", ("devices_falcon_live_test", "falcon_double"),
                     everything="|devices_haptic_check|devices_live$"),
    "force_dimension": device("force_dimension"),
    "haply": device("haply"),
    "hid": device("hid", *(("devices_hid_live_test", "hid_double", *words) for words in (
        ["navigator"], ["compact"], ["pad"], ["--libusb", "navigator"], ["--libusb", "compact"]))),
    "evdev": {"sources": ["devices/evdev"], "all": "^(devices_evdev|devices_haptic_check)",
              "unit": ["devices_evdev_effect_test", ("devices_evdev_test", "joystick_double")]},
    "openhaptics": device("openhaptics"),
    "fem": {"sources": ["fem"], "unit": ["fem_element_test", "fem_solids_test", "fem_error_test", "fem_msh_test",
                                         "fem_files_test", "fem_radiation_test", "fem_remesh_test", "fem_cost_test"],
            "all": "^fem_"},
}

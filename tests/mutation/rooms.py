"""Folders of sources, and the tests that answer for each.

`unit`: programs of doctest cases that call the sources themselves, or (program, double, arguments...) for one that runs
on a double of a device; `tests`: a regular expression of ctest names, for what the programs miss; `modules`: the sources
are compiled into modules or programs, which these load or run.
"""


def core(*names, tests, **more):
    return {"sources": [f"core/{name}" for name in names], "unit": [f"core_{names[0]}_test"], "tests": tests, **more}


ROOMS = {
    "modal": core("modal", "geometry", tests="^(patches_(modal|true_sound|board|rub)|core_haptic|guard)"),
    "contact": core("contact", tests="^(core_footstep|core_modal|patches_(contact|footstep)|guard)"),
    "particle": core("particle", tests="^(core_footstep|patches_(footstep|particle))"),
    "footstep": core("footstep", tests="^patches_footstep"),
    "reed": core("reed", tests="^(externals_greed|patches_(greed|playability|reed))"),
    "haptic": core("haptic", tests="^(patches_(phantom|mass_spring)|devices_haptic_check)"),
    "small": {"sources": ["core/dsp", "core/stress", "core/design", "core/serve", "core/command.cpp", "core/refusal.cpp",
                          "core/declaration_text.cpp", "core/named_lines.hpp", "core/sentence.hpp"],
              "unit": ["core_dsp_test", "core_dsp_avx2_test", "core_stress_test", "files_test", "externals_test",
                       "max_shell_test"],
              "tests": "^(core_|pd_shell_none_f64|patches_(stress|struck|design))"},
    "files": {"sources": ["files"], "unit": ["files_test"],
              "tests": "^(fem_files|externals|core_footstep|fuzz_files|patches_(modal|stress|phantom|footstep))"},
    "devices": {"sources": ["devices"], "tests": "^devices_",
                "unit": ["devices_falcon_test", "devices_falcon_stream_test", "devices_force_dimension_test",
                         "devices_haply_test", "devices_hid_test", "devices_openhaptics_test",
                         "devices_evdev_effect_test", ("devices_evdev_test", "joystick_double"),
                         ("devices_falcon_live_test", "falcon_double"),
                         ("devices_hid_live_test", "hid_double", "navigator"),
                         ("devices_hid_live_test", "hid_double", "pad")]},
    "net": {"sources": ["net"], "unit": ["net_test", "net_sockets_test"], "tests": "^(net_|fuzz_net|patches_phantom_network)"},
    "fem": {"sources": ["fem"], "tests": "^fem_",
            "unit": ["fem_element_test", "fem_solids_test", "fem_error_test", "fem_msh_test", "fem_files_test",
                     "fem_radiation_test", "fem_remesh_test", "fem_cost_test", "fem_statics_test", "fem_design_test"]},
    "pd": {"modules": True, "sources": ["pd"], "unit": ["pd_host_none_f32", "pd_host_newer_f32", "pd_host_none_f64"],
           "tests": "^(patches_|guard)"},
    "max": {"modules": True, "sources": ["max/shell", "max/stub"], "unit": ["max_shell_test"], "tests": "^max_"},
    "externals": {"modules": True, "sources": ["externals"], "unit": ["externals_test", "externals_greed_test", "pd_host_none_f32"],
                  "tests": "^(patches_|guard|max_every_object|net_|devices_live)"},
    "programs": {"modules": True, "sources": ["programs"], "unit": ["devices_haptic_check_test"],
                 "tests": "^(fem_|devices_haptic_check|docs_|net_haptic_server|patches_(reed_study|play|library))"},
}

#!/usr/bin/env python3
"""Writes files that break the contract, one rule each, and beside each the message expected (`NAME.txt`, without
the file's name in front). Needs numpy and h5py.

    python3 make_bad.py            # in this folder
"""

import h5py
import numpy as np

SAMPLES, SENSORS = 16, 2
CASES = {}


def case(expected):
    def register(function):
        CASES[function.__name__] = (function, expected)
        return function

    return register


def dataset(group, name, values, units):
    if name in group:
        del group[name]
    d = group.create_dataset(name, data=values)
    if units is not None:
        d.attrs["units"] = units


def measurement(f):
    f.attrs.update(format="frettrace-measurement", format_version=1, title="bad", source="measured")
    f.create_group("beam").attrs.update(length=0.5, width=0.03, thickness=0.006, youngs_modulus=2e11, density=7800.0)
    f.create_group("support").attrs.update(
        position=0.5, slip="rotation", lever_arm=0.003, normal_stiffness=1e6, law="dahl"
    )
    f.create_group("exciter").attrs["position"] = 0.2
    dataset(f.create_group("sensors"), "position", [0.25, 0.375], "m")
    modes = f["beam"].create_group("modes")
    dataset(modes, "frequency", [50.0, 160.0], "Hz")
    dataset(modes, "damping_ratio", [0.005, 0.006], "1")
    run = f.create_group("runs").create_group("0001")
    run.attrs.update(sampling_rate=4096.0, excitation_frequency=50.0, preload=75.0, label="level 1")
    dataset(run, "acceleration", np.ones((SAMPLES, SENSORS)), "m/s^2")
    dataset(run, "force", np.ones(SAMPLES), "N")


def contact(f):
    f.attrs.update(format="frettrace-contact", format_version=1, title="bad", source="measured")
    f.create_group("contact").attrs.update(law="dahl", slip_unit="m")
    run = f.create_group("runs").create_group("0001")
    run.attrs.update(sampling_rate=200.0, label="run 1")
    dataset(run, "force", np.ones(SAMPLES), "N")
    dataset(run, "slip_displacement", np.ones(SAMPLES), "m")


FORMATS = "one of frettrace-measurement, frettrace-contact"
INSIDE = "it must be above 0 and at most the beam's length, 0.5 m"
LAWS = "coulomb, stribeck, dahl, lugre, hybrid"


@case(f"/: the attribute `format` is missing; add it: {FORMATS}")
def format_missing(f):
    del f.attrs["format"]


@case('/: `format` is "a notebook"; write one of frettrace-measurement, frettrace-contact')
def format_unknown(f):
    f.attrs["format"] = "a notebook"


@case("/: the attribute `format` is a number; write a text")
def format_number(f):
    f.attrs["format"] = 1


@case("/: `format_version` is 2; this program reads version 1: convert the file")
def version_newer(f):
    f.attrs["format_version"] = 2


@case("/: the attribute `source` is missing; add it: one of measured, simulated")
def source_missing(f):
    del f.attrs["source"]


@case("/beam: the group is missing; add it as the file format says")
def beam_missing(f):
    del f["beam"]


@case("/beam: the attribute `length` is missing; add it")
def length_missing(f):
    del f["beam"].attrs["length"]


@case("/beam: `thickness` is -0.006; it must be a number above 0")
def thickness_negative(f):
    f["beam"].attrs["thickness"] = -0.006


@case("/beam: `density` is NaN; it must be a number above 0")
def density_nan(f):
    f["beam"].attrs["density"] = np.nan


@case('/beam: the attribute `width` is the text "30 mm"; write a number')
def width_text(f):
    f["beam"].attrs["width"] = "30 mm"


@case("/beam: the attribute `youngs_modulus` is a list of 2 numbers; write one number")
def modulus_list(f):
    f["beam"].attrs["youngs_modulus"] = [2e11, 2.1e11]


@case("/beam/modes/damping_ratio: the shape is [3]; it must be (2)")
def modes_unequal(f):
    dataset(f["beam/modes"], "damping_ratio", [0.005, 0.006, 0.007], "1")


@case("/beam/modes/damping_ratio: the dataset is missing; add it, in 1")
def modes_without_damping(f):
    del f["beam/modes/damping_ratio"]


@case("/beam/modes/damping_ratio: entry 1 is 1.5; it must be from 0 to below 1")
def modes_damping_percent(f):
    dataset(f["beam/modes"], "damping_ratio", [0.5, 1.5], "1")


@case("/beam/modes/frequency: entry 1 is 40; it must be above the entry before it")
def modes_falling(f):
    dataset(f["beam/modes"], "frequency", [50.0, 40.0], "Hz")


@case('/beam/modes/frequency: the units are "rad/s"; convert the values and write units = "Hz"')
def modes_angular(f):
    dataset(f["beam/modes"], "frequency", [314.0, 1000.0], "rad/s")


@case("/beam/modes/frequency_std: the shape is [1]; it must be (2)")
def modes_std_length(f):
    dataset(f["beam/modes"], "frequency_std", [0.1], "Hz")


@case("/support: the group is missing; add it as the file format says")
def support_missing(f):
    del f["support"]


@case(f"/support: `position` is 0.7; {INSIDE}")
def support_beyond(f):
    f["support"].attrs["position"] = 0.7


@case('/support: `slip` is "sideways"; write one of rotation, transverse')
def slip_unknown(f):
    f["support"].attrs["slip"] = "sideways"


@case("/support: the attribute `lever_arm` is missing; add it")
def lever_missing(f):
    del f["support"].attrs["lever_arm"]


@case("/support: `normal_stiffness` is 0; it must be above 0, or infinite for a pinned end")
def stiffness_zero(f):
    f["support"].attrs["normal_stiffness"] = 0


@case(f'/support: `law` is "velvet"; write one of {LAWS}')
def law_unknown(f):
    f["support"].attrs["law"] = "velvet"


@case(f"/second_support: `position` is -0.1; {INSIDE}")
def second_support_outside(f):
    f.create_group("second_support").attrs["position"] = -0.1


@case(f"/exciter: `position` is 0; {INSIDE}")
def exciter_at_clamp(f):
    f["exciter"].attrs["position"] = 0.0


@case("/sensors/position: the dataset is missing; add it, in m")
def sensors_missing(f):
    del f["sensors/position"]


@case(f"/sensors/position: entry 1 is 375; {INSIDE}")
def sensors_millimetres(f):
    dataset(f["sensors"], "position", [0.25, 375.0], "m")


@case('/sensors/position: the units are "mm"; convert the values and write units = "m"')
def sensors_units(f):
    dataset(f["sensors"], "position", [250.0, 375.0], "mm")


@case("/sensors/position: entries 0 and 1 are both 0.25; give every sensor its own position")
def sensors_twice(f):
    dataset(f["sensors"], "position", [0.25, 0.25], "m")


@case("/sensors/noise_std: the shape is [3]; it must be (2)")
def noise_length(f):
    dataset(f["sensors"], "noise_std", [0.1, 0.1, 0.1], "m/s^2")


@case("/sensors/noise_std: entry 0 is 0; it must be above 0")
def noise_zero(f):
    dataset(f["sensors"], "noise_std", [0.0, 0.1], "m/s^2")


@case("/sensors/name: the shape is [1]; it must be (2), one name a sensor")
def names_length(f):
    f["sensors"].create_dataset("name", data=["one"], dtype=h5py.string_dtype())


@case("/runs: the group is missing; add it as the file format says")
def runs_missing(f):
    del f["runs"]


@case("/runs: the shape is [0]; it must be at least one group, `0001`")
def runs_empty(f):
    del f["runs/0001"]


@case("/runs/0001: `sampling_rate` is 0; it must be a number above 0")
def rate_zero(f):
    f["runs/0001"].attrs["sampling_rate"] = 0


@case("/runs/0001: `excitation_frequency` is 3000; it must be below half the sampling rate, 2048 Hz")
def excitation_beyond_half(f):
    f["runs/0001"].attrs["excitation_frequency"] = 3000


@case("/runs/0001: `preload` is -5; it must be 0 or above")
def preload_negative(f):
    f["runs/0001"].attrs["preload"] = -5.0


@case("/runs/0001/force: the dataset is missing; add it, in N")
def force_missing(f):
    del f["runs/0001/force"]


@case("/runs/0001/force: the shape is [15]; it must be (16)")
def force_short(f):
    dataset(f["runs/0001"], "force", np.ones(SAMPLES - 1), "N")


@case("/runs/0001/force: sample 3 of column 0 is inf; cut the run before it or repair the channel")
def force_infinite(f):
    values = np.ones(SAMPLES)
    values[3] = np.inf
    dataset(f["runs/0001"], "force", values, "N")


@case('/runs/0001/force: the units are "lbf"; convert the values and write units = "N"')
def force_pounds(f):
    dataset(f["runs/0001"], "force", np.ones(SAMPLES), "lbf")


@case("/runs/0001/acceleration: the dataset is missing; add it, in m/s^2")
def acceleration_missing(f):
    del f["runs/0001/acceleration"]


@case("/runs/0001/acceleration: the shape is [2, 16]; it must be (n, 2), a row a sample and a column a sensor, n at least 8")
def acceleration_turned(f):
    dataset(f["runs/0001"], "acceleration", np.ones((SENSORS, SAMPLES)), "m/s^2")


@case("/runs/0001/acceleration: sample 5 of column 1 is NaN; cut the run before it or repair the channel")
def acceleration_nan(f):
    values = np.ones((SAMPLES, SENSORS), "f4")
    values[5, 1] = np.nan
    dataset(f["runs/0001"], "acceleration", values, "m/s^2")


@case('/runs/0001/acceleration: the attribute `units` is missing; write units = "m/s^2"')
def acceleration_without_units(f):
    dataset(f["runs/0001"], "acceleration", np.ones((SAMPLES, SENSORS)), None)


@case('/runs/0001/acceleration: the units are "g"; convert the values and write units = "m/s^2"')
def acceleration_in_g(f):
    dataset(f["runs/0001"], "acceleration", np.ones((SAMPLES, SENSORS)), "g")


@case("/runs/0001/acceleration: acceleration is a group; write a dataset")
def acceleration_group(f):
    del f["runs/0001/acceleration"]
    f["runs/0001"].create_group("acceleration")


@case("/contact: the group is missing; add it as the file format says")
def contact_missing(f):
    del f["contact"]


@case('/contact: `slip_unit` is "mm"; write one of m, rad')
def contact_slip_unit(f):
    f["contact"].attrs["slip_unit"] = "mm"


@case("/contact: `moving_mass` is -1; it must be 0 or above, or NaN where it is wanted")
def contact_mass_negative(f):
    f["contact"].attrs["moving_mass"] = -1.0


@case("/runs/0001: the attribute `sampling_rate` is missing; add it: in Hz, or give a dataset `time` in s")
def contact_without_time(f):
    del f["runs/0001"].attrs["sampling_rate"]


@case("/runs/0001/time: entry 2 is 1; it must be above the entry before it")
def contact_time_stands(f):
    time = np.arange(SAMPLES, dtype=float)
    time[2] = 1.0
    dataset(f["runs/0001"], "time", time, "s")


@case("/runs/0001/slip_displacement: the shape is [17]; it must be (16)")
def contact_slip_longer(f):
    dataset(f["runs/0001"], "slip_displacement", np.ones(SAMPLES + 1), "m")


@case('/runs/0001/slip_velocity: the units are "mm/s"; convert the values and write units = "m/s"')
def contact_velocity_units(f):
    dataset(f["runs/0001"], "slip_velocity", np.ones(SAMPLES), "mm/s")


if __name__ == "__main__":
    for name, (spoil, expected) in CASES.items():
        with h5py.File(f"{name}.h5", "w", libver="v110") as f:
            (contact if name.startswith("contact_") else measurement)(f)
            spoil(f)
        with open(f"{name}.txt", "w") as f:
            f.write(expected + "\n")

#!/usr/bin/env python3
"""Opens files this project wrote with h5py, the reference, and checks what the formats promise.

    python3 check_with_h5py.py FILE...

Takes measurement files, contact records and reconstructions. Exit code 0: all well; 1: a promise is broken (one
line says which); 3: h5py is not installed, nothing was checked.
"""

import sys

try:
    import h5py
    import numpy as np
except ImportError as error:
    print(f"not checked: {error}")
    sys.exit(3)

STANDARD_DEVIATIONS = ["friction_force", "normal_force", "slip_displacement", "slip_velocity", "acceleration_fit"]


def check(condition, place, message):
    if not condition:
        raise AssertionError(f"{place}: {message}")


def units(name, item):
    if isinstance(item, h5py.Dataset) and item.dtype.kind in "iufc":
        check("units" in item.attrs, item.name, "no units")
        check(isinstance(item.attrs["units"], str), item.name, "units are not a text")
        item[()]


def measurement(f):
    count = f["sensors/position"].shape[0]
    check(float(f["beam"].attrs["length"]) > 0, "/beam", "no length")
    for name, run in f["runs"].items():
        check(run["acceleration"].shape == (run["force"].shape[0], count), run.name, "shapes differ")
        check(np.isfinite(run["acceleration"][()]).all(), run.name, "not finite")
        for key in ("sampling_rate", "excitation_frequency", "preload"):
            check(np.isscalar(run.attrs[key]), run.name, f"{key} is not a scalar")
    for name, run in f.get("truth/runs", {}).items():
        check(run["friction_force"].shape == f["runs"][name]["force"].shape, run.name, "shapes differ")


def contact(f):
    check(f["contact"].attrs["slip_unit"] in ("m", "rad"), "/contact", "slip_unit")
    for run in f["runs"].values():
        check(run["force"].shape == run["slip_displacement"].shape, run.name, "shapes differ")
        check("sampling_rate" in run.attrs or "time" in run, run.name, "neither sampling_rate nor time")


def reconstruction(f):
    for run in f["runs"].values():
        check(run.attrs["form"] in ("harmonic", "subharmonic", "aperiodic"), run.name, "form")
        for key in ("fundamental_frequency", "subharmonic_order", "harmonics", "acceleration_error", "noise_floor"):
            check(np.isscalar(run.attrs[key]), run.name, f"{key} is not a scalar")
        check(isinstance(run.attrs["unobservable"], str), run.name, "unobservable")
        samples = run["time"].shape[0]
        for name in STANDARD_DEVIATIONS:
            for dataset in (run[name], run[name + "_std"]):
                check(dataset.shape[0] == samples, dataset.name, "not one row a sample")
                check(dataset.dims[0][0] == run["time"], dataset.name, "time is not its scale")
        check(run["acceleration_fit"].dims[1][0] == run["sensor_position"], run.name, "sensors have no scale")
        for name, dataset in run["harmonics"].items():
            if name != "frequency" and not name.endswith("_std"):
                check(dataset.dtype == np.complex128, dataset.name, "not complex")
                check(dataset.dims[0][0] == run["harmonics/frequency"], dataset.name, "frequency is not its scale")


CHECKS = {
    "frettrace-measurement": measurement,
    "frettrace-contact": contact,
    "frettrace-reconstruction": reconstruction,
}

if __name__ == "__main__":
    for path in sys.argv[1:]:
        try:
            with h5py.File(path, "r") as f:
                f.visititems(units)
                CHECKS[f.attrs["format"]](f)
        except Exception as error:
            print(f"{path}: {error!r}")
            sys.exit(1)
        print(f"{path}: well")

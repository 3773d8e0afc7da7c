#!/usr/bin/env python3
"""Writes the corpus of HDF5 files that the reader is judged by. Needs numpy and h5py.

`good_*` are one and the same measurement in every way h5py can store it; `bad_*` are damaged. What is expected
of each is in `tests/corpus.rs`; the numbers are exact in half precision, so that every number type holds them.

    python3 make_corpus.py            # in this folder
"""

import h5py
import numpy as np

SAMPLES, SENSORS = 40, 3


def acceleration(run):
    k, s = np.meshgrid(np.arange(SAMPLES), np.arange(SENSORS), indexing="ij")
    return ((7 * k + 3 * s + run) % 64 - 32) / 4.0


def force(run):
    return ((5 * np.arange(SAMPLES) + run) % 32 - 16) / 2.0


def plain(text):
    return text


def write(path, runs=2, text=plain, number=float, array=None, kind="f8", order=False, **options):
    array = array or {}
    with h5py.File(path, "w", track_order=order, **options) as f:
        f.attrs["format"] = text("frettrace-measurement")
        f.attrs["format_version"] = 1
        f.attrs["title"] = text("corpus")
        f.attrs["source"] = text("measured")
        beam = f.create_group("beam", track_order=order)
        values = dict(length=0.75, width=0.03125, thickness=0.0078125, youngs_modulus=2.0e11, density=7800.0)
        for name, value in values.items():
            beam.attrs[name] = float(value) if name == "youngs_modulus" else number(value)
        support = f.create_group("support")
        support.attrs["position"] = 0.75
        support.attrs["slip"] = text("rotation")
        support.attrs["lever_arm"] = number(0.00390625)
        support.attrs["normal_stiffness"] = np.inf
        support.attrs["law"] = text("dahl")
        f.create_group("exciter").attrs["position"] = number(0.25)
        sensors = f.create_group("sensors")
        sensors.create_dataset("position", data=np.array([0.25, 0.5, 0.625])).attrs["units"] = text("m")
        sensors.create_dataset("noise_std", data=np.array([0.0625] * SENSORS, "f4")).attrs["units"] = text("m/s^2")
        group = f.create_group("runs", track_order=order)
        for run in range(1, runs + 1):
            g = group.create_group(f"{run:04d}", track_order=order)
            g.attrs["sampling_rate"] = 4096
            g.attrs["excitation_frequency"] = number(50.0)
            g.attrs["preload"] = number(75.0)
            g.attrs["label"] = text(f"level {run}")
            g.attrs["lubricated"] = np.bool_(run % 2)
            d = g.create_dataset("acceleration", data=acceleration(run).astype(kind), **array)
            d.attrs["units"] = text("m/s^2")
            small = {k: v for k, v in array.items() if k not in ("chunks", "maxshape")}
            d = g.create_dataset("force", data=force(run).astype(kind), **small)
            d.attrs["units"] = text("N")


def good():
    write("good_default.h5")
    write("good_latest.h5", libver="latest")
    for version in ("v108", "v110", "v114"):
        write(f"good_{version}.h5", libver=(version, version))
    write("good_gzip.h5", array=dict(compression="gzip", chunks=(16, 2)), kind="f4")
    write("good_gzip_shuffle_fletcher32.h5", array=dict(compression="gzip", shuffle=True, fletcher32=True, chunks=(10, 3)))
    write("good_latest_gzip.h5", libver="latest", array=dict(compression="gzip", shuffle=True, chunks=(16, 2)), kind="f4")
    write("good_fletcher32.h5", array=dict(fletcher32=True))
    write("good_lzf.h5", array=dict(compression="lzf", chunks=(16, 2)), kind="f4")
    write("good_lzf_shuffle_fletcher32.h5", array=dict(compression="lzf", shuffle=True, fletcher32=True), kind="f8")
    write("good_scaleoffset.h5", array=dict(scaleoffset=2, chunks=(16, 3)), kind="f4")
    write("good_resizable.h5", array=dict(maxshape=(None, SENSORS), chunks=(8, 3)))
    write("good_latest_resizable_both.h5", libver="latest", array=dict(maxshape=(None, None), chunks=(8, 2)))
    write("good_fixed_strings.h5", text=np.bytes_)
    write("good_string_arrays.h5", text=lambda text: np.array([text], dtype=h5py.string_dtype()))
    write("good_number_types.h5", number=np.float32, kind=">f4")
    write("good_half.h5", kind="f2")
    write("good_long_double_attributes.h5", number=lambda value: np.array([value], ">f8"))
    write("good_user_block.h5", userblock_size=512)
    write("good_user_block_latest.h5", userblock_size=2048, libver="latest")
    write("good_track_order.h5", order=True)
    write("good_track_order_latest.h5", order=True, libver="latest")
    write("good_many_runs.h5", runs=12, kind="f2", array=dict(compression="gzip"))
    write("good_many_runs_latest.h5", runs=12, kind="f2", array=dict(compression="gzip"), libver="latest")
    write("good_many_attributes_latest.h5", libver="latest")
    with h5py.File("good_many_attributes_latest.h5", "a", libver="latest") as f:
        for place in ("/", "beam", "support", "runs/0001"):
            for i in range(30):
                f[place].attrs[f"remark_{i:02d}"] = f"remark number {i}"
    write("good_linked.h5")
    with h5py.File("good_linked.h5", "a") as f:
        f.move("runs/0002", "second")
        f["runs/0002"] = h5py.SoftLink("/second")
        f["runs/0001/loop"] = f["runs"]
    matlab("good_matlab_user_block.h5")


def matlab(path):
    """The container of MATLAB v7.3: 512 bytes of its own before the HDF5 part."""
    write(path, userblock_size=512)
    head = b"MATLAB 7.3 MAT-file, Platform: GLNXA64, Created on: Mon Jan  6 10:00:00 2025 HDF5 schema 1.00 ."
    with open(path, "r+b") as f:
        f.write(head.ljust(116, b" ") + bytes(8) + b"\x00\x02IM")


def bad():
    whole = open("good_gzip_shuffle_fletcher32.h5", "rb").read()
    latest = open("good_latest_gzip.h5", "rb").read()
    for share in (10, 50, 90, 99):
        open(f"bad_truncated_{share}.h5", "wb").write(whole[: len(whole) * share // 100])
        open(f"bad_latest_truncated_{share}.h5", "wb").write(latest[: len(latest) * share // 100])
    open("bad_empty.h5", "wb").write(b"")
    open("bad_text.h5", "w").write("time,force\n0,1\n")
    open("bad_signature_only.h5", "wb").write(whole[:8])
    with h5py.File("good_gzip_shuffle_fletcher32.h5") as f:
        chunk = f["runs/0001/acceleration"].id.get_chunk_info(0)
    flipped = bytearray(whole)
    flipped[chunk.byte_offset + chunk.size // 2] ^= 0xFF
    open("bad_chunk_flipped.h5", "wb").write(flipped)
    zeroed = bytearray(whole)
    zeroed[chunk.byte_offset : chunk.byte_offset + chunk.size] = bytes(chunk.size)
    open("bad_chunk_zeroed.h5", "wb").write(zeroed)
    with h5py.File("good_latest_gzip.h5") as f:
        address = h5py.h5o.get_info(f["runs/0001"].id).addr
    header = bytearray(latest)
    header[address + 20] ^= 0xFF
    open("bad_latest_header_flipped.h5", "wb").write(header)
    tree = bytearray(whole)
    for at in range(len(tree) - 4):
        if tree[at : at + 4] == b"SNOD":
            tree[at : at + 4] = b"DONS"
    open("bad_trees.h5", "wb").write(tree)


if __name__ == "__main__":
    good()
    bad()

#!/usr/bin/env python3
"""Writes the samples of laboratory formats: `good_*` hold the two channels below, `bad_*` are spoilt, with the message
expected in `NAME.message` (without the file's name in front). Needs numpy, scipy, h5py and pyuff, so that the writers of
UFF and MATLAB files are not our own.

    python3 make_samples.py            # in this folder
"""

import json
import os

import h5py
import numpy as np
import pyuff
import scipy.io

SAMPLES, RATE = 20, 200.0
TIME = np.arange(SAMPLES) / RATE
FORCE = ((np.arange(SAMPLES) * 7) % 16 - 8) / 4.0
SLIP = ((np.arange(SAMPLES) * 5) % 32 - 16) / 8.0
COLUMNS = np.stack([TIME, FORCE, SLIP], axis=1)


def text(name, content):
    with open(name, "w", newline="", encoding="latin-1") as f:
        f.write(content)


def rows(separator, comma=False, end="\n"):
    lines = [separator.join(f"{value:.6g}" for value in row) for row in COLUMNS]
    lines = [line.replace(".", ",") for line in lines] if comma else lines
    return end.join(lines) + end


def delimited():
    text("good_comma.csv", "Time [s],Force [N],Slip [mm]\n" + rows(","))
    text("good_windows.csv", '"Time (s)","Force (N)","Slip (mm)"\r\n' + rows(",", end="\r\n"))
    text("good_no_heading.tsv", rows("\t"))
    text("good_units_below.txt", "C:\\data\\run.txt\nSampling Frequency - 200\nTime\tForce\tSlip\ns\tN\tmm\n\n" + rows("\t"))
    text("good_decimal_comma.csv", "Zeit [s];Kraft [N];Weg [mm]\n" + rows(";", comma=True))
    text("good_blanks.dat", "# a rig\n   Time   Force   Slip\n" + "".join("   " + "    ".join(f"{v: .6E}" for v in r) + "\n" for r in COLUMNS))
    text("good_latin1.csv", "Time [s],Force [N],Slip [\xb5m]\n" + rows(","))
    text("bad_ragged.csv", "t,f,u\n0,1,2\n0.1,1\n0.2,1,2\n")
    message("bad_ragged.csv", "line 3: the row has 2 fields where the others have 3; complete or remove it")
    text("bad_word.csv", "t,f,u\n0,1,2\n0.1,overflow,2\n0.2,1,2\n")
    message("bad_word.csv", "line 3: `overflow` is not a number; mend or remove the row")
    text("bad_gap.tsv", "Time [s]\tForce [N]\n0\t1\n0.005\t\n0.01\t2\n")
    message("bad_gap.tsv", "line 3: the row has 1 fields where the others have 2; complete or remove it")
    text("bad_prose.txt", "This is a letter.\nThere are no data in it.\n")
    message("bad_prose.txt", "whole file: there are no numbers in it; export the channels as columns of numbers")
    open("bad_binary.bin", "wb").write(bytes(range(256)))
    message("bad_binary.bin", "start of the file: the format is not known; export CSV, UFF 58, MATLAB, LVM or JSON")


def message(name, expected):
    with open(name + ".message", "w") as f:
        f.write(expected + "\n")


LVM_HEAD = "LabVIEW Measurement\t\nWriter_Version\t2\nReader_Version\t2\nSeparator\tTab\nDecimal_Separator\t{}\nMulti_Headings\tNo\nX_Columns\tOne\n***End_of_Header***\t\n\t\n"
LVM_CHANNELS = "Channels\t2\t\nSamples\t20\t20\t\nY_Unit_Label\tN\tmm\t\nX_Dimension\tTime\tTime\t\nDelta_X\t{}\t{}\t\n***End_of_Header***\t\t\n"


def lvm():
    body = "X_Value\tForce\tSlip\tComment\n" + rows("\t").replace("\n", "\t\n")
    text("good_labview.lvm", LVM_HEAD.format(".") + LVM_CHANNELS.format("0.005", "0.005") + body)
    body = "X_Value\tForce\tSlip\tComment\n" + rows("\t", comma=True)
    text("good_labview_comma.lvm", LVM_HEAD.format(",") + LVM_CHANNELS.format("0,005", "0,005") + body)
    whole = open("good_labview.lvm").read()
    text("bad_word.lvm", whole.replace("\t-1.25\t", "\toff\t", 1))
    message("bad_word.lvm", "line 22: `off` is not a number; mend or remove the row")
    text("bad_labview.lvm", "LabVIEW Measurement\t\nWriter_Version\t2\n0\t1\t2\n")
    message("bad_labview.lvm", "header: the file breaks the rules of its format (there is no end of the header); export it again")


def arrays():
    with open("good_named.json", "w") as f:
        json.dump({"time": TIME.tolist(), "rig": {"force": FORCE.tolist(), "slip": SLIP.tolist()}, "note": "a rig"}, f)
    with open("good_rows.json", "w") as f:
        json.dump({"data": COLUMNS.tolist(), "dt": 1 / RATE}, f)
    text("bad_cut.json", '{"data": [[0, 1, 2], [1, 2, ')
    message("bad_cut.json", "line 1, column 28: the file breaks the rules of its format (not JSON from here on); export it again")
    text("bad_null.json", '{"data": [[0, 1], [1, null]]}')
    message("bad_null.json", "data[1]: `null` is not a number; mend or remove the row")


def matlab():
    signals = dict(t=TIME[:, None], data=np.stack([FORCE, SLIP], axis=1), rate=RATE, title="a rig")
    scipy.io.savemat("good_v5.mat", signals)
    scipy.io.savemat("good_v5_structure.mat", dict(rig=dict(signals, inner=dict(gain=np.arange(3, dtype="i2")))))
    scipy.io.savemat("good_v7_compressed.mat", signals, do_compression=True)
    with h5py.File("good_v73.mat", "w", userblock_size=512) as f:
        for name, value in (("t", TIME[None, :]), ("data", np.stack([FORCE, SLIP]))):
            f.create_dataset(name, data=value, compression="gzip").attrs["MATLAB_class"] = np.bytes_("double")
        f.create_dataset("title", data=np.frombuffer("a rig".encode("utf-16-le"), "u2")[:, None]).attrs["MATLAB_class"] = np.bytes_("char")
    with open("good_v73.mat", "r+b") as f:
        f.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64, HDF5 schema 1.00 .".ljust(116, b" ") + bytes(8) + b"\x00\x02IM")
    whole = open("good_v5.mat", "rb").read()
    open("bad_v5_cut.mat", "wb").write(whole[:300])
    message("bad_v5_cut.mat", "whole file: the file breaks the rules of its format (an array is cut short or damaged); export it again")
    whole = open("good_v7_compressed.mat", "rb").read()
    open("bad_v7_cut.mat", "wb").write(whole[:-40])
    message("bad_v7_cut.mat", "whole file: the file breaks the rules of its format (an array is cut short or damaged); export it again")
    whole = open("good_v73.mat", "rb").read()
    open("bad_v73_cut.mat", "wb").write(whole[: len(whole) * 3 // 4])
    message("bad_v73_cut.mat", "/: cannot be read (invalid data: address 0x22f8 lies beyond the end of the file); copy the file again or write it anew with h5py")


def uff_set(values, name, **other):
    fields = dict(
        type=58, func_type=1, rsp_node=3, rsp_dir=3, ref_node=1, ref_dir=3, data=values, x=TIME, id1=name, id2="NONE",
        rsp_ent_name="NONE", ref_ent_name="NONE", abscissa_spacing=1, abscissa_spec_data_type=17,
        abscissa_axis_units_lab="s", ordinate_axis_units_lab="N", ordinate_spec_data_type=13,
    )
    for axis in ("orddenom", "z_axis"):
        fields.update({f"{axis}_spec_data_type": 0, f"{axis}_axis_units_lab": "NONE"})
    for axis in ("abscissa", "ordinate", "orddenom", "z_axis"):
        fields.update({f"{axis}_{kind}_unit_exp": 0 for kind in ("len", "force", "temp")})
    fields.update(ver_num=0, load_case_id=0, z_axis_value=0)
    fields.update(other)
    return fields


def uff():
    force = dict(ordinate_axis_units_lab="N", rsp_node=1)
    slip = dict(ordinate_axis_units_lab="mm", ordinate_spec_data_type=8, rsp_node=2)
    sets = (("text", 0, 4, True), ("text_single", 0, 2, False), ("binary", 1, 4, True))
    for name, binary, kind, double in sets:
        path = f"good_{name}.uff"
        if os.path.exists(path):
            os.remove(path)
        both = (uff_set(FORCE, "Force", **force), uff_set(SLIP, "Slip", **slip))
        pyuff.UFF(path).write_sets([dict(one, binary=binary, ord_data_type=kind) for one in both], "add", force_double=double)
    uneven = uff_set(FORCE, "Force", abscissa_spacing=0, binary=0, ord_data_type=4, **force)
    if os.path.exists("good_uneven.uff"):
        os.remove("good_uneven.uff")
    pyuff.UFF("good_uneven.uff").write_sets([uneven, dict(uff_set(SLIP, "Slip", abscissa_spacing=0, **slip), binary=0, ord_data_type=4)], "add")
    big_endian_single()
    whole = open("good_text.uff").read()
    text("bad_cut.uff", whole[:1150])
    message("bad_cut.uff", "dataset 58 number 1: the file ends after 12 of 20 values; export or copy it again")
    binary = open("good_binary.uff", "rb").read()
    open("bad_binary_cut.uff", "wb").write(binary[:1050])
    message("bad_binary_cut.uff", "dataset 58 number 1: the file ends after 16 of 20 values; export or copy it again")
    text("bad_word.uff", whole.replace("2.5", "two", 1))
    message("bad_word.uff", "dataset 58 number 1: the file breaks the rules of its format (a value is not a number); export it again")


def big_endian_single():
    """Single precision with the high byte first, which pyuff cannot write: its text header, our bytes."""
    blocks = open("good_text_single.uff").read().split("    -1\n    58")[1:]
    with open("good_binary_single_big_endian.uff", "wb") as f:
        for block, values in zip(blocks, (FORCE, SLIP)):
            lines = block.split("\n")
            f.write(b"    -1\n    58b     2     2          11%12i     0     0           0           0\n" % (4 * SAMPLES))
            f.write(("\n".join(lines[1:12]) + "\n").encode())
            f.write(values.astype(">f4").tobytes() + b"\n    -1\n")


if __name__ == "__main__":
    delimited()
    lvm()
    arrays()
    matlab()
    uff()

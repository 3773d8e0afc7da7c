#!/usr/bin/env python3
"""Runs every notebook of this folder from its first cell to its last; any error ends with exit code 1.

    python3 execute.py PROGRAM [--write]

PROGRAM is the built `frettrace`; notebooks find it as FRETTRACE in the environment. With --write the outputs are stored
in the notebooks. Needs nbclient, nbformat, ipykernel, numpy, h5py, xarray, h5netcdf, matplotlib.
"""

import os
import pathlib
import sys
import tempfile
import time

import nbformat
from nbclient import NotebookClient

HERE = pathlib.Path(__file__).resolve().parent


def main():
    program, write = pathlib.Path(sys.argv[1]).resolve(), "--write" in sys.argv
    os.environ["FRETTRACE"] = str(program)
    os.environ["FRETTRACE_REPOSITORY"] = str(HERE.parent.parent)
    notebooks = sorted(HERE.glob("*.ipynb"))
    for path in notebooks:
        started = time.time()
        notebook = nbformat.read(path, as_version=4)
        with tempfile.TemporaryDirectory() as folder:
            client = NotebookClient(notebook, timeout=180, kernel_name="python3", resources={"metadata": {"path": folder}})
            client.execute()
        ran = sum(cell.cell_type == "code" for cell in notebook.cells)
        print(f"{path.name}: {ran} cells in {time.time() - started:.1f} s")
        if write:
            for cell in notebook.cells:
                cell.metadata.pop("execution", None)
            notebook.metadata.pop("language_info", None)
            nbformat.write(notebook, path)
    if not notebooks:
        sys.exit("no notebook found")


main()

#!/usr/bin/env python3
"""HDF5 files packed by the filters of hdf5plugin, read here and compared with the arrays that went in.

    pip install numpy h5py hdf5plugin netCDF4 xarray scipy
    python tests/reference/hdf5_filters.py [PROGRAM]   # PROGRAM is the built describe_volumes

Filters that are refused on purpose must give an error of one line.
"""

import itertools
import sys

import h5py
import hdf5plugin
import numpy as np

import arrays


def filters(folder):
    cases = arrays.Cases(folder)
    read = [hdf5plugin.LZ4(), hdf5plugin.LZ4(nbytes=64)]
    names = ("lz4", "lz4hc", "blosclz", "zlib", "zstd")
    read += [hdf5plugin.Blosc(cname=name, shuffle=shuffle) for name in names for shuffle in range(3)]
    unread = [hdf5plugin.Zstd(), hdf5plugin.Blosc2(), hdf5plugin.Bitshuffle()]
    for packing, code in itertools.product(read + unread, ("u1", "<i2", ">f4", "<f8")):
        values, path = np.cumsum(arrays.numbers((30, 20, 25), code) % 7, axis=2).astype(code), cases.path(".h5")
        with h5py.File(path, "w") as file:
            file.create_dataset("data", data=values, chunks=(8, 20, 9), **packing)
        cases.add(path, None if packing in unread else values, label=f"{packing} {code}")
    return cases.cases


if __name__ == "__main__":
    kind = ("HDF5, filters of hdf5plugin", "h5py, hdf5plugin")
    arrays.compare(sys.argv[1:] or arrays.PROGRAM, made=filters, kind_of=lambda _: kind)

#!/usr/bin/env python3
"""Small volumes in every type, encoding and byte order that outside libraries write, and back.

    python tests/reference/volume_variants.py [FOLDER]

Writes the variants with pynrrd, SimpleITK, nibabel, VTK and tifffile to FOLDER (a temporary one by default),
runs `crates/fovol-io/tests/reference_files.rs` over them, which also writes each again in every format of this
program, and reads those with the outside libraries.
"""

import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import nibabel
import nrrd
import numpy as np
import SimpleITK
import tifffile
import vtk
from vtkmodules.util.numpy_support import numpy_to_vtk

import volume_info
from summary import Summary

# VTK complains about annotations that its own writer made.
vtk.vtkObject.GlobalWarningDisplayOff()

TYPES = ["uint8", "int8", "uint16", "int16", "uint32", "int32", "uint64", "int64", "float32", "float64"]
KINDS = {"pynrrd": "NRRD", "SimpleITK": "MetaImage", "nibabel": "NIfTI", "tifffile": "TIFF"}
RANDOM = np.random.default_rng(1)


def voxels(dtype, shape):
    if dtype.startswith("float"):
        return RANDOM.normal(size=shape).astype(dtype)
    limits = np.iinfo(dtype)
    # Doubles hold every integer up to 2^53.
    low, high = max(limits.min, -(2**40)), min(limits.max, 2**40)
    return RANDOM.integers(low, high, size=shape, dtype=dtype, endpoint=True)


def nrrd_variants(folder):
    for dtype in TYPES:
        for encoding in ("raw", "gzip", "bzip2", "ascii"):
            for endian in ("little", "big"):
                header = {"encoding": encoding, "endian": endian, "spacings": [1.5, 2, 0.25]}
                stem = f"{dtype}_{encoding}_{endian}"
                nrrd.write(str(folder / f"{stem}.nrrd"), voxels(dtype, (5, 4, 3)), header, index_order="F")
                if encoding == "ascii":
                    continue
                del header["spacings"]
                header |= {"space": "LPS", "space directions": RANDOM.normal(size=(3, 3)), "space origin": [1, 2, 3]}
                path = str(folder / f"{stem}_detached.nhdr")
                nrrd.write(path, voxels(dtype, (5, 4, 3)), header, detached_header=True, index_order="F")
    none = [np.nan] * 3
    axes = [[2, 0, 0], [0, 3, 0], [0, 0, 4]]
    for first, last, shape in (("vector", "domain", (3, 5, 4, 2)), ("domain", "list", (5, 4, 3, 2))):
        directions = [none, *axes] if first == "vector" else [*axes, none]
        header = {"kinds": [first, "domain", "domain", last], "space": "LPS", "space directions": np.array(directions)}
        nrrd.write(str(folder / f"{first}_{last}.nrrd"), voxels("int16", shape), header, index_order="F")


def metaimage_variants(folder):
    for dtype in TYPES:
        for components in (1, 3):
            for is_compressed in (False, True):
                for ending in ("mha", "mhd"):
                    shape = (3, 4, 5, components) if components > 1 else (3, 4, 5)
                    image = SimpleITK.GetImageFromArray(voxels(dtype, shape), isVector=components > 1)
                    image.SetSpacing((0.5, 2.25, 3))
                    path = folder / f"meta_{dtype}_{components}_{'packed' if is_compressed else 'bare'}.{ending}"
                    SimpleITK.WriteImage(image, str(path), is_compressed)


def nifti_variants(folder):
    for kind, name in ((nibabel.Nifti1Image, "nifti1"), (nibabel.Nifti2Image, "nifti2")):
        for dtype in TYPES:
            for endian in "<>":
                header = kind.header_class(endianness=endian)
                header.set_data_dtype(np.dtype(dtype).newbyteorder(endian))
                image = kind(voxels(dtype, (5, 4, 3)), np.diag([0.5, 2.25, 3, 1]), header, dtype=dtype)
                image.header.set_slope_inter(1 if dtype == "int64" else 0.25, 0 if dtype == "int64" else -2)
                ending = "nii.gz" if endian == ">" else "nii"
                nibabel.save(image, folder / f"{name}_{dtype}_{'big' if endian == '>' else 'little'}.{ending}")


def vti_variants(folder):
    for dtype in TYPES:
        for components in (1, 3):
            image = vtk.vtkImageData()
            image.SetDimensions(5, 4, 3)
            image.SetSpacing(0.5, 2.25, 3)
            array = numpy_to_vtk(voxels(dtype, (60, components)), deep=True)
            array.SetName("values")
            image.GetPointData().SetScalars(array)
            legacy = vtk.vtkStructuredPointsWriter()
            for is_binary in (False, True):
                legacy.SetFileType(vtk.VTK_BINARY if is_binary else vtk.VTK_ASCII)
                legacy.SetFileName(str(folder / f"vtk_{dtype}_{components}_{'binary' if is_binary else 'ascii'}.vtk"))
                legacy.SetInputData(image)
                legacy.Write()
            for mode in ("Ascii", "Binary", "Appended"):
                for compressor in ("None", "ZLib", "LZ4"):
                    for bits in (32, 64):
                        writer = vtk.vtkXMLImageDataWriter()
                        getattr(writer, f"SetDataModeTo{mode}")()
                        getattr(writer, f"SetCompressorTypeTo{compressor}")()
                        getattr(writer, f"SetHeaderTypeToUInt{bits}")()
                        writer.SetEncodeAppendedData(bits == 64)
                        if bits == 64:
                            writer.SetByteOrderToBigEndian()
                        name = f"vti_{dtype}_{components}_{mode}_{compressor}_{bits}.vti".lower()
                        writer.SetFileName(str(folder / name))
                        writer.SetInputData(image)
                        writer.Write()


def tiff_variants(folder):
    for dtype in TYPES:
        for compression in (None, "zlib", "lzw", "packbits"):
            for endian in "<>":
                path = folder / f"tiff_{dtype}_{compression}_{'big' if endian == '>' else 'little'}.tif"
                tifffile.imwrite(path, voxels(dtype, (3, 4, 5)), compression=compression, byteorder=endian,
                                 photometric="minisblack", metadata=None)  # fmt: skip


def references(folder, files):
    found = {}
    for path in files:
        found[path.relative_to(folder).as_posix()] = volume_info.info(path)
    (folder / "volume_info.json").write_text(json.dumps(found))
    return found


def main(folder):
    variants, written = folder / "variants", folder / "written"
    variants.mkdir(parents=True, exist_ok=True)
    written.mkdir(exist_ok=True)
    for make in (nrrd_variants, metaimage_variants, nifti_variants, vti_variants, tiff_variants):
        make(variants)
    endings = {".nrrd", ".nhdr", ".mha", ".mhd", ".nii", ".gz", ".vti", ".vtk", ".tif"}
    files = sorted(p for p in variants.iterdir() if p.suffix in endings and not p.name.endswith(".raw.gz"))
    found = references(variants, files)
    environment = {
        **os.environ,
        "FOVOL_TEST_DATA": str(variants),
        "FOVOL_TEST_REFERENCES": str(variants / "volume_info.json"),
        "FOVOL_TEST_WRITTEN": str(written),
    }
    command = ["cargo", "test", "-q", "--release", "--workspace", "--test", "reference_files", "--", "--nocapture"]
    run = subprocess.run(command, cwd=volume_info.REPOSITORY, env=environment, stdout=subprocess.PIPE,
                         stderr=subprocess.DEVNULL, text=True)  # fmt: skip
    wrong = [line for line in run.stdout.splitlines() if line.startswith("outcome") and not line.endswith("agrees")]
    summary = Summary()
    differing = {line.split()[1].rstrip(":") for line in wrong}
    for name, entry in found.items():
        kind = KINDS.get(entry["library"], name.split("_")[0].upper())
        summary.add(f"{kind}, every type and encoding", entry["library"], "differ" if name in differing else "agree")
    print(*wrong, f"{len(found)} variants, {len(wrong)} of them read otherwise here", sep="\n")
    lost = []
    for path in sorted(written.iterdir()):
        if is_voxels(path):
            continue
        entry, source = volume_info.info(path), found[path.name.split("~")[0]]
        if line := changed(path, entry, source):
            lost.append(line)
        ending = path.name.split("~")[1].split(".", 1)[1]
        summary.add(f"written by this program, `.{ending}`", entry["library"], "differ" if line else "agree")
    summary.print()
    print(*lost, f"{len(list(written.iterdir()))} files written, {len(lost)} of them read otherwise there", sep="\n")
    sys.exit(bool(wrong or lost or run.returncode))


def is_voxels(path):
    """Whether `path` has the voxels of another file."""
    return path.suffix in (".raw", ".json") or path.name.endswith(".raw.gz")


def changed(path, written, source):
    """How the file `path`, which is read as `written`, differs from its source; none when it does not."""
    # Scaled values may be written as floats.
    keys = ["dims", "min", "max"] + ([] if source["dtype"] != written["dtype"] and "nifti" in path.name else ["dtype"])
    differences = [f"{key} {written[key]}, not {source[key]}" for key in keys if written[key] != source[key]]
    if not np.allclose(written["spacing"], source["spacing"] or [1, 1, 1], rtol=1e-6):
        differences.append(f"spacing {written['spacing']}, not {source['spacing']}")
    return f"{path.name}: {'; '.join(differences)}" if differences else None


if __name__ == "__main__":
    if len(sys.argv) > 1:
        main(Path(sys.argv[1]).resolve())
    else:
        with tempfile.TemporaryDirectory() as temporary:
            main(Path(temporary))

#!/usr/bin/env python3
"""What outside libraries say about the volume files in the test data, and the table of the comparison.

    pip install nibabel pynrrd vtk tifffile numpy SimpleITK imagecodecs h5py netCDF4 zarr
    python tests/reference/volume_info.py references DATA    # writes tests/reference/volume_info.json
    python tests/reference/volume_info.py table DATA         # runs all comparisons, writes docs/formats.md

DATA is the folder that holds `formats` and `volumes`. `crates/fovol-io/tests/reference_files.rs` compares
the reader with each entry: size, type, components, spacing, and minimum, maximum and mean of the first
component of the first volume after the scaling that the file declares. Files that no library can read, and
kinds that are not read on purpose, have an `error` instead.

`table` also runs the scripts in `COMPARISONS`, which write files of every kind into a temporary folder. The head of each
says what it needs.
"""

import gzip
import json
import os
import re
import subprocess
import sys
import tempfile
import xml.etree.ElementTree as ElementTree
import zlib
from pathlib import Path

import numpy as np

import summary

REPOSITORY = Path(__file__).resolve().parents[2]
REFERENCE = REPOSITORY / "tests/reference"
JSON = REFERENCE / "volume_info.json"
TABLE = REPOSITORY / "docs/formats.md"

SHORT = {
    "uint8": "u8", "int8": "i8", "uint16": "u16", "int16": "i16", "uint32": "u32", "int32": "i32",
    "uint64": "u64", "int64": "i64", "float16": "f16", "float32": "f32", "float64": "f64",
}  # fmt: skip

# Kinds that are not read, by the end of the name.
FOREIGN = {
    ".mnc": "MINC is not read",
    ".mgz": "MGH is not read",
    ".slc": "SLC is not read",
    ".brik": "AFNI is not read",
    ".brik.gz": "AFNI is not read",
    ".head": "AFNI is not read",
    ".mif": "MRtrix is not read",
    ".vol": "Mitsuba volumes are not read",
    ".bov": "BOV is not read",
    ".ppm": "a picture",
}


class NotRead(Exception):
    """The file is sound, but of a kind that is not read on purpose."""


def padded(values, fill):
    return [*values, fill, fill, fill][:3]


def entry(library, dims, voxels, components=1, spacing=None, slope=1.0, intercept=0.0):
    """The entry of a file whose raw first components are `voxels`."""
    name = np.dtype(voxels.dtype).newbyteorder("=").name
    if name not in SHORT:
        raise NotRead(f"{name} voxels")
    values = voxels.astype(np.float64).ravel()
    if (slope, intercept) != (1.0, 0.0):
        values = values * slope + intercept
    finite = values[np.isfinite(values)]
    return {
        "library": library,
        "dims": [int(d) for d in dims],
        "dtype": SHORT[name],
        "components": int(components),
        "spacing": [float(s) for s in spacing] if spacing is not None else None,
        "min": float(finite.min()),
        "max": float(finite.max()),
        "mean": float(finite.mean()),
    }


def bare(path, dims, dtype, components=1, spacing=(1.0, 1.0, 1.0)):
    open_file = gzip.open if path.suffix == ".gz" else open
    with open_file(path, "rb") as file:
        data = file.read()
    count = int(np.prod(dims)) * components
    voxels = np.frombuffer(data, dtype=dtype, count=count).reshape(-1, components)[:, 0]
    return entry("NumPy", dims, voxels, components, spacing)


def raw_by_name(path):
    match = re.search(r"_(\d+)x(\d+)x(\d+)_(u?int\d+|float\d+)\.raw", path.name)
    if not match:
        raise NotRead("nothing says its size")
    return bare(path, [int(d) for d in match.groups()[:3]], np.dtype(match[4]).newbyteorder("<"))


def dat(path):
    lines = dict(line.split(":", 1) for line in path.read_text().splitlines() if ":" in line)
    dims = [int(d) for d in lines["Resolution"].split()]
    dtype = np.dtype(lines["Format"].strip().lower()).newbyteorder("<")
    return bare(path.parent / lines["RawFile"].strip(), dims, dtype)


def ivf(path):
    root = ElementTree.parse(path).getroot()
    size = root.find("Dimension")
    dims = [int(size.get(axis)) for axis in "xyz"]
    dtype = np.dtype(root.find("Format").get("content").lower()).newbyteorder("<")
    return bare(path.parent / root.find("RawFile").get("content"), dims, dtype)


def vvd(path):
    # Voreen lets comments stand before the XML declaration, ElementTree does not.
    text = re.sub(r"\A\s*<!--.*?-->\s*", "", path.read_text(), flags=re.S)
    volume = ElementTree.fromstring(text).find("Volumes/Volume")
    data = volume.find("RawData")
    file = data.get("filename") or data.find("Paths/paths/item").get("value")
    spacing = volume.find("MetaData/MetaItem[@name='Spacing']/value")
    dims = [int(data.get(axis)) for axis in "xyz"]
    return bare(path.parent / file, dims, data.get("format"), 1, [float(spacing.get(a)) for a in "xyz"])


def nifti_pair(path):
    """Header and image beside each other, each compressed or not: nibabel itself wants both alike."""
    from nibabel.fileholders import FileHolder

    stem = re.sub(r"\.(hdr|img)(\.gz)?$", "", str(path))
    pair = {}
    for part, ending in (("header", ".hdr"), ("image", ".img")):
        found = [name for name in (stem + ending, stem + ending + ".gz") if os.path.exists(name)]
        if not found:
            raise FileNotFoundError(f"no {Path(stem + ending).name} beside it")
        pair[part] = FileHolder(filename=found[0])
    return pair


def nifti(path):
    import nibabel

    if re.search(r"\.(hdr|img)(\.gz)?$", path.name):
        pair = nifti_pair(path)
        header = nibabel.openers.Opener(pair["header"].filename).read(348)
        is_nifti = header[344:347] in (b"ni1", b"n+1")
        kind = nibabel.Nifti1Pair if is_nifti else nibabel.Spm2AnalyzeImage
        image = kind.from_file_map(pair)
    else:
        image = nibabel.load(path)
    if isinstance(image, nibabel.cifti2.Cifti2Image):
        # Seen as the NIfTI-2 file that it is, a matrix has one voxel and many volumes.
        image = nibabel.Nifti2Image.from_filename(path)
    shape = image.shape
    data = np.asanyarray(image.dataobj.get_unscaled())
    first = data[(slice(None),) * min(3, len(shape)) + (0,) * (len(shape) - 3)]
    components = 1
    if first.dtype.fields:
        components = len(first.dtype.fields)
        first = first[first.dtype.names[0]]
    spacing = padded([abs(float(z)) or 1.0 for z in image.header.get_zooms()[:3]], 1.0)
    slope, intercept = image.dataobj.slope, image.dataobj.inter
    return entry("nibabel", padded(shape, 1), first, components, spacing, slope, intercept)


def nrrd(path):
    import nrrd as pynrrd

    data, header = pynrrd.read(str(path), index_order="F")
    kinds = header.get("kinds") or []
    directions = header.get("space directions")
    spacings = [float(s) for s in header.get("spacings", [])] or [np.nan] * data.ndim
    if directions is not None:
        spacings = [float(np.linalg.norm(d)) for d in np.atleast_2d(directions)]
    components = 1
    if len(kinds) > 1 and kinds[0] not in ("domain", "space", "time"):
        components, spacings = data.shape[0], spacings[1:]
        data = data[0]
    first = data[(slice(None),) * min(3, data.ndim) + (0,) * (data.ndim - 3)]
    spacing = padded([1.0 if np.isnan(s) else s for s in spacings], 1.0)
    return entry("pynrrd", padded(data.shape, 1), first, components, spacing)


def metaimage(path):
    import SimpleITK

    header = dict(re.findall(rb"^(\w+) *= *(.*?)\s*$", path.read_bytes()[:4096], flags=re.M))
    file, size = path.parent / os.fsdecode(header.get(b"ElementDataFile", b"")), header.get(b"CompressedDataSize")
    if size and file.is_file() and int(size) != file.stat().st_size:
        # MetaIO trusts the wrong size, and what it does not decompress is whatever was in memory.
        voxels = np.frombuffer(zlib.decompress(file.read_bytes()), np.uint8)
        spacing = [float(s) for s in header[b"ElementSpacing"].split()]
        return entry("zlib", [int(d) for d in header[b"DimSize"].split()], voxels, 1, spacing)
    image = SimpleITK.ReadImage(str(path), imageIO="MetaImageIO")
    components = image.GetNumberOfComponentsPerPixel()
    voxels = SimpleITK.GetArrayFromImage(image)
    voxels = voxels[..., 0] if components > 1 else voxels
    return entry(
        "SimpleITK", padded(image.GetSize(), 1), voxels, components, padded(image.GetSpacing(), 1.0)
    )


def vtk_image(path, reader):
    from vtkmodules.util.numpy_support import vtk_to_numpy

    reader.SetFileName(str(path))
    reader.Update()
    image = reader.GetOutput()
    if image is None or image.GetNumberOfPoints() == 0:
        raise ValueError("VTK finds no image data in it")
    points, cells = image.GetPointData(), image.GetCellData()
    dims = list(image.GetDimensions())
    array = points.GetScalars() or points.GetArray(0)
    if array is None:
        array = cells.GetScalars() or cells.GetArray(0)
        dims = [max(1, d - 1) for d in dims]
    if array is None:
        raise ValueError("VTK finds no numbers in it")
    voxels = vtk_to_numpy(array)
    components = array.GetNumberOfComponents()
    voxels = voxels[:, 0] if components > 1 else voxels
    return entry("VTK", dims, voxels, components, image.GetSpacing())


def vti(path):
    import vtk

    return vtk_image(path, vtk.vtkXMLImageDataReader())


def legacy_vtk(path):
    import vtk

    reader = vtk.vtkStructuredPointsReader()
    reader.SetFileName(str(path))
    if reader.IsFileRectilinearGrid():
        return rectilinear(path)
    if not reader.IsFileStructuredPoints():
        raise NotRead("no structured points")
    return vtk_image(path, reader)


def rectilinear(path):
    """A grid whose distances do not differ."""
    import vtk
    from vtkmodules.util.numpy_support import vtk_to_numpy

    reader = vtk.vtkRectilinearGridReader()
    reader.SetFileName(str(path))
    reader.Update()
    grid = reader.GetOutput()
    axes = [vtk_to_numpy(axis) for axis in (grid.GetXCoordinates(), grid.GetYCoordinates(), grid.GetZCoordinates())]
    steps = [np.diff(axis) for axis in axes]
    if any(len(step) > 1 and np.ptp(step) > 1e-6 * abs(step).max() for step in steps):
        raise NotRead("resampled")
    array, dims = grid.GetPointData().GetArray(0), list(grid.GetDimensions())
    if array is None:
        array, dims = grid.GetCellData().GetArray(0), [max(1, size - 1) for size in dims]
    return entry("VTK", dims, vtk_to_numpy(array), 1, [float(step[0]) if len(step) else 1.0 for step in steps])


def tiff(path):
    import tifffile

    with tifffile.TiffFile(path) as file:
        series = file.series[0]
        data, axes = series.asarray(), series.axes
        # Samples of no stated meaning beside the colours are no components.
        beside = sum(int(sample) == 0 for sample in file.pages[0].extrasamples)
    components = 1
    if "S" in axes:
        channel = axes.index("S")
        components = data.shape[channel] - beside
        data = np.take(data, 0, axis=channel)
    height, width = data.shape[-2:]
    return entry("tifffile", [width, height, data.size // (width * height)], data, components)


def dicom(path):
    import pydicom

    found = pydicom.dcmread(path)
    if "TransferSyntaxUID" not in found.file_meta:
        found.file_meta.TransferSyntaxUID = pydicom.uid.ImplicitVRLittleEndian
    syntax = found.file_meta.TransferSyntaxUID.name
    if "JPEG-LS" in syntax or "JPEG Extended" in syntax:
        raise NotRead(syntax)
    pixels, components = found.pixel_array, int(found.SamplesPerPixel)
    if "Segmentation" in found.SOPClassUID.name:
        group = found.PerFrameFunctionalGroupsSequence[0]
        pixels = pixels * np.uint8(group.SegmentIdentificationSequence[0].ReferencedSegmentNumber)
        measures = found.SharedFunctionalGroupsSequence[0].PixelMeasuresSequence[0]
        rows, columns = map(float, measures.PixelSpacing)
        between = float(measures.get("SpacingBetweenSlices") or measures.SliceThickness)
        return entry("pydicom", [*pixels.shape[::-1], 1, 1][:3], pixels, 1, [columns, rows, between])
    first = pixels[..., 0] if components > 1 else pixels
    slope = float(found.get("RescaleSlope") or found.get("DoseGridScaling") or 1)
    intercept = float(found.get("RescaleIntercept") or 0)
    if components == 1 and slope == 1 and intercept:
        first, intercept = (first + intercept).astype(np.int16), 0.0
    rows, columns = map(float, found.get("PixelSpacing") or [1, 1])
    between = float(found.get("SpacingBetweenSlices") or found.get("SliceThickness") or 1)
    offsets = found.get("GridFrameOffsetVector")
    between = float(offsets[1]) - float(offsets[0]) if offsets else between
    dims = [*first.shape[::-1], 1, 1][:3]
    return entry("pydicom", dims, first, components, [columns, rows, between], slope, intercept)


def hdf5(path):
    import h5py

    with h5py.File(path) as file:
        datasets = []
        file.visititems(lambda _, found: datasets.append(found) if isinstance(found, h5py.Dataset) else None)
        volume = next(dataset for dataset in datasets if dataset.ndim == 3)
        return entry("h5py", volume.shape[::-1], volume[...], 1, volume.attrs["element_size_um"][::-1])


def netcdf(path):
    import netCDF4

    with netCDF4.Dataset(path) as file:
        bounds = {getattr(variable, "bounds", None) for variable in file.variables.values()}
        found = [v for name, v in file.variables.items() if v.ndim > 1 and name not in bounds]
        if not found:
            raise NotRead("no volume")
        variable = max(found, key=lambda variable: (variable.ndim, variable.size))
        voxels = np.ma.filled(variable[...], np.nan)
        axes = variable.dimensions
        if axes[0] == "time":
            voxels, axes = voxels[0], axes[1:]
        steps = [abs(float(np.diff(file.variables[name][:]).mean())) for name in axes[::-1]]
        # An axis of one voxel takes the spacing of x.
        return entry("netCDF4", padded(voxels.shape[::-1], 1), voxels, 1, padded(steps, steps[0]))


def zarr(path):
    """The finest level of a volume of OME-Zarr 0.4 that has no axes but those of space."""
    import zarr

    group = zarr.open_group(path, mode="r")
    scales = group.attrs["multiscales"][0]
    level = scales["datasets"][0]
    axes = [axis["name"] for axis in scales["axes"]]
    order = [axes.index(axis) for axis in "xyz"]
    voxels = group[level["path"]][...].transpose(order[::-1])
    scale = level["coordinateTransformations"][0]["scale"]
    return entry("zarr", voxels.shape[::-1], voxels, 1, [scale[axis] for axis in order])


BY_ENDING = {
    ".dcm": dicom,
    ".dat": dat, ".ivf": ivf, ".vvd": vvd, ".nrrd": nrrd, ".nhdr": nrrd, ".mha": metaimage, ".mhd": metaimage,
    ".vti": vti, ".vtk": legacy_vtk, ".tif": tiff, ".tiff": tiff, ".nii": nifti, ".hdr": nifti, ".img": nifti,
    ".h5": hdf5, ".nc": netcdf,
}  # fmt: skip


def info(path):
    name = path.name.lower()
    for ending, reason in FOREIGN.items():
        if name.endswith(ending):
            raise NotRead(reason)
    with path.open("rb") as file:
        if file.read(132)[128:] == b"DICM":
            return dicom(path)
    name = name.removesuffix(".gz")
    suffix = Path(name).suffix
    if suffix in (".raw", ".zraw"):
        beside = [path.with_suffix(e) for e in (".nhdr", ".mhd", ".nrrd", ".mha", ".dat", ".vvd")]
        header = next((header for header in beside if header.is_file()), None)
        return info(header) if header else raw_by_name(path)
    if suffix not in BY_ENDING:
        raise NotRead("no volume file")
    return BY_ENDING[suffix](path)


def references(data):
    entries = {}
    files = [*(data / "formats").rglob("*"), *(data / "volumes").glob("*.raw.gz")]
    for path in sorted(path for path in files if path.is_file()):
        relative = path.relative_to(data).as_posix()
        if relative.startswith("formats/zarr/"):
            continue
        try:
            entries[relative] = info(path)
        except NotRead as reason:
            entries[relative] = {"error": f"not read: {reason}"}
        except Exception as problem:  # noqa: BLE001: libraries raise anything at broken files
            text = " ".join(str(problem).split()).replace(f"{data}/", "")
            entries[relative] = {"error": f"{type(problem).__name__}: {text}"[:160]}
        print(relative, entries[relative].get("error", "ok"), flush=True)
    entries["formats/zarr/mni152_axial.ome.zarr"] = zarr(data / "formats/zarr/mni152_axial.ome.zarr")
    lines = (f"{json.dumps(name)}: {json.dumps(found)}" for name, found in sorted(entries.items()))
    JSON.write_text("{\n" + ",\n".join(lines) + "\n}\n")


# Scripts that compare files of their own, and what they are given; `PROGRAM` is the built describe_volumes.
COMPARISONS = [
    ["dicom.py", "compare", "PROGRAM", "DATA", "FOLDER/dicom"],
    ["zarr_files.py", "compare", "PROGRAM"],
    ["arrays.py", "compare", "PROGRAM"],
    ["hdf5_filters.py", "PROGRAM"],
    ["vdb_files.py", "make", "FOLDER/vdb"],
    ["vdb_files.py", "compare", "FOLDER/vdb", "PROGRAM"],
    ["vtk_files.py", "compare", "PROGRAM"],
    *(["random_variations.py", "--program", "PROGRAM", "--folder", f"FOLDER/{seed}", "--seed", str(seed)] for seed in range(1, 5)),
    ["volume_variants.py", "FOLDER/variants"],
]


def comparisons(data):
    """The counts by kind of all scripts: kind and library to files that agree, are refused, and differ."""
    subprocess.run(["cargo", "build", "--release", "--workspace", "--example", "describe_volumes"], cwd=REPOSITORY, check=True)
    target = Path(os.environ.get("CARGO_TARGET_DIR", REPOSITORY / "target"))
    program, counts = target / "release/examples/describe_volumes", {}
    with tempfile.TemporaryDirectory() as folder:
        given = {"PROGRAM": str(program), "DATA": str(data), "FOLDER": folder}
        for script, *arguments in COMPARISONS:
            arguments = [re.sub("PROGRAM|DATA|FOLDER", lambda name: given[name[0]], argument) for argument in arguments]
            print(script, *arguments, flush=True)
            run = subprocess.run([sys.executable, REFERENCE / script, *arguments], stdout=subprocess.PIPE, text=True)
            rows = summary.found(run.stdout)
            if not rows and arguments[0] != "make":
                raise SystemExit(f"{script} compared nothing; are the libraries there that its head names?")
            for kind, library, *found in rows:
                before = counts.get((kind, library), (0, 0, 0))
                counts[kind, library] = tuple(map(sum, zip(before, found, strict=True)))
    return counts


def table_of_kinds(counts):
    agree, refused, differ = map(sum, zip(*counts.values(), strict=True))
    text = (
        f"{agree + refused + differ:,} files, or choices of an array, channel, time point or level in them: {agree:,} agree, "
        f"{refused:,} are refused or\nread with a note on what differs, {differ:,} differ.\n\n"
        "| kind | library | agree | refused or noted | differ |\n|---|---|--:|--:|--:|\n"
    )
    rows = sorted(counts.items(), key=lambda row: (row[0][0].startswith("written"), row[0][0].lower(), row[0][1]))
    return text + "".join(f"| {kind} | {library} | {' | '.join(map(str, found))} |\n" for (kind, library), found in rows)


def table(data):
    environment = {**os.environ, "FOVOL_TEST_DATA": str(data)}
    if not (Path(data) / "formats").is_dir():
        raise SystemExit(f"{data}: it has no folder formats; give the folder above it")
    command = ["cargo", "test", "--release", "--workspace", "--test", "reference_files", "--", "--nocapture"]
    run = subprocess.run(command, cwd=REPOSITORY, env=environment, stdout=subprocess.PIPE, text=True)
    outcomes = dict(re.findall(r"^outcome (\S+): (.*)$", run.stdout, flags=re.M))
    entries = json.loads(JSON.read_text())
    rows = []
    for name, found in entries.items():
        outcome = outcomes.get(name, "not run").replace(f"{data}/", "").replace("|", "\\|")
        outcome = outcome.replace(f"refused: {name}: ", "refused: ")
        if "error" in found:
            rows.append((name, "", "", "", outcome))
        else:
            size = "×".join(map(str, found["dims"]))
            kind = found["dtype"] + (f" ×{found['components']}" if found["components"] > 1 else "")
            rows.append((name, found["library"], size, kind, outcome))
    agree = sum(outcome.startswith("agrees") for *_, outcome in rows)
    refused = sum(outcome.startswith("refused") for *_, outcome in rows)
    text = (
        "# Volume files compared with outside libraries\n\n"
        "Made by `tests/reference/volume_info.py table`; do not edit.\n\n"
        "## Files that libraries write for the comparison\n\n"
        "Scripts in `tests/reference` have outside libraries write small files in every type, encoding, byte order and\n"
        "layout, and random ones. This program reads each, and size, spacing, place, unit, counts and every voxel are compared\n"
        "with what went in or with what the library reads. *Refused* files are broken on purpose or of a kind that is not read.\n"
        "Each must give an error of one line. JPEG-LS in DICOM is refused without the cargo feature `jpeg-ls`. Rows at the end\n"
        "are files that this program wrote, as the library reads them.\n\n"
        f"{table_of_kinds(comparisons(data))}\n"
        "## Files of the test data\n\n"
        "Each file of the test data is read by this program and by an outside library. *Agrees* means the same\n"
        "size, type, components and spacing (to 1e-6), the same minimum and maximum, and the same mean (to 1e-6)\n"
        "of the first component after the scaling that the file declares. *Refused* files are broken or of a kind\n"
        "that is not read; the one-line message is shown.\n\n"
        f"{len(rows)} files: {agree} agree, {refused} are refused"
        f"{'' if agree + refused == len(rows) else f', {len(rows) - agree - refused} differ'}.\n\n"
        "| file | library | size | type | outcome |\n|---|---|---|---|---|\n"
    )
    text += "".join(f"| {' | '.join(row)} |\n" for row in rows)
    TABLE.parent.mkdir(exist_ok=True)
    TABLE.write_text(text)
    sys.exit(run.returncode)


if __name__ == "__main__":
    if len(sys.argv) != 3 or sys.argv[1] not in ("references", "table"):
        sys.exit(__doc__)
    {"references": references, "table": table}[sys.argv[1]](Path(sys.argv[2]).resolve())

"""NIfTI-1 and NIfTI-2, one file or two: written by nibabel or byte by byte, read by nibabel."""

import bz2
import gzip
import struct

import nibabel
import numpy as np

from .case import TYPES, UNITS, Case, Unreadable, chance, directions, pick, sizes, spacing, voxels

CODES = {"uint8": 2, "int16": 4, "int32": 8, "float32": 16, "float64": 64, "int8": 256, "uint16": 512, "uint32": 768,
         "int64": 1024, "uint64": 1280, "rgb": 128, "rgba": 2304}  # fmt: skip
# It says which header fields it mends.
nibabel.imageglobals.logger.setLevel("CRITICAL")
LAYOUTS = ["nii", "nii", "nii.gz", "nii.bz2", "pair", "pair.gz"]


def make(rng, stem):
    path = by_nibabel(rng, stem) if chance(rng, 0.4) else by_hand(rng, stem)
    return seen(rng, path)


def by_nibabel(rng, stem):
    kind = pick(rng, [nibabel.Nifti1Image, nibabel.Nifti2Image])
    endian, dtype = pick(rng, "<>"), pick(rng, TYPES)
    shape = sizes(rng, pick(rng, [3, 3, 4]))
    header = kind.header_class(endianness=endian)
    header.set_data_dtype(np.dtype(dtype).newbyteorder(endian))
    affine = np.eye(4)
    affine[:3, :3] = directions(rng) * spacing(rng)
    affine[:3, 3] = rng.normal(size=3) * 100
    image = kind(voxels(rng, dtype, shape), affine, header, dtype=dtype)
    image.set_sform(affine, int(pick(rng, [0, 1, 2, 4])))
    image.set_qform(affine, int(pick(rng, [0, 1, 3])))
    image.header.set_xyzt_units(pick(rng, ["mm", "micron", "meter", "unknown"]), pick(rng, ["sec", "msec", "unknown"]))
    if np.dtype(dtype).itemsize < 8 and chance(rng, 0.5):
        image.header.set_slope_inter(float(rng.uniform(-3, 3)), float(rng.normal()))
    path = stem.with_name(stem.name + pick(rng, [".nii", ".nii.gz", ".nii.bz2"]))
    nibabel.save(image, path)
    return path


def by_hand(rng, stem):
    is_two, endian, dtype = chance(rng, 0.4), pick(rng, "<>"), pick(rng, [*TYPES, "rgb", "rgba"])
    layout, count = pick(rng, LAYOUTS), pick(rng, [2, 3, 3, 3, 4, 5])
    is_colour = dtype.startswith("rgb")
    count = min(count, 4) if is_colour else count
    shape = sizes(rng, count, 5) if count < 5 else (*sizes(rng, 3, 5), pick(rng, [1, 1, 2, 3]), pick(rng, [1, 2, 3]))
    if is_colour:
        data = voxels(rng, "uint8", (len(dtype), *shape)).tobytes(order="F")
    else:
        data = voxels(rng, dtype, shape).astype(np.dtype(dtype).newbyteorder(endian)).tobytes(order="F")
    is_single, length = layout.startswith("nii"), 540 if is_two else 348
    extra = 16 * int(rng.integers(0, 4)) if chance(rng, 0.4) else 0
    offset = length + 4 + extra if is_single else extra
    header = (two if is_two else one)(rng, endian, dtype, shape, offset, is_single)
    if is_colour:
        # The standard forbids scaled colours.
        at, size = (176, 16) if is_two else (112, 8)
        header = header[:at] + bytes(size) + header[at + size :]
    packed = {"gz": gzip.compress, "bz2": bz2.compress}.get(layout.rsplit(".")[-1], bytes)
    ending = "." + layout.split(".", 1)[1] if "." in layout else ""
    if is_single:
        path = stem.with_name(f"{stem.name}.nii{ending}")
        path.write_bytes(packed(header + bytes(4 + extra) + data))
        return path
    for part, content in (("hdr", header + bytes(4)), ("img", bytes(extra) + data)):
        path = stem.with_name(f"{stem.name}.{part}{ending}")
        path.write_bytes(packed(content))
    return stem.with_name(f"{stem.name}.{pick(rng, ['hdr', 'img'])}{ending}")


def fields(rng, shape):
    """dim, pixdim, slope and intercept, codes, quaternion and rows of the sform."""
    dim = [len(shape), *shape, *[pick(rng, [0, 1])] * 7][:8]
    first = [pick(rng, [1.0, -1.0, 0.0]), *spacing(rng, 7)]
    if chance(rng, 0.1):
        first[int(rng.integers(1, 4))] *= -1
    slope = pick(rng, [0.0, 1.0, float(np.float32(rng.uniform(-2, 2))), float("nan")])
    intercept = pick(rng, [0.0, float(np.float32(rng.normal() * 50))])
    quaternion = rng.normal(size=4)
    quaternion /= np.linalg.norm(quaternion)
    if quaternion[0] < 0:
        quaternion = -quaternion
    # Rounding may not bring b, c and d beyond the sphere: nibabel refuses what is well outside.
    rows = np.zeros((3, 4))
    rows[:, :3] = directions(rng) * (first[1:4] if chance(rng, 0.7) else spacing(rng))
    if chance(rng, 0.15):
        rows[:, 2] += 0.2 * rows[:, 1]
    rows[:, 3] = rng.normal(size=3) * 80
    codes = [pick(rng, [0, 1, 2]), pick(rng, [0, 1, 4])]
    return dim, first, [slope, intercept], codes, [*quaternion[1:] * 0.999999, *rng.normal(size=3) * 80], rows.ravel()


def bits(dtype):
    return 8 * len(dtype) if dtype.startswith("rgb") else 8 * np.dtype(dtype).itemsize


def intent(rng, shape):
    return pick(rng, [1007, 1007, 0]) if len(shape) == 5 and shape[4] > 1 else pick(rng, [0, 0, 1002, 3])


def one(rng, endian, dtype, shape, offset, is_single):
    dim, pixdim, scaling, codes, quaternion, rows = fields(rng, shape)
    header = bytearray(348)
    put = lambda at, kind, *values: struct.pack_into(endian + kind, header, at, *values)  # noqa: E731
    put(0, "i", 348)
    put(40, "8h", *dim)
    put(68, "3h", intent(rng, shape), CODES[dtype], bits(dtype))
    put(76, "8f", *pixdim)
    put(108, "3f", offset, *scaling)
    put(123, "B", pick(rng, [0, 1, 2, 3]) | pick(rng, [0, 8, 16]))
    put(252, "2h", *codes)
    put(256, "6f", *quaternion)
    put(280, "12f", *rows)
    header[344:348] = b"n+1\0" if is_single else b"ni1\0"
    return bytes(header)


def two(rng, endian, dtype, shape, offset, is_single):
    dim, pixdim, scaling, codes, quaternion, rows = fields(rng, shape)
    header = bytearray(540)
    put = lambda at, kind, *values: struct.pack_into(endian + kind, header, at, *values)  # noqa: E731
    put(0, "i", 540)
    header[4:12] = (b"n+2" if is_single else b"ni2") + b"\0\r\n\x1a\n"
    put(12, "2h", CODES[dtype], bits(dtype))
    put(16, "8q", *dim)
    put(104, "8d", *pixdim)
    put(168, "q", offset)
    put(176, "2d", *scaling)
    put(344, "2i", *codes)
    put(352, "6d", *quaternion)
    put(400, "12d", *rows)
    put(500, "2i", pick(rng, [0, 1, 2, 3]) | pick(rng, [0, 8, 16]), intent(rng, shape))
    return bytes(header)


def seen(rng, path):
    """What nibabel says."""
    try:
        image = nibabel.load(path)
        data = np.asanyarray(image.dataobj)
        if data.dtype.fields:
            colours = np.stack([data[name] for name in data.dtype.names], axis=-1)
            data = colours.reshape(data.shape + (1,) * (4 - data.ndim) + colours.shape[-1:])
    except Exception as problem:  # noqa: BLE001 - libraries raise anything
        raise Unreadable(f"nibabel: {problem}") from problem
    header = image.header
    data = data.reshape(data.shape + (1,) * (5 - data.ndim)).astype(np.float64)
    times, components = data.shape[3:5]
    chosen = {}
    if times > 1 and chance(rng, 0.5):
        chosen["time"] = int(rng.integers(times))
    if components > 1 and chance(rng, 0.5):
        chosen["component"] = int(rng.integers(components))
    case = Case(path, data[..., chosen.get("time", 0), chosen.get("component", 0)], chosen=chosen, times=times,
                components=components, how=f"NIfTI {path.name.split('.', 1)[1]} {header.endianness}")  # fmt: skip
    zooms = [abs(float(z)) or 1.0 for z in header.get_zooms()[:3]]
    case.spacing = [*zooms, None, None][:3]
    unit = header.get_xyzt_units()[0]
    case.units = UNITS.get(unit, "")
    has_form = header["sform_code"] > 0 or header["qform_code"] > 0
    case.is_patient = bool(has_form)
    if not has_form:
        case.orientation = False
        return case
    affine = np.diag([-1.0, -1, 1, 1]) @ image.affine
    case.spacing = np.linalg.norm(affine[:3, :3], axis=0)
    case.orientation, case.origin = affine[:3, :3] / case.spacing, affine[:3, 3]
    return case

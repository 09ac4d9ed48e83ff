"""TIFF: stacks, ImageJ hyperstacks, OME-TIFF and others, written and read by tifffile."""

import re
from xml.etree import ElementTree

import numpy as np
import tifffile

from .case import Case, Unreadable, chance, named, pick, sizes, voxels

TYPES = ["uint8", "int8", "uint16", "int16", "uint32", "int32", "uint64", "int64", "float16", "float32", "float64"]
PACKED = [None, None, "zlib", "lzw", "packbits", "zstd", "deflate"]


def make(rng, stem):
    maker = pick(rng, [plain, plain, shaped, imagej, ome, ome, colours])
    path = named(stem, ".ome.tif" if maker in (ome, ome_by_hand) else pick(rng, [".tif", ".tiff"]))
    try:
        units = maker(rng, path)
    except (ValueError, TypeError, NotImplementedError) as problem:
        raise Unreadable(f"tifffile does not write it: {problem}") from problem
    return seen(rng, path, maker.__name__, units)


def options(rng, dtype, shape):
    """How pixels are packed."""
    found = {"compression": pick(rng, PACKED), "byteorder": pick(rng, "<>"), "bigtiff": chance(rng, 0.3)}
    if chance(rng, 0.3):
        found["tile"] = (16, pick(rng, [16, 32]))
    elif chance(rng, 0.4):
        found["rowsperstrip"] = int(rng.integers(1, 4))
    can_predict = found["compression"] in ("zlib", "lzw", "deflate", "zstd")
    if can_predict and np.dtype(dtype).itemsize < 8 and chance(rng, 0.4):
        found["predictor"] = True
    return found


def planes(rng, count):
    return (*sizes(rng, count, 4), *(int(n) for n in rng.integers(2, 21, size=2)))


def resolution(rng):
    found = {}
    if chance(rng, 0.6):
        x = float(np.round(rng.uniform(0.5, 40), 2))
        found["resolution"] = (x, x if chance(rng, 0.6) else float(np.round(rng.uniform(0.5, 40), 2)))
    return found


def plain(rng, path):
    dtype, shape = pick(rng, TYPES), planes(rng, pick(rng, [0, 1, 1]))
    extra = {"resolutionunit": pick(rng, ["NONE", "INCH", "CENTIMETER"])} if chance(rng, 0.5) else {}
    chosen = options(rng, dtype, shape)
    outer = {key: chosen.pop(key) for key in ("byteorder", "bigtiff")}
    with tifffile.TiffWriter(path, **outer) as out:
        photometric = "miniswhite" if chance(rng, 0.15) else "minisblack"
        out.write(
            voxels(rng, dtype, shape), photometric=photometric, metadata=None, **chosen, **resolution(rng), **extra
        )


def shaped(rng, path):
    dtype, axes = pick(rng, TYPES), pick(rng, ["ZYX", "CZYX", "ZCYX", "TZYX", "TZCYX", "TYX", "CYX", "QYX", None])
    shape = planes(rng, len(axes) - 2 if axes else 1)
    metadata = {"axes": axes} if axes else {}
    chosen = options(rng, dtype, shape)
    if chance(rng, 0.25):
        # One page, and all further planes behind it.
        chosen = {key: chosen[key] for key in ("byteorder", "bigtiff")} | {"truncate": True}
    tifffile.imwrite(path, voxels(rng, dtype, shape), photometric="minisblack", metadata=metadata, **chosen)


def imagej(rng, path):
    dtype, axes = pick(rng, ["uint8", "uint16", "float32"]), pick(rng, ["ZYX", "TZCYX", "ZCYX", "TZYX", "CYX", "TYX"])
    shape = planes(rng, len(axes) - 2)
    unit = pick(rng, ["", "um", "micron", "mm", "nm", "\\u00B5m"])
    metadata = {"axes": axes} | ({"unit": unit} if unit else {})
    if chance(rng, 0.7):
        metadata["spacing"] = float(np.round(rng.uniform(0.1, 5), 3))
    chosen = {k: v for k, v in options(rng, dtype, shape).items() if k in ("byteorder", "compression", "predictor")}
    if chosen["compression"] is None:
        chosen.pop("predictor", None)
        if chance(rng, 0.5):
            chosen["truncate"] = True
    tifffile.imwrite(path, voxels(rng, dtype, shape), imagej=True, metadata=metadata, **chosen, **resolution(rng))
    return {"um": "µm", "micron": "µm", "mm": "mm", "nm": "nm", "\\u00B5m": "µm"}.get(unit, "")


def ome(rng, path):
    dtype, axes = (
        pick(rng, [t for t in TYPES if t not in ("uint64", "int64", "float16")]),
        pick(rng, ["ZYX", "CZYX", "ZCYX", "TCZYX", "TZCYX", "TZYX", "ZTYX", "CYX"]),
    )
    shape = planes(rng, len(axes) - 2)
    metadata = {"axes": axes}
    unit = pick(rng, ["µm", "nm", "mm", None])
    for axis in "XYZ":
        if chance(rng, 0.8):
            metadata[f"PhysicalSize{axis}"] = float(np.round(rng.uniform(0.1, 5), 3))
            if unit:
                metadata[f"PhysicalSize{axis}Unit"] = unit
    if "C" in axes and chance(rng, 0.6):
        metadata["Channel"] = {"Name": [f"dye {i}" for i in range(shape[axes.index("C")])]}
    tifffile.imwrite(
        path,
        voxels(rng, dtype, shape),
        ome=True,
        photometric="minisblack",
        metadata=metadata,
        **options(rng, dtype, shape),
    )


def ome_by_hand(rng, path):
    """Pages in any order, each placed by an element of its own, or runs of them."""
    dtype, order = pick(rng, ["uint8", "uint16", "float32"]), "XY" + "".join(rng.permutation(list("ZCT")))
    counts = dict(zip("ZCT", sizes(rng, 3, 3)))
    height, width = (int(n) for n in rng.integers(2, 9, size=2))
    total = counts["Z"] * counts["C"] * counts["T"]
    places = rng.permutation(total) if chance(rng, 0.6) else np.arange(total)
    blocks = ""
    for page, place in enumerate(places):
        first, rest = "", int(place)
        for axis in order[2:]:
            first += f' First{axis}="{rest % counts[axis]}"'
            rest //= counts[axis]
        blocks += f'<TiffData IFD="{page}"{first} PlaneCount="1"/>'
    if (places == np.arange(total)).all() and chance(rng, 0.5):
        blocks = pick(rng, ["<TiffData/>", f'<TiffData IFD="0" PlaneCount="{total}"/>'])
    said = "".join(f' Size{axis}="{n}"' for axis, n in {**counts, "X": width, "Y": height}.items())
    kind = {"uint8": "uint8", "uint16": "uint16", "float32": "float"}[dtype]
    text = (
        '<?xml version="1.0" encoding="UTF-8"?><OME xmlns="http://www.openmicroscopy.org/Schemas/OME/2016-06"><Image ID="Image:0">'
        f'<Pixels ID="Pixels:0" DimensionOrder="{order}" Type="{kind}"{said} PhysicalSizeX="0.25" PhysicalSizeY="0.5">'
        + "".join(f'<Channel ID="Channel:0:{i}" SamplesPerPixel="1"/>' for i in range(counts["C"]))
        + f"{blocks}</Pixels></Image></OME>"
    )
    with tifffile.TiffWriter(path, byteorder=pick(rng, "<>"), bigtiff=chance(rng, 0.3)) as out:
        for page in range(total):
            out.write(voxels(rng, dtype, (height, width)), photometric="minisblack", metadata=None,
                      description=text if page == 0 else None)  # fmt: skip


def colours(rng, path):
    dtype, samples = pick(rng, ["uint8", "uint16", "float32"]), pick(rng, [3, 4, 2])
    shape = planes(rng, 1)
    planar = pick(rng, ["contig", "contig", "separate"])
    shape = (*shape, samples) if planar == "contig" else (shape[0], samples, *shape[1:])
    extra = {"extrasamples": ["unassalpha"]} if samples in (2, 4) else {}
    photometric = "rgb" if samples > 2 else "minisblack"
    tifffile.imwrite(
        path,
        voxels(rng, dtype, shape),
        photometric=photometric,
        planarconfig=planar,
        metadata=None,
        **extra,
        **options(rng, dtype, shape),
    )


def seen(rng, path, how, units):
    """What tifffile says: axes by their letters, others as slices; spacing where ImageJ or OME give it."""
    with tifffile.TiffFile(path) as file:
        series = file.series[0]
        data, axes = series.asarray(), series.axes
        metadata = file.imagej_metadata or {}
        page = file.pages[0]
        description = page.description
        pitch = [page.tags.valueof(f"{axis}Resolution") for axis in "XY"]
    axes = re.sub(r"[^TZCYXS]", "Z", axes) if axes.count("Z") == 0 else axes
    if re.search(r"[^TZCYXS]", axes) or len(set(axes)) != len(axes):
        raise Unreadable(f"axes {axes} are no volume")
    wanted = "XYZCTS"
    for axis in wanted:
        if axis not in axes:
            axes, data = axes + axis, data[..., None]
    data = data.transpose([axes.index(axis) for axis in wanted]).astype(np.float64)
    channels, times, samples = data.shape[3:]
    chosen = {}
    for name, count in (("channel", channels), ("time", times), ("component", samples)):
        if count > 1 and chance(rng, 0.5):
            chosen[name] = int(rng.integers(count))
    values = data[:, :, :, chosen.get("channel", 0), chosen.get("time", 0), chosen.get("component", 0)]
    case = Case(path, values, chosen=chosen, components=samples, channels=channels, times=times, units=units,
                orientation=False, how=f"TIFF {how}")  # fmt: skip
    if how == "imagej":
        x, y = [p[1] / p[0] if p and p[0] else 1.0 for p in pitch]
        case.spacing = [x, y, float(metadata.get("spacing", 1.0))]
    if how.startswith("ome"):
        of_ome(case, description)
    return case


def of_ome(case, description):
    pixels = ElementTree.fromstring(description).find(".//{*}Pixels")
    steps = [pixels.get(f"PhysicalSize{axis}") for axis in "XYZ"]
    case.spacing = [float(step) if step else None for step in steps]
    unit = next((pixels.get(f"PhysicalSize{axis}Unit", "µm") for axis, step in zip("XYZ", steps) if step), None)
    case.units = unit or ""

"""NRRD: written by pynrrd, or line by line where it would not write so; read by pynrrd, or by Teem in SimpleITK."""

import bz2
import gzip

import nrrd
import numpy as np
import SimpleITK

from .case import TYPES, UNITS, Case, Unreadable, chance, directions, named, pick, sizes, spacing, voxels

WORDS = {
    "uint8": ["uchar", "unsigned char", "uint8", "uint8_t"], "int8": ["signed char", "int8", "int8_t"],
    "uint16": ["ushort", "unsigned short", "unsigned short int", "uint16"], "int16": ["short", "short int", "int16_t"],
    "uint32": ["uint", "unsigned int", "uint32_t"], "int32": ["int", "signed int", "int32"],
    "uint64": ["ulonglong", "unsigned long long int", "uint64"], "int64": ["longlong", "long long", "int64_t"],
    "float32": ["float"], "float64": ["double"],
}  # fmt: skip
SPACES = ["left-posterior-superior", "LPS", "right-anterior-superior", "RAS", "left-anterior-superior", "LAS",
          "scanner-xyz", "3D-right-handed", "left-posterior-superior-time", "space dimension"]  # fmt: skip
FIRST = ["vector", "3-vector", "RGB-color", "list", "covariant-vector", "time"]


def make(rng, stem):
    dtype, encoding = pick(rng, TYPES), pick(rng, ["raw", "raw", "gzip", "bzip2", "text", "hex"])
    dims, endian = sizes(rng), pick(rng, ["little", "big"])
    extra = pick(rng, ["", "", "", "first", "last", "flat"])
    shape = {"first": (pick(rng, [2, 3]), *dims), "last": (*dims, pick(rng, [2, 3])), "flat": dims[:2]}.get(extra, dims)
    kinds = ["domain" if chance(rng, 0.5) else "space"] * len(shape)
    if extra == "first":
        kinds[0] = pick(rng, FIRST)
    if extra == "last":
        kinds[-1] = pick(rng, ["vector", "list", "time", "covariant-vector"])
    spatial = [i for i, kind in enumerate(kinds) if kind in ("domain", "space")]
    header, truth = place(rng, shape, spatial)
    if extra in ("first", "last") or chance(rng, 0.5):
        header["kinds"] = " ".join(kinds)
    if not extra and chance(rng, 0.3):
        header["labels"] = " ".join('"abc"' for _ in shape)
    data = voxels(rng, dtype, shape)
    if chance(rng, 0.35) and encoding != "hex" and stem.name.isascii():
        path = by_pynrrd(rng, stem, data, header, encoding, endian)
    else:
        path = by_hand(rng, stem, data, header, encoding, endian)
    read = by_teem(path, data) if encoding == "hex" else by_library(path, data)
    if not np.array_equal(read, data):
        raise Unreadable("the library reads other values than were written")
    return case(rng, path, read.astype(np.float64), kinds if "kinds" in header else None, extra, truth, encoding)


def place(rng, shape, spatial):
    """Fields that place the grid, and what they say."""
    header, truth = {}, {}
    none = lambda items: [items[spatial.index(i)] if i in spatial else None for i in range(len(shape))]  # noqa: E731
    way = pick(rng, ["directions", "directions", "spacings", "ends", "nothing"])
    if way == "directions" and len(spatial) == 3:
        space, axes, steps = pick(rng, SPACES), directions(rng), spacing(rng)
        matrix = axes * steps
        if space.endswith("-time") or space == "space dimension":
            space = "left-posterior-superior" if space.endswith("-time") else space
        header["space dimension" if space == "space dimension" else "space"] = (
            "3" if space == "space dimension" else space
        )
        header["space directions"] = " ".join("none" if v is None else vector(v) for v in none(list(matrix.T)))
        origin = rng.normal(size=3) * 70
        has_origin = chance(rng, 0.8)
        if has_origin:
            header["space origin"] = vector(origin)
        if chance(rng, 0.5):
            header["space units"] = " ".join(
                f'"{truth.setdefault("unit", pick(rng, ["mm", "um", "cm"]))}"' for _ in "xyz"
            )
        if chance(rng, 0.2):
            header["measurement frame"] = "(1,0,0) (0,1,0) (0,0,1)"
        signs = {"r": [-1, -1, 1], "la": [1, -1, 1]}
        key = (
            "r"
            if space.lower() in ("ras", "right-anterior-superior")
            else "la"
            if space.lower().startswith(("las", "left-a"))
            else ""
        )
        flip = np.array(signs.get(key, [1, 1, 1]), float)
        truth |= {"spacing": steps, "orientation": flip[:, None] * axes, "origin": flip * origin * has_origin,
                  "patient": space.lower() in ("lps", "ras", "las") or "superior" in space}  # fmt: skip
        return header, truth
    steps = spacing(rng, len(spatial))
    if way == "nothing":
        return header, truth | {"spacing": [1.0] * len(spatial)}
    if way == "spacings" or way == "directions":
        header["spacings"] = " ".join("NaN" if s is None else repr(s) for s in none(steps))
        if chance(rng, 0.4):
            header["units"] = " ".join('""' if s is None else '"mm"' for s in none(steps))
            truth["unit"] = "mm"
        return header, truth | {"spacing": steps}
    centre = pick(rng, ["cell", "node", None])
    gaps = [max(shape[i] - (centre == "node"), 1) for i in spatial]
    low = [float(n) for n in np.round(rng.normal(size=len(spatial)) * 9, 2)]
    if centre == "node" and any(shape[i] == 1 for i in spatial):
        centre, gaps = "cell", [shape[i] for i in spatial]
    header["axis mins"] = " ".join("NaN" if v is None else repr(v) for v in none(low))
    header["axis maxs"] = " ".join(
        "NaN" if v is None else repr(v) for v in none([a + s * g for a, s, g in zip(low, steps, gaps)])
    )
    if centre:
        key = pick(rng, ["centers", "centerings"])
        header[key] = " ".join("???" if v is None else centre for v in none(steps))
    return header, truth | {"spacing": steps}


def vector(numbers):
    return "(" + ",".join(repr(float(n)) for n in numbers) + ")"


def by_pynrrd(rng, stem, data, header, encoding, endian):
    lines = "".join(
        f"{key}: {value}\n"
        for key, value in header.items()
        if key not in ("axis mins", "axis maxs", "centers", "centerings")
    )
    text = f"NRRD0005\ntype: {WORDS[data.dtype.name][0]}\ndimension: {data.ndim}\nsizes: {' '.join(map(str, data.shape))}\n"
    start = named(stem, ".tmp")
    start.write_text(text + lines + "encoding: raw\nendian: little\n\n")
    with start.open("rb") as file:
        known = nrrd.read_header(file)
    for key in ("axis mins", "axis maxs"):
        if key in header:
            known[key] = np.array([float(word) for word in header[key].split()])
    for key in ("centers", "centerings"):
        if key in header:
            known["centerings"] = header[key].split()
    start.unlink()
    known |= {"encoding": encoding, "endian": endian}
    if chance(rng, 0.4):
        known["my key"] = "type: not a field"
    if encoding in ("text", "ascii"):
        known["encoding"] = "ascii"
    is_detached = encoding != "text" and chance(rng, 0.4)
    path = named(stem, ".nhdr" if is_detached else ".nrrd")
    nrrd.write(str(path), data, known, detached_header=is_detached, index_order="F")
    return path


def by_hand(rng, stem, data, header, encoding, endian):
    word = {"text": ["txt", "text", "ascii"], "gzip": ["gzip", "gz"], "bzip2": ["bzip2", "bz2"], "raw": ["raw", "raw"],
            "hex": ["hex"]}[encoding]  # fmt: skip
    ordered = data.astype(data.dtype.newbyteorder("<" if endian == "little" else ">")).tobytes(order="F")
    lines = [f"type: {pick(rng, WORDS[data.dtype.name])}", f"dimension: {data.ndim}", f"sizes: {' '.join(map(str, data.shape))}",
             f"encoding: {pick(rng, word)}"]  # fmt: skip
    if data.dtype.itemsize > 1 or chance(rng, 0.5):
        lines.append(f"endian: {endian}")
    lines += [f"{key}: {value}" for key, value in header.items()]
    if chance(rng, 0.3):
        lines.append("# sizes: 1 1 1")
    if chance(rng, 0.3):
        key = pick(
            rng, ["sizes:=9 9 9", "type:=scan", "units:=HU", "space:=MNI", "spacings:=7 7 7", "a note:=sizes: 9 9 9"]
        )
        lines.insert(int(rng.integers(len(lines) + 1)), key)
    head, skip = b"", pick(rng, ["", "", "", "bytes", "lines", "last"]) if encoding in ("raw", "text") else ""
    if skip == "lines":
        head, lines = b"one line\nand another\n", [*lines, f"{pick(rng, ['line skip', 'lineskip'])}: 2"]
    if encoding == "raw" and skip in ("bytes", "last"):
        head = bytes(range(21))
        lines.append(f"{pick(rng, ['byte skip', 'byteskip'])}: {-1 if skip == 'last' else 21}")
    content = {"raw": bytes, "hex": lambda b: b.hex(" ", 8).encode(), "gzip": gzip.compress, "bzip2": bz2.compress,
               "text": lambda b: " ".join(repr(v.item()) for v in data.ravel(order="F")).encode()}[encoding](ordered)  # fmt: skip
    end = pick(rng, ["\n", "\n", "\r\n"])
    where = pick(rng, ["attached", "attached", "beside", "list", "pattern"])
    if where == "pattern" and " " in stem.name:
        where = "list"
    if not stem.name.isascii():
        # pynrrd reads headers as ASCII.
        where = "attached"
    if where in ("list", "pattern") and (encoding != "raw" or head or data.ndim != 3):
        where = "attached"
    if encoding == "hex":
        where, end = "attached", "\n"
    text = "NRRD0005" + end + end.join(lines) + end
    if where == "attached":
        path = named(stem, ".nrrd")
        path.write_bytes((text + end).encode() + head + content)
        return path
    path = named(stem, ".nhdr")
    if where == "beside":
        named(stem, ".data").write_bytes(head + content)
        path.write_bytes((text + f"{pick(rng, ['data file', 'datafile'])}: {stem.name}.data{end}").encode())
        return path
    count = data.shape[2]
    each = len(content) // count
    for i in range(count):
        stem.with_name(f"{stem.name}_{i:02}.data").write_bytes(content[i * each : (i + 1) * each])
    names = end.join(f"{stem.name}_{i:02}.data" for i in range(count))
    files = f"LIST{end}{names}" if where == "list" else f"{stem.name}_%02d.data 0 {count - 1} 1"
    path.write_bytes((text + f"data file: {files}{end}").encode())
    return path


def by_library(path, data):
    try:
        return nrrd.read(str(path), index_order="F")[0]
    except nrrd.errors.NRRDError as problem:
        # Keys called like fields are none, but for pynrrd.
        if "Duplicate" in str(problem):
            return by_teem(path, data)
        raise Unreadable(f"pynrrd: {problem}") from problem
    except Exception as problem:  # noqa: BLE001 - libraries raise anything
        raise Unreadable(f"pynrrd: {problem}") from problem


def by_teem(path, data):
    try:
        image = SimpleITK.ReadImage(str(path), imageIO="NrrdImageIO")
    except Exception as problem:  # noqa: BLE001 - libraries raise anything
        raise Unreadable(f"SimpleITK: {problem}") from problem
    array = SimpleITK.GetArrayFromImage(image)
    is_first = image.GetNumberOfComponentsPerPixel() > 1
    found = np.moveaxis(array, -1, 0).transpose(0, *range(array.ndim - 1, 0, -1)) if is_first else array.T
    if found.shape != data.shape:
        raise Unreadable("Teem in ITK sees other axes")
    return found


def case(rng, path, data, kinds, extra, truth, encoding):
    """The grid that `data` and the fields say, with the axis of values at the end."""
    components = times = 1
    is_values = kinds is None or kinds[-1] not in ("list", "time")
    if extra == "first":
        data, components = np.moveaxis(data, 0, -1)[:, :, :, None, :], data.shape[0]
    elif extra == "last" and is_values:
        data, components = data[:, :, :, None, :], data.shape[-1]
    elif extra == "last":
        data, times = data[..., None], data.shape[-1]
    else:
        data = data.reshape(*data.shape, *[1] * (5 - data.ndim))
    chosen = {}
    if times > 1 and chance(rng, 0.5):
        chosen["time"] = int(rng.integers(times))
    if components > 1 and chance(rng, 0.5):
        chosen["component"] = int(rng.integers(components))
    return Case(
        path, data[..., chosen.get("time", 0), chosen.get("component", 0)], components=components, times=times, chosen=chosen,
        spacing=np.array([*truth["spacing"], 1.0, 1.0][:3]), orientation=truth.get("orientation", False),
        origin=truth.get("origin"), units=UNITS.get(truth.get("unit"), ""), is_patient=truth.get("patient", False),
        how=f"NRRD {encoding} {path.suffix} {extra}",
    )  # fmt: skip

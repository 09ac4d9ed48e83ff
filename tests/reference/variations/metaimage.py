"""MetaImage: written by SimpleITK, or line by line where it would not write so; read by SimpleITK."""

import zlib

import numpy as np
import SimpleITK

from .case import TYPES, Case, Unreadable, chance, directions, named, pick, sizes, spacing, voxels

NAMES = {"uint8": "MET_UCHAR", "int8": "MET_CHAR", "uint16": "MET_USHORT", "int16": "MET_SHORT", "uint32": "MET_UINT",
         "int32": "MET_INT", "uint64": "MET_ULONG_LONG", "int64": "MET_LONG_LONG", "float32": "MET_FLOAT",
         "float64": "MET_DOUBLE"}  # fmt: skip


def make(rng, stem):
    if chance(rng, 0.4):
        return seen(rng, by_itk(rng, stem))
    path, data = by_hand(rng, stem)
    case = seen(rng, path)
    # MetaIO turns the bytes of numbers that are text, and reads one component of them: what was written counts.
    case.values = (
        np.moveaxis(data, -1, 0).T.reshape(*case.values.shape, -1)[..., case.chosen.get("component", 0)].astype(float)
    )
    return case


def by_itk(rng, stem):
    count, dtype, components = pick(rng, [2, 3, 3, 3, 4]), pick(rng, TYPES), pick(rng, [1, 1, 2, 3])
    shape = sizes(rng, count)
    shape = (*shape, components) if components > 1 else shape
    image = SimpleITK.GetImageFromArray(voxels(rng, dtype, shape), isVector=components > 1)
    image.SetSpacing(spacing(rng, image.GetDimension()))
    image.SetOrigin([float(o) for o in rng.normal(size=image.GetDimension()) * 90])
    if image.GetDimension() == 3:
        image.SetDirection(directions(rng).ravel().tolist())
    path = named(stem, pick(rng, [".mha", ".mhd"]))
    SimpleITK.WriteImage(image, str(path), chance(rng, 0.5))
    return path


def by_hand(rng, stem):
    dtype, count, components = pick(rng, TYPES), pick(rng, [2, 3, 3, 3]), pick(rng, [1, 1, 2, 3])
    shape = sizes(rng, count)
    data = voxels(rng, dtype, (*shape[::-1], components))
    is_big, encoding = chance(rng, 0.5), pick(rng, ["raw", "raw", "zlib", "text"])
    if dtype.endswith("int8") and encoding == "text":
        # MetaIO reads text of bytes as letters.
        encoding = "raw"
    lines = [("ObjectType", "Image"), ("NDims", count), ("BinaryData", encoding != "text")]
    lines.append((pick(rng, ["BinaryDataByteOrderMSB", "ElementByteOrderMSB"]), is_big))
    if chance(rng, 0.8):
        axes = directions(rng) if count == 3 else np.eye(count)
        # A row of the file for each axis of the grid.
        key = pick(rng, ["TransformMatrix", "Rotation", "Orientation"])
        lines.append((key, " ".join(repr(float(n)) for n in axes.T.ravel())))
    if chance(rng, 0.8):
        key = pick(rng, ["Offset", "Position", "Origin"])
        lines.append((key, " ".join(repr(float(n)) for n in rng.normal(size=count) * 50)))
    if chance(rng, 0.5):
        lines.append(("CenterOfRotation", " ".join(["0"] * count)))
    if chance(rng, 0.5) and count == 3:
        lines.append(("AnatomicalOrientation", pick(rng, ["RAI", "LPS", "???"])))
    if chance(rng, 0.9):
        lines.append(
            (pick(rng, ["ElementSpacing", "ElementSpacing", "ElementSize"]), " ".join(map(str, spacing(rng, count))))
        )
    lines.append(("DimSize", " ".join(map(str, shape))))
    if components > 1:
        lines.append(("ElementNumberOfChannels", components))
    if chance(rng, 0.3):
        lines.append(("Comment", "made for a test"))
    lines.append(("ElementType", NAMES[dtype]))
    rng.shuffle(lines[3:])
    order = ">" if is_big else "<"
    content = data.astype(np.dtype(dtype).newbyteorder(order)).tobytes()
    if encoding == "text":
        content = (" ".join(repr(v.item()) for v in data.ravel()) + "\n").encode()
    if encoding == "zlib":
        content = zlib.compress(content)
        lines.append(("CompressedData", True))
        if chance(rng, 0.6):
            lines.append(("CompressedDataSize", len(content)))
    return with_data(rng, stem, lines, content, can_split=encoding == "raw" and count == 3, slices=shape[-1]), data


def with_data(rng, stem, lines, content, can_split, slices):
    place = pick(rng, ["LOCAL", "beside", "header", "last", "list", "pattern"])
    if place == "pattern" and " " in stem.name:
        place = "list"
    if place != "LOCAL" and not can_split:
        place = pick(rng, ["LOCAL", "beside"])
    text = lambda: "".join(f"{key} = {value}\n" for key, value in lines).encode()  # noqa: E731
    if place == "LOCAL":
        path = named(stem, ".mha")
        path.write_bytes(text() + b"ElementDataFile = LOCAL\n" + content)
        return path
    path = named(stem, ".mhd")
    if place in ("list", "pattern"):
        each = len(content) // slices
        for i in range(slices):
            stem.with_name(f"{stem.name}_s{i + 1:03}.raw").write_bytes(content[i * each : (i + 1) * each])
        names = "\n".join(f"{stem.name}_s{i + 1:03}.raw" for i in range(slices))
        files = f"LIST\n{names}" if place == "list" else f"{stem.name}_s%03d.raw 1 {slices} 1"
    else:
        before = {"header": 37, "last": 53}.get(place, 0)
        if before:
            lines.append(("HeaderSize", -1 if place == "last" else before))
        files = stem.name + ".raw"
        named(stem, ".raw").write_bytes(bytes(range(before)) + content)
    path.write_bytes(text() + f"ElementDataFile = {files}\n".encode())
    return path


def seen(rng, path):
    """What SimpleITK says; axes that an image lacks have one voxel, a spacing of 1 and their own direction."""
    try:
        image = SimpleITK.ReadImage(str(path), imageIO="MetaImageIO")
    except Exception as problem:  # noqa: BLE001 - libraries raise anything
        raise Unreadable(f"SimpleITK: {problem}") from problem
    return of_itk(rng, path, image, "MetaImage")


def of_itk(rng, path, image, how):
    count, components = image.GetDimension(), image.GetNumberOfComponentsPerPixel()
    data = SimpleITK.GetArrayFromImage(image).astype(np.float64)
    data = data if components > 1 else data[..., None]
    # From …, z, y, x, component to x, y, z, time, component.
    data = np.moveaxis(data, -1, 0).T
    data = data.reshape(*data.shape[:count], *[1] * (4 - count), components)
    times, chosen = data.shape[3], {}
    if times > 1 and chance(rng, 0.5):
        chosen["time"] = int(rng.integers(times))
    if components > 1 and chance(rng, 0.5):
        chosen["component"] = int(rng.integers(components))
    axes, used = np.eye(3), min(count, 3)
    axes[:used, :used] = np.array(image.GetDirection()).reshape(count, count)[:used, :used]
    return Case(
        path, data[..., chosen.get("time", 0), chosen.get("component", 0)], components=components, times=times,
        spacing=np.array([*image.GetSpacing(), 1.0][:3]), origin=np.array([*image.GetOrigin(), 0.0][:3]),
        orientation=axes, chosen=chosen, how=f"{how} {count}D",
    )  # fmt: skip

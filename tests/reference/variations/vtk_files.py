"""VTK image data: XML and legacy files in every encoding, written and read by VTK."""

import re

import numpy as np
import vtk
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy

from . import vti_by_hand
from .case import TYPES, Case, Unreadable, chance, directions, named, pick, sizes, spacing, voxels

vtk.vtkObject.GlobalWarningDisplayOff()


def make(rng, stem):
    if chance(rng, 0.25):
        return vti_by_hand.make(rng, stem, seen)
    image = random_image(rng)
    if chance(rng, 0.6):
        return seen(rng, *xml(rng, stem, image))
    image.SetDirectionMatrix(1, 0, 0, 0, 1, 0, 0, 0, 1)
    image.SetExtent(0, image.GetDimensions()[0] - 1, 0, image.GetDimensions()[1] - 1, 0, image.GetDimensions()[2] - 1)
    return seen(rng, *legacy(rng, stem, image))


def random_image(rng):
    image = vtk.vtkImageData()
    dims = sizes(rng)
    first = rng.integers(-4, 9, size=3) if chance(rng, 0.3) else (0, 0, 0)
    image.SetExtent(*[int(n) for a, d in zip(first, dims) for n in (a, a + d - 1)])
    image.SetSpacing(*spacing(rng))
    image.SetOrigin(*rng.normal(size=3) * 40)
    if chance(rng, 0.5):
        image.SetDirectionMatrix(*directions(rng).ravel())
    cells = max(1, image.GetNumberOfCells())
    is_solid = all(d > 1 for d in dims)
    has_points = not is_solid or chance(rng, 0.85)
    if has_points:
        fill(rng, image.GetPointData(), image.GetNumberOfPoints(), "p")
    if is_solid and (not has_points or chance(rng, 0.3)):
        fill(rng, image.GetCellData(), cells, "c")
    if chance(rng, 0.2):
        add(image.GetFieldData(), pick(rng, ["TimeValue", "prho"]), voxels(rng, "float64", (pick(rng, [1, 5]), 1)))
    return image


def fill(rng, attributes, count, letter):
    """One to three arrays, marks of ghosts among them, one of them active or none."""
    names = [f"{letter}{word}" for word in rng.permutation(["rho", " u v", "T[K]", "a-b.c"])[: int(rng.integers(1, 4))]]
    for name in names:
        components = pick(rng, [1, 1, 1, 3, 2])
        add(attributes, name, voxels(rng, pick(rng, TYPES), (count, components)))
    if chance(rng, 0.3):
        add(attributes, "vtkGhostType", voxels(rng, "uint8", (count, 1)))
    if chance(rng, 0.6):
        attributes.SetActiveScalars(pick(rng, names))


def add(attributes, name, values):
    array = numpy_to_vtk(values, deep=True)
    array.SetName(name)
    attributes.AddArray(array)


def xml(rng, stem, image):
    writer = vtk.vtkXMLImageDataWriter()
    mode, compressor = (
        pick(rng, ["Ascii", "Binary", "Appended", "Appended"]),
        pick(rng, ["None", "ZLib", "LZ4", "LZMA"]),
    )
    getattr(writer, f"SetDataModeTo{mode}")()
    getattr(writer, f"SetCompressorTypeTo{compressor}")()
    getattr(writer, f"SetHeaderTypeToUInt{pick(rng, [32, 64])}")()
    writer.SetEncodeAppendedData(chance(rng, 0.5))
    getattr(writer, f"SetByteOrderTo{pick(rng, ['Big', 'Little'])}Endian")()
    writer.SetBlockSize(int(pick(rng, [1 << 15, 64, 256])))
    path = named(stem, ".vti")
    writer.SetFileName(str(path))
    writer.SetInputData(image)
    writer.Write()
    return path, vtk.vtkXMLImageDataReader(), f"VTI {mode} {compressor}"


def legacy(rng, stem, image):
    writer = vtk.vtkStructuredPointsWriter()
    is_binary = chance(rng, 0.5)
    writer.SetFileType(vtk.VTK_BINARY if is_binary else vtk.VTK_ASCII)
    writer.SetFileVersion(pick(rng, [42, 51]))
    path = named(stem, ".vtk")
    writer.SetFileName(str(path))
    writer.SetInputData(image)
    writer.Write()
    if not is_binary and chance(rng, 0.5):
        # Older programs write one value a line, and capitals as they like.
        text = path.read_text()
        text = re.sub(r"^(DIMENSIONS|SPACING|ORIGIN|POINT_DATA|SCALARS)", lambda m: m[0].lower(), text, flags=re.M)
        path.write_text(text.replace("spacing", "ASPECT_RATIO") if chance(rng, 0.3) else text)
    return path, vtk.vtkStructuredPointsReader(), f"VTK {'binary' if is_binary else 'text'}"


def seen(rng, path, reader, how):
    """What VTK says of the array that should be shown."""
    reader.SetFileName(str(path))
    if isinstance(reader, vtk.vtkStructuredPointsReader):
        reader.ReadAllScalarsOn(), reader.ReadAllVectorsOn(), reader.ReadAllFieldsOn()
    reader.Update()
    image = reader.GetOutput()
    if image is None or image.GetNumberOfPoints() == 0:
        raise Unreadable("VTK finds no image")
    arrays = listed(image.GetPointData(), False) + listed(image.GetCellData(), True)
    if not arrays:
        raise Unreadable("VTK finds no array")
    chosen = {}
    if chance(rng, 0.4) and len({name for name, *_ in arrays}) == len(arrays):
        name, _, is_of_cells, array = pick(rng, arrays)
        chosen["array"] = name
    else:
        name, _, is_of_cells, array = shown(arrays)
    components = array.GetNumberOfComponents()
    if components > 1 and chance(rng, 0.5):
        chosen["component"] = int(rng.integers(components))
    dims = [max(1, d - 1) if is_of_cells else d for d in image.GetDimensions()]
    values = vtk_to_numpy(array).reshape(-1, components)[:, chosen.get("component", 0)]
    place = [0.0, 0.0, 0.0]
    first = np.array(image.GetExtent()[::2]) + (0.5 if is_of_cells else 0)
    image.TransformContinuousIndexToPhysicalPoint(*first, place)
    return Case(
        path, values.reshape(dims, order="F").astype(np.float64), spacing=image.GetSpacing(), orientation=axes(image),
        origin=place, components=components, chosen=chosen, is_patient=False, how=how,
    )  # fmt: skip


def axes(image):
    """The directions of the axes as columns."""
    matrix = image.GetDirectionMatrix()
    return np.array([[matrix.GetElement(i, j) for j in range(3)] for i in range(3)])


def first_point(image):
    """Where the first point lies."""
    place = [0.0, 0.0, 0.0]
    image.TransformContinuousIndexToPhysicalPoint(*map(float, image.GetExtent()[::2]), place)
    return place


def opened(path):
    """The image in a `.vti` file and the values of its only array."""
    reader = vtk.vtkXMLImageDataReader()
    reader.SetFileName(str(path))
    reader.Update()
    return reader.GetOutput(), vtk_to_numpy(reader.GetOutput().GetPointData().GetArray(0))


def listed(attributes, is_of_cells):
    """Name, whether it is active, whether it is of cells, and the array itself."""
    active = attributes.GetScalars()
    arrays = [attributes.GetArray(i) for i in range(attributes.GetNumberOfArrays())]
    return [(a.GetName(), a is active, is_of_cells, a) for a in arrays if a is not None]


def shown(arrays):
    """Of points before cells: the active one, else the first with one component, else the first; marks are no data."""
    data = [entry for entry in arrays if not entry[0].startswith("vtkGhost")] or arrays
    return min(data, key=lambda entry: (entry[2], not entry[1], entry[3].GetNumberOfComponents() != 1))

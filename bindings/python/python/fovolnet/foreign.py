"""Arrays and their places in objects of other libraries."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np


@dataclass
class Described:
    """An array, how it is indexed, and what its object says about its voxels.

    ``facts`` has any of ``spacing`` (x, y, z), ``directions`` (unit vectors along the axes x, y, z of the voxels), ``origin`` (centre of
    the first voxel), ``patient`` (whether both are in left, posterior, superior), ``rescale`` (slope, intercept), ``units``.
    """

    array: Any
    order: str = "zyx"
    facts: dict[str, Any] = field(default_factory=dict)


def described(data: Any) -> Described:
    """The array of ``data`` with what ``data`` says about it."""
    module = type(data).__module__.split(".")[0]
    reader = READERS.get(module)
    return reader(data) if reader is not None else Described(data)


def of_simpleitk(image: Any) -> Described:
    import SimpleITK

    return Described(
        SimpleITK.GetArrayViewFromImage(image),
        facts=placed(image.GetSpacing(), np.reshape(image.GetDirection(), (image.GetDimension(),) * 2), image.GetOrigin(), patient=True),
    )


def of_itk(image: Any) -> Described:
    import itk  # type: ignore[import-not-found,import-untyped,unused-ignore]

    directions = itk.array_from_matrix(image.GetDirection())
    return Described(itk.array_view_from_image(image), facts=placed(image.GetSpacing(), directions, image.GetOrigin(), patient=True))


def of_nibabel(image: Any) -> Described:
    affine = image.affine
    # NIfTI counts to the right and the front, patient space to the left and the back.
    to_lps = np.diag([-1.0, -1.0, 1.0])
    steps = to_lps @ affine[:3, :3]
    lengths = np.linalg.norm(steps, axis=0)
    facts = placed(lengths, steps / lengths, to_lps @ affine[:3, 3], patient=True)
    if not has_orientation(image.header):
        facts = {"spacing": tuple(map(float, image.header.get_zooms()[:3]))}
    facts["rescale"] = scaling(image)
    units = {"mm": "mm", "micron": "µm", "meter": "m"}.get(getattr(image.header, "get_xyzt_units", lambda: ("",))()[0])
    return Described(unscaled(image), "xyz", {**facts, **({"units": units} if units else {})})


def has_orientation(header: Any) -> bool:
    """Whether the header of a nibabel image says how the patient lies. Without, nibabel makes an affine of its own."""
    names = header.keys() if hasattr(header, "keys") else ()
    codes = [int(header[name]) for name in ("qform_code", "sform_code") if name in names]
    return any(codes) if codes else "goodRASFlag" not in names or bool(header["goodRASFlag"])


def scaling(image: Any) -> tuple[float, float]:
    """Slope and intercept of the stored values of a nibabel image."""
    slope, intercept = getattr(image.dataobj, "slope", 1.0), getattr(image.dataobj, "inter", 0.0)
    return float(slope), float(intercept)


def unscaled(image: Any) -> Any:
    """Stored values of a nibabel image."""
    proxy = image.dataobj
    return proxy.get_unscaled() if hasattr(proxy, "get_unscaled") else np.asanyarray(proxy)


def of_pyvista(data: Any) -> Described:
    if not hasattr(data, "dimensions") or not hasattr(data, "spacing"):
        raise ValueError(f"a {type(data).__name__} of PyVista has no regular voxels; resample it with pyvista.ImageData.sample")
    scalars, directions = data.active_scalars, np.asarray(data.direction_matrix, dtype=float)
    dimensions, origin = np.array(data.dimensions), np.array(data.origin)
    if scalars is not None and len(scalars) == np.prod(np.maximum(dimensions - 1, 1)) != np.prod(dimensions):
        # A cell is a voxel, whose centre lies half a step from its first corner.
        origin = origin + directions @ (0.5 * np.array(data.spacing) * (dimensions > 1))
        dimensions = np.maximum(dimensions - 1, 1)
    if scalars is None or len(scalars) != np.prod(dimensions):
        raise ValueError("the PyVista image has no active data at its points or cells; call set_active_scalars")
    scalars = np.asarray(scalars)
    return Described(
        scalars.reshape((*dimensions[::-1], *scalars.shape[1:])), facts=placed(data.spacing, directions, origin, patient=False)
    )


def of_vtk(data: Any) -> Described:
    if not data.IsA("vtkImageData"):
        raise ValueError(f"a {data.GetClassName()} has no regular voxels; resample it to vtkImageData")
    from vtkmodules.util.numpy_support import vtk_to_numpy

    scalars = data.GetPointData().GetScalars()
    if scalars is None:
        raise ValueError("the vtkImageData has no scalars at its points; call GetPointData().SetActiveScalars")
    values = vtk_to_numpy(scalars)  # type: ignore[no-untyped-call]
    matrix = data.GetDirectionMatrix()
    directions = [[matrix.GetElement(row, column) for column in range(3)] for row in range(3)]
    return Described(
        values.reshape(data.GetDimensions()[::-1] + values.shape[1:]), facts=placed(data.GetSpacing(), directions, data.GetOrigin(), patient=False)
    )


def of_xarray(data: Any) -> Described:
    if not hasattr(data, "dims") or not hasattr(data, "coords") or hasattr(data, "data_vars"):
        names = ", ".join(map(str, getattr(data, "data_vars", ())))
        raise ValueError(f"a Dataset of xarray has several variables; choose one of them as data[NAME]: {names}")
    named = [str(name).lower() for name in data.dims]
    if sorted(named[:3]) == ["x", "y", "z"] and len(named) in (3, 4):
        spatial = [data.dims[named.index(axis)] for axis in "zyx"]
        data = data.transpose(*spatial, *data.dims[3:])
    spacing = spacing_of_coordinates(data)
    return Described(data.data, facts={} if spacing is None else {"spacing": spacing})


def of_napari(layer: Any) -> Described:
    scale = [float(step) for step in layer.scale[-3:]]
    if len(scale) != 3 or not hasattr(layer, "data"):
        raise ValueError(f"the napari layer {layer.name!r} is no volume; give one of three dimensions")
    labels = {"labels": True} if type(layer).__name__ == "Labels" else {}
    return Described(layer.data, facts={"spacing": tuple(scale[::-1]), **labels})


#: Who reads objects of a library, by the name of its package.
READERS: dict[str, Callable[[Any], Described]] = {
    "SimpleITK": of_simpleitk,
    "itk": of_itk,
    "nibabel": of_nibabel,
    "pyvista": of_pyvista,
    "vtkmodules": of_vtk,
    "xarray": of_xarray,
    "napari": of_napari,
}


def placed(spacing: Any, directions: Any, origin: Any, *, patient: bool) -> dict[str, Any]:
    """Facts of a grid whose axes x, y, z point along the columns of ``directions``."""
    columns = np.asarray(directions, dtype=float).T
    if columns.shape != (3, 3):
        raise ValueError(f"the image has {len(columns)} dimensions; give one of three")
    return {
        "spacing": tuple(map(float, spacing)),
        "directions": columns.tolist(),
        "origin": tuple(map(float, origin)),
        "patient": patient,
    }


def spacing_of_coordinates(data: Any) -> tuple[float, ...] | None:
    """Distances along x, y, z by the coordinates of an xarray.DataArray, if all three axes have numbers that change evenly."""
    steps = []
    for name in reversed(data.dims[:3]):
        if name not in data.coords or data.coords[name].size < 2 or data.coords[name].dtype.kind not in "iuf":
            return None
        differences = np.diff(data.coords[name].values.astype(float))
        step = float(differences.mean())
        if step == 0.0 or not np.allclose(differences, step, rtol=1e-3):
            return None
        steps.append(abs(step))
    return tuple(steps)

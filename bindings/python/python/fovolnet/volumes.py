"""Volumes from files, from arrays, and from objects of other libraries."""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from typing import Any

import numpy as np

from ._native import Volume
from .foreign import described
from .settings_text import plain, settings_json


def read(source: str | os.PathLike[str], **settings: Any) -> Volume:
    """Reads a file, a folder, a store on the web, or a procedural volume.

    Parameters
    ----------
    source : path
        Any file that the command line reads: DICOM folders, NIfTI, NRRD, OME-Zarr, HDF5, TIFF, VTK, raw, and others; or the name of
        a procedural volume, such as ``"head"``.
    **settings
        Flags of the command line: ``dims``, ``spacing``, ``range``, ``channel``, ``time``, ``array``, ``series``, ``level``, …

    Returns
    -------
    Volume

    Raises
    ------
    FovolnetError
        The file is missing or invalid. The message says how to mend it.

    Examples
    --------
    >>> read("marschner-lobb", dims=(24, 24, 24)).shape
    (24, 24, 24)
    """
    return Volume.read(os.fspath(source), settings_json(settings))


def write(path: str | os.PathLike[str], data: Any, **options: Any) -> list[str]:
    """Writes a volume to a file.

    Parameters
    ----------
    path : path
        The extension chooses the format: .nrrd, .nii, .nii.gz, .mha, .vti, .raw, .raw.gz, and with a header apart .nhdr and .mhd.
    data, **options
        See `as_volume`.

    Returns
    -------
    list of str
        Notes on what the format cannot hold.
    """
    return as_volume(data, **options).write(os.fspath(path))


def as_volume(
    data: Any,
    *,
    spacing: Sequence[float] | None = None,
    origin: Sequence[float] | None = None,
    order: str | None = None,
    rgb: bool = False,
    labels: bool = False,
    clim: Sequence[float] | None = None,
    name: str | None = None,
) -> Volume:
    """A volume of ``data``.

    Parameters
    ----------
    data : Volume, path, array, or image of another library
        Arrays of NumPy, Dask, zarr and PyTorch are indexed [z, y, x]. xarray.DataArray, images of SimpleITK, ITK and nibabel,
        pyvista.ImageData, vtkImageData and layers of napari bring their own order, spacing and orientation. A path is read, see `read`.
    spacing : three floats, optional
        Distance of voxels along x, y, z. 1 if neither this nor ``data`` says.
    origin : three floats, optional
        Centre of the first voxel, (x, y, z). It matters where volumes are shown together.
    order : {"zyx", "xyz"}, optional
        How an array is indexed. Arrays from PyVista and nibabel are indexed [x, y, z].
    rgb : bool
        The last axis has three or four colours of each voxel.
    labels : bool
        The values are labels: voxels are shown without interpolation.
    clim : two floats, optional
        Values shown as 0 and 1. From the histogram, if not given; 0 and 255 for uint8.
    name : str, optional
        Name in notes.

    Returns
    -------
    Volume
        It shares the memory of arrays that lie in C order as [z, y, x]; do not change these while it renders. Others are copied.

    Raises
    ------
    ValueError
        A shape, type or order that cannot be rendered. The message says how to mend it.

    Examples
    --------
    >>> as_volume(np.zeros((4, 5, 6)), spacing=(1, 1, 2.5))
    <fovolnet.Volume (4, 5, 6) f64 from the array>
    """
    if isinstance(data, (str, os.PathLike)):
        data = read(data)
    if isinstance(data, Volume):
        if spacing is not None or order is not None or rgb or labels or origin is not None:
            raise ValueError("a Volume has its own spacing, origin, order and colours; give them to read or as_volume")
        return data if clim is None else data.with_range(pair(clim))
    found = described(data)
    order = order or found.order
    if order not in ("zyx", "xyz"):
        raise ValueError(f"order is 'zyx' or 'xyz', not {order!r}")
    array = c_ordered(dense(found.array), order, rgb)
    facts = dict(found.facts, rgb=rgb)
    if spacing is not None:
        facts["spacing"] = triple("spacing", spacing)
    if origin is not None:
        facts["origin"] = triple("origin", origin)
        facts.setdefault("directions", np.eye(3).tolist())
    if clim is not None:
        facts["range"] = pair(clim)
    if labels:
        facts["labels"] = True
    if name is not None:
        facts["source"] = name
    return Volume.from_array(array, json.dumps({key: plain(value) for key, value in facts.items()}))


def dense(data: Any) -> np.ndarray[Any, Any]:
    """``data`` as an array of NumPy. Masked values become NaN, which is transparent."""
    array = data if isinstance(data, np.ndarray) else np.asanyarray(data)
    if np.ma.isMaskedArray(array):
        if np.ma.is_masked(array):
            exact = np.float32 if array.dtype.itemsize <= 2 or array.dtype == np.float32 else np.float64
            return np.ma.filled(array.astype(exact), np.nan)
        array = np.ma.getdata(array)
    return np.asarray(array)


def c_ordered(array: np.ndarray[Any, Any], order: str, rgb: bool) -> np.ndarray[Any, Any]:
    """``array`` as [z, y, x] or [z, y, x, colour] in C order, copied only where it lies otherwise."""
    expected = 4 if rgb else 3
    if array.ndim != expected:
        how = "(z, y, x, 3 or 4) with rgb=True" if rgb else "(z, y, x)"
        hint = ""
        if array.ndim == 4 and not rgb:
            hint = "; take one channel or time point, as array[0]; a last axis of 3 or 4 is colour with rgb=True"
        elif array.ndim == 2:
            hint = "; a picture is a volume with one slice, array[None]"
        raise ValueError(f"a volume has the shape {how}, not {array.shape}{hint}")
    if 0 in array.shape:
        raise ValueError(f"the array has no voxels: its shape is {array.shape}")
    if array.dtype.kind in "OUSVMm":
        raise ValueError(f"values of type {array.dtype} cannot be rendered; convert them, for example array.astype(numpy.float32)")
    if array.dtype.kind == "c":
        raise ValueError("complex values cannot be rendered; convert them, for example to numpy.abs(array)")
    if array.dtype.kind == "f" and array.dtype.itemsize > 8:
        raise ValueError(f"values of type {array.dtype} cannot be rendered; convert them with array.astype(numpy.float64)")
    if order == "xyz":
        array = np.swapaxes(array, 0, 2)
    return np.ascontiguousarray(array)


def triple(name: str, values: Sequence[float]) -> tuple[float, ...]:
    """Three finite numbers of the argument ``name``."""
    numbers = tuple(float(value) for value in np.ravel(np.asarray(values, dtype=float)))
    if len(numbers) != 3 or not np.isfinite(numbers).all():
        raise ValueError(f"{name} has three numbers, for x, y and z, not {values!r}")
    return numbers


def pair(clim: Sequence[float]) -> tuple[float, float]:
    """The two ends of ``clim``."""
    ends = [float(value) for value in np.ravel(np.asarray(clim, dtype=float))]
    if len(ends) != 2 or not np.isfinite(ends).all() or ends[0] >= ends[1]:
        raise ValueError(f"clim has two numbers, the lower one first, not {clim!r}")
    return ends[0], ends[1]

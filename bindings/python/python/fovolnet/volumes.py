"""Volumes from files and from arrays of other libraries."""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import Any

import numpy as np

from ._native import Volume
from .settings_text import settings_json


def read(source: str | os.PathLike[str], **settings: Any) -> Volume:
    """Reads a file, a folder or a procedural volume.

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
    """
    return Volume.read(os.fspath(source), settings_json(settings))


def as_volume(
    data: Any,
    *,
    spacing: Sequence[float] | None = None,
    order: str | None = None,
    rgb: bool = False,
    clim: Sequence[float] | None = None,
) -> Volume:
    """A volume of ``data``.

    Parameters
    ----------
    data : Volume, array, xarray.DataArray, SimpleITK.Image, nibabel image, or pyvista.ImageData
        Arrays are indexed [z, y, x]. Other objects bring their own order and spacing.
    spacing : three floats, optional
        Distance of voxels along x, y, z. 1 if neither this nor ``data`` says.
    order : {"zyx", "xyz"}, optional
        How an array is indexed. PyVista and nibabel index [x, y, z].
    rgb : bool
        The last axis has three or four colours of each voxel.
    clim : two floats, optional
        Values shown as 0 and 1.

    Returns
    -------
    Volume
        It shares the memory of arrays that lie in C order as [z, y, x]; do not change these while it renders.
    """
    if isinstance(data, Volume):
        return data if clim is None else data.with_range(tuple(map(float, clim)))
    array, own_order, own_spacing = foreign(data)
    order = order or own_order
    if order not in ("zyx", "xyz"):
        raise ValueError(f"order is 'zyx' or 'xyz', not {order!r}")
    array = np.ma.filled(array, np.nan) if np.ma.isMaskedArray(array) and array.dtype.kind == "f" else np.asarray(array)
    expected = 4 if rgb else 3
    if array.ndim != expected:
        how = "(z, y, x, 3 or 4) with rgb=True" if rgb else "(z, y, x)"
        hint = "; a last axis of 3 or 4 is colour with rgb=True" if array.ndim == 4 and not rgb else ""
        raise ValueError(f"a volume has the shape {how}, not {array.shape}{hint}")
    if order == "xyz":
        array = np.swapaxes(array, 0, 2)
    spacing = spacing if spacing is not None else own_spacing or (1.0, 1.0, 1.0)
    return Volume.from_array(
        np.ascontiguousarray(array), tuple(map(float, spacing)), rgb, None if clim is None else tuple(map(float, clim))
    )


def foreign(data: Any) -> tuple[Any, str, tuple[float, ...] | None]:
    """The array of an object, how it is indexed, and its spacing along x, y, z if it has one."""
    module = type(data).__module__.split(".")[0]
    if module == "SimpleITK":
        import SimpleITK

        return SimpleITK.GetArrayViewFromImage(data), "zyx", tuple(data.GetSpacing())
    if module == "nibabel":
        return np.asanyarray(data.dataobj), "xyz", tuple(float(zoom) for zoom in data.header.get_zooms()[:3])
    if module == "pyvista":
        scalars = data.active_scalars
        if scalars is None or len(scalars) != np.prod(data.dimensions):
            raise ValueError("the PyVista image has no active point data; call set_active_scalars, or cell_data_to_point_data")
        return np.asarray(scalars).reshape(data.dimensions[::-1]), "zyx", tuple(data.spacing)
    if module == "xarray":
        return data.values, "zyx", spacing_of_coordinates(data)
    return data, "zyx", None


def spacing_of_coordinates(data: Any) -> tuple[float, ...] | None:
    """Distances along x, y, z by the coordinates of an xarray.DataArray, if all three axes have numbers that rise evenly."""
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

"""Objects of other libraries beside the command line's pictures of the files that these libraries write."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from small_pictures import picture

import fovolnet as fv

SPACING = (1.0, 1.5, 2.5)

#: A rotation of the axes of voxels that is no multiple of a right angle.
TURN = np.array([[0.96, -0.28, 0.0], [0.28, 0.96, 0.0], [0.0, 0.0, 1.0]])


@pytest.mark.parametrize("directions", [np.eye(3), np.diag([-1.0, -1.0, 1.0]), TURN])
def test_simpleitk(scan, tmp_path: Path, of_command, directions) -> None:
    sitk = pytest.importorskip("SimpleITK")
    image = sitk.GetImageFromArray(scan)
    image.SetSpacing(SPACING)
    image.SetDirection(directions.ravel())
    image.SetOrigin((10.0, 20.0, 30.0))
    path = tmp_path / "scan.nrrd"
    sitk.WriteImage(image, str(path))
    assert np.array_equal(picture(image), of_command(path))
    volume, read = fv.as_volume(image), fv.read(path)
    assert np.allclose(volume.origin, read.origin) and np.allclose(volume.directions, read.directions)


def test_itk(scan, tmp_path: Path, of_command) -> None:
    itk = pytest.importorskip("itk")
    image = itk.image_from_array(scan)
    image.SetSpacing(SPACING)
    image.SetDirection(itk.matrix_from_array(TURN))
    path = tmp_path / "scan.mha"
    itk.imwrite(image, str(path))
    assert np.array_equal(picture(image), of_command(path))


@pytest.mark.parametrize("affine", [np.diag([*SPACING, 1.0]), np.diag([-1.0, -1.5, 2.5, 1.0])])
@pytest.mark.parametrize("scaled", [False, True])
def test_nibabel(scan, tmp_path: Path, of_command, affine, scaled: bool) -> None:
    nibabel = pytest.importorskip("nibabel")
    image = nibabel.Nifti1Image(scan.transpose(2, 1, 0), affine)
    path = tmp_path / "scan.nii.gz"
    if scaled:
        image.header.set_slope_inter(0.5, -100.0)
    nibabel.save(image, path)
    expected = of_command(path)
    assert np.array_equal(picture(nibabel.load(path)), expected)
    if not scaled:
        assert np.array_equal(picture(image), expected)


def test_nibabel_without_orientation(scan, tmp_path: Path, of_command) -> None:
    nibabel = pytest.importorskip("nibabel")
    path = tmp_path / "scan.nii"
    fv.write(path, scan, spacing=SPACING)
    image = nibabel.load(path)
    assert np.array_equal(picture(image), of_command(path))
    assert fv.as_volume(image).directions is None and fv.as_volume(image).spacing == list(SPACING)


def test_pyvista(scan, tmp_path: Path, of_command) -> None:
    pyvista = pytest.importorskip("pyvista")
    grid = pyvista.ImageData(dimensions=scan.shape[::-1], spacing=SPACING, origin=(1, 2, 3))
    grid["values"] = scan.ravel()
    path = tmp_path / "scan.vti"
    grid.save(path)
    expected = of_command(path)
    assert np.array_equal(picture(grid), expected)
    vtk_image = pytest.importorskip("vtkmodules.vtkCommonDataModel").vtkImageData()
    vtk_image.DeepCopy(grid)
    assert np.array_equal(picture(vtk_image), expected)
    cells = pyvista.ImageData(dimensions=np.array(scan.shape[::-1]) + 1, spacing=SPACING, origin=(1, 2, 3))
    cells.cell_data["values"] = scan.ravel()
    cells.save(path)
    assert np.array_equal(picture(cells), of_command(path))
    volume, read = fv.as_volume(cells), fv.read(path)
    assert np.allclose(volume.origin, (1.5, 2.75, 4.25)) and np.allclose(volume.origin, read.origin)
    with pytest.raises(ValueError, match="set_active_scalars"):
        picture(pyvista.ImageData(dimensions=(3, 3, 3)))
    with pytest.raises(ValueError, match="no regular voxels"):
        picture(pyvista.Sphere())


def test_xarray(scan, tmp_path: Path, of_command) -> None:
    xarray = pytest.importorskip("xarray")
    axes = {name: step * np.arange(n) for name, n, step in zip("zyx", scan.shape, SPACING[::-1])}
    array = xarray.DataArray(scan, coords=axes, dims=list("zyx"), name="values")
    expected = picture(scan, spacing=SPACING)
    assert np.array_equal(picture(array), expected)
    assert np.array_equal(picture(array.transpose("x", "z", "y")), expected)
    with pytest.raises(ValueError, match="values"):
        picture(array.to_dataset())
    if any(name in xarray.backends.list_engines() for name in ("netcdf4", "h5netcdf", "scipy")):
        path = tmp_path / "scan.nc"
        array.to_netcdf(path)
        assert np.array_equal(expected, of_command(path))


def test_zarr_and_dask(scan) -> None:
    zarr = pytest.importorskip("zarr")
    expected = picture(scan)
    assert np.array_equal(picture(zarr.array(scan, chunks=(8, 8, 8))), expected)
    dask = pytest.importorskip("dask.array")
    assert np.array_equal(picture(dask.from_array(scan, chunks=8)), expected)


def test_torch(scan) -> None:
    torch = pytest.importorskip("torch")
    assert np.array_equal(picture(torch.from_numpy(scan)), picture(scan))


def test_napari(scan) -> None:
    layers = pytest.importorskip("napari.layers")
    assert np.array_equal(picture(layers.Image(scan, scale=SPACING[::-1])), picture(scan, spacing=SPACING))
    labels = (scan > 500).astype(np.uint8)
    assert np.array_equal(picture(layers.Labels(labels)), picture(labels, labels=True))

"""What this program says of a file beside what the outside library says."""

from pathlib import Path

import nibabel
import nrrd
import numpy as np
import SimpleITK

from . import vtk_files

# Headers of NIfTI-1 hold singles.
PLACE = 2e-5


def differences(case, order, answer):
    """How `answer` and the file that was written again differ from `case`, a phrase each."""
    found = []
    dims = list(case.values.shape)
    if answer["dims"] != dims:
        return [f"dims {answer['dims']}, not {dims}"]
    ours = np.fromfile(order["values"]).reshape(dims, order="F")
    found += of_values("", ours, case.values)
    for name in ("components", "times", "channels"):
        if answer[name] != getattr(case, name):
            found.append(f"{name} {answer[name]}, not {getattr(case, name)}")
    found += of_statistics(answer, case.values)
    found += of_place(case, answer)
    if case.units is not None and (answer["units"] or "") != case.units:
        found.append(f"units {answer['units']}, not {case.units}")
    if "converted" in answer and not answer["converted"].get("error"):
        found += of_converted(Path(order["convert"]), case, answer)
    return found


def of_values(where, ours, theirs):
    same = (ours == theirs) | (np.isnan(ours) & np.isnan(theirs))
    # Scaling rounds in another order.
    same |= np.isclose(ours, theirs, rtol=1e-6, atol=1e-6 * max(np.abs(np.nan_to_num(theirs)).max(), 1e-300))
    return [] if same.all() else [f"{where}{np.count_nonzero(~same)} of {same.size} values"]


def of_statistics(answer, values):
    finite = values[np.isfinite(values)]
    scale = np.abs(finite).max(initial=1e-300)
    wanted = {"min": finite.min(), "max": finite.max(), "mean": finite.mean()}
    return [
        f"{name} {answer[name]}, not {value}"
        for name, value in wanted.items()
        if abs(answer[name] - value) > 1e-6 * scale
    ]


def of_place(case, answer):
    found = []
    if case.spacing is not None:
        for axis, (ours, theirs) in enumerate(zip(answer["spacing"], case.spacing)):
            if theirs is not None and abs(ours - theirs) > PLACE * abs(theirs):
                found.append(f"spacing {ours} of axis {axis}, not {theirs}")
    if case.is_patient is not None and answer["is_patient"] != case.is_patient:
        found.append(f"is_patient {answer['is_patient']}")
    if case.orientation is False:
        return found if answer["orientation"] is None else [*found, "an orientation"]
    if case.orientation is not None:
        ours = np.eye(3) if answer["orientation"] is None else np.array(answer["orientation"])
        if not np.allclose(ours, case.orientation, atol=PLACE):
            found.append(f"orientation {ours.tolist()}, not {np.asarray(case.orientation).tolist()}")
    if case.origin is not None:
        ours = np.zeros(3) if answer["origin"] is None else np.array(answer["origin"])
        if not np.allclose(ours, case.origin, rtol=PLACE, atol=1e-4):
            found.append(f"origin {ours.tolist()}, not {np.asarray(case.origin).tolist()}")
    return found


def of_converted(path, case, answer):
    """How the file at `path`, which this program wrote, differs from `case` for the library of its format."""
    said = " ".join(answer["converted"]["notes"])
    values, spacing, axes, origin = {
        ".nrrd": of_nrrd,
        ".nhdr": of_nrrd,
        ".mha": of_itk,
        ".mhd": of_itk,
        ".vti": of_vti,
    }.get(path.suffix, of_nifti)(path)
    if values.size != case.values.size:
        return [f"{path.name}: {values.size} values, not {case.values.size}"]
    found = of_values(f"{path.name}: ", values.ravel(order="F"), case.values.ravel(order="F"))
    if case.spacing is not None and not any("spacing" in note for note in answer["notes"]):
        wanted = np.array([1.0 if s is None else s for s in answer["spacing"]])
        if not np.allclose(spacing, wanted, rtol=PLACE):
            found.append(f"{path.name}: spacing {list(spacing)}, not {list(wanted)}")
    if answer["orientation"] is not None and axes is not None and "left out" not in said:
        if not np.allclose(axes, answer["orientation"], atol=PLACE):
            found.append(f"{path.name}: orientation {np.asarray(axes).tolist()}, not {answer['orientation']}")
        if not np.allclose(origin, answer["origin"], rtol=PLACE, atol=1e-4):
            found.append(f"{path.name}: origin {np.asarray(origin).tolist()}, not {answer['origin']}")
    return found


def of_nrrd(path):
    data, header = nrrd.read(str(path), index_order="F")
    steps = header.get("space directions")
    if steps is None:
        return data.astype(np.float64), np.array(header.get("spacings", [1.0] * 3)), None, None
    lengths = np.linalg.norm(steps, axis=1)
    flip = {"right-anterior-superior": [-1, -1, 1]}.get(header.get("space"), [1, 1, 1])
    axes = np.array(flip)[:, None] * (steps / lengths[:, None]).T
    return data.astype(np.float64), lengths, axes, np.array(flip) * header.get("space origin", np.zeros(3))


def of_itk(path):
    image = SimpleITK.ReadImage(str(path), imageIO="MetaImageIO")
    axes = np.array(image.GetDirection()).reshape(3, 3)
    return (
        SimpleITK.GetArrayFromImage(image).T.astype(np.float64),
        np.array(image.GetSpacing()),
        axes,
        image.GetOrigin(),
    )


def of_nifti(path):
    image = nibabel.load(path)
    data, steps = np.asanyarray(image.dataobj).astype(np.float64), np.diag([-1.0, -1, 1]) @ image.affine[:3]
    data = data.reshape(data.shape + (1,) * (3 - data.ndim))
    has_form = image.header["sform_code"] > 0 or image.header["qform_code"] > 0
    steps, origin = steps[:, :3], steps[:, 3]
    lengths = np.linalg.norm(steps, axis=0)
    return data, lengths, steps / lengths if has_form else None, origin


def of_vti(path):
    image, array = vtk_files.opened(path)
    values = array.reshape(image.GetDimensions(), order="F")
    return values.astype(np.float64), np.array(image.GetSpacing()), vtk_files.axes(image), vtk_files.first_point(image)

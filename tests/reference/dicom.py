"""DICOM compared with pydicom and SimpleITK.

    pip install pydicom SimpleITK highdicom numpy pylibjpeg pylibjpeg-libjpeg pylibjpeg-openjpeg pylibjpeg-rle pyjpegls
    cargo build --release -p fovol-io --example describe_volumes
    python tests/reference/dicom.py compare PROGRAM DATA OUT   # writes files to OUT, compares, prints a table
    python tests/reference/dicom.py references                 # writes crates/fovol-io/tests/dicom_files

PROGRAM is the built example; DATA is the folder that holds `formats`. Size, spacing, directions, origin and every
value are compared. Values come from pydicom's pixels and the scaling that the file declares; where SimpleITK reads a
file or series, its geometry and values must agree too.

`references` writes small files and `dicom.json`, which `crates/fovol-io/tests/dicom.rs` compares the reader with.
"""

import json
import shutil
import subprocess
import sys
import warnings
import zlib
from pathlib import Path

import numpy as np
import pydicom
from pydicom.dataset import Dataset, FileMetaDataset
from pydicom.sequence import Sequence
from pydicom.uid import (
    CTImageStorage,
    DeflatedExplicitVRLittleEndian,
    EnhancedCTImageStorage,
    EnhancedMRImageStorage,
    ExplicitVRBigEndian,
    ExplicitVRLittleEndian,
    ImplicitVRLittleEndian,
    JPEG2000Lossless,
    JPEGLSLossless,
    MRImageStorage,
    PositronEmissionTomographyImageStorage,
    RLELossless,
    SecondaryCaptureImageStorage,
)

from summary import Summary

REPOSITORY = Path(__file__).resolve().parents[2]
FILES = REPOSITORY / "crates/fovol-io/tests/dicom_files"

AXIAL = ([1, 0, 0], [0, 1, 0])
SAGITTAL = ([0, 1, 0], [0, 0, -1])
CORONAL = ([1, 0, 0], [0, 0, -1])


def oblique():
    a, b = np.radians(20), np.radians(-35)
    about_x = np.array([[1, 0, 0], [0, np.cos(a), -np.sin(a)], [0, np.sin(a), np.cos(a)]])
    about_z = np.array([[np.cos(b), -np.sin(b), 0], [np.sin(b), np.cos(b), 0], [0, 0, 1]])
    turned = about_z @ about_x
    return turned[:, 0].tolist(), turned[:, 1].tolist()


def uid(*parts):
    return "1.2.826.0.1.3680043.9.7433." + ".".join(str(part) for part in parts)


def number(name):
    return zlib.crc32(name.encode()) % 1_000_000


def ramp(shape, dtype=np.int16, low=-900, high=2000):
    """Values without symmetry."""
    if len(shape) == 4:
        return np.stack([ramp(shape[1:], dtype, low, high) + time for time in range(shape[0])])
    z, y, x = np.indices(shape)
    values = (x * 37 + y * 101 + z * 211 + x * y * 5 + x * z * 3) % (high - low) + low
    return values.astype(dtype)


def text(value):
    return f"{value:.10g}"[:16]


def base(name, sop_class=CTImageStorage, modality="CT"):
    data = Dataset()
    data.SOPClassUID = sop_class
    data.StudyInstanceUID = uid(1, number(name))
    data.SeriesInstanceUID = uid(2, number(name))
    data.FrameOfReferenceUID = uid(3, number(name))
    data.Modality = modality
    data.SeriesDescription = name
    data.PatientName = "Synthetic^Secret"
    data.PatientID = "SECRET-ID"
    data.PatientBirthDate = "19010203"
    data.StudyDate = "20010203"
    data.InstitutionName = "Secret institution"
    data.ImageType = ["ORIGINAL", "PRIMARY", "AXIAL"]
    return data


def pixels(data, values, stored=None, high=None):
    """Puts a frame or frames of 8, 16 or 32 bits into the file."""
    values = np.ascontiguousarray(values)
    bits = values.dtype.itemsize * 8
    data.Rows, data.Columns = values.shape[-2:]
    data.SamplesPerPixel = 1
    data.PhotometricInterpretation = "MONOCHROME2"
    data.BitsAllocated = bits
    data.BitsStored = stored or bits
    data.HighBit = (stored or bits) - 1 if high is None else high
    data.PixelRepresentation = int(values.dtype.kind == "i")
    data.PixelData = values.astype(values.dtype.newbyteorder("<")).tobytes()
    if len(data.PixelData) % 2:
        data.PixelData += b"\0"
    return data


def save(data, path, syntax=ExplicitVRLittleEndian, preamble=True):
    path.parent.mkdir(parents=True, exist_ok=True)
    meta = FileMetaDataset()
    meta.MediaStorageSOPClassUID = data.SOPClassUID
    meta.MediaStorageSOPInstanceUID = data.SOPInstanceUID
    meta.TransferSyntaxUID = syntax
    meta.ImplementationClassUID = uid(0)
    data.file_meta = meta
    if not preamble:
        encodings = {ImplicitVRLittleEndian: (True, True), ExplicitVRLittleEndian: (False, True)}
        implicit, little = encodings[syntax]
        del data.file_meta
        pydicom.dcmwrite(path, data, enforce_file_format=False, implicit_vr=implicit, little_endian=little)
        return
    if syntax == ExplicitVRBigEndian and data.BitsAllocated > 8:
        kind = np.dtype(f"<u{data.BitsAllocated // 8}")
        swapped = np.frombuffer(data.PixelData, kind).byteswap().tobytes()
        data = pydicom.Dataset(data)
        data.file_meta = meta
        data.PixelData = swapped
    if syntax in (RLELossless, JPEG2000Lossless, JPEGLSLossless):
        data.file_meta.TransferSyntaxUID = ExplicitVRLittleEndian
        data.compress(syntax, generate_instance_uid=False)
    pydicom.dcmwrite(path, data, enforce_file_format=True)


def series(folder, name, values, directions=AXIAL, spacing=(0.7, 0.9, 2.5), origin=(-12.5, 30.25, -7.0), **how):
    """Writes `values` (z, y, x) as one file a slice, in shuffled order. Returns what is expected of them."""
    x, y = (np.array(d, float) for d in directions)
    normal = np.cross(x, y)
    depth = len(values)
    heights = how.get("heights", np.arange(depth) * spacing[2])
    slide = how.get("slide", np.zeros((depth, 3)))
    slopes = how.get("slopes", [(1, -1024)] * depth)
    order = np.random.default_rng(number(name)).permutation(depth)
    out = []
    for place in order:
        data = base(how.get("series", name), how.get("sop_class", CTImageStorage), how.get("modality", "CT"))
        data.SOPInstanceUID = uid(4, number(name), int(place) + 1)
        data.InstanceNumber = int(depth - place)
        data.PixelSpacing = [text(spacing[1]), text(spacing[0])]
        data.SliceThickness = text(how.get("thickness", spacing[2]))
        position = np.array(origin) + normal * heights[place] + slide[place]
        data.ImagePositionPatient = [text(v) for v in position]
        data.ImageOrientationPatient = [text(v) for v in [*x, *y]]
        slope, intercept = slopes[place]
        data.RescaleSlope, data.RescaleIntercept = text(slope), text(intercept)
        pixels(data, values[place], how.get("stored"), how.get("high"))
        for key, value in how.get("more", {}).items():
            setattr(data, key, value(place) if callable(value) else value)
        file = folder / name / how.get("file", "IM{:04}.dcm").format(int(np.where(order == place)[0][0]))
        save(data, file, how.get("syntax", ExplicitVRLittleEndian), how.get("preamble", True))
        out.append((place, slope, intercept))
    scaled = np.stack([values[p].astype(float) * slopes[p][0] + slopes[p][1] for p in range(depth)])
    return expectation(folder / name, scaled, spacing, (x, y, normal), origin)


def expectation(path, values, spacing, directions, origin, **more):
    return {
        "path": path,
        "values": values,
        "spacing": list(spacing),
        "orientation": None if directions is None else np.column_stack(directions).tolist(),
        "origin": None if origin is None else list(origin),
        **more,
    }


# Cases -------------------------------------------------------------------------------------------


def plain_series(out):
    cases = {}
    for name, directions in {"axial": AXIAL, "sagittal": SAGITTAL, "coronal": CORONAL, "oblique": oblique()}.items():
        cases[name] = series(out, name, ramp((7, 9, 12), np.int16), directions)
    cases["unsigned12"] = series(out, "unsigned12", ramp((5, 8, 6), np.uint16, 0, 4095), stored=12)
    cases["unsigned16"] = series(out, "unsigned16", ramp((5, 8, 6), np.uint16, 0, 65535), stored=16)
    cases["byte"] = series(out, "byte", ramp((5, 8, 6), np.uint8, 0, 255), slopes=[(1, 0)] * 5)
    cases["signed_byte"] = series(out, "signed_byte", ramp((5, 8, 6), np.int8, -120, 120), slopes=[(1, 0)] * 5)
    cases["words32"] = series(
        out, "words32", ramp((5, 8, 6), np.int32, -90_000, 2_000_000) * 7, slopes=[(1, 0)] * 5,
        sop_class=SecondaryCaptureImageStorage, modality="OT",
    )  # fmt: skip
    slopes = [(0.5 + 0.013 * z, 0) for z in range(6)]
    cases["slope_each"] = series(
        out, "slope_each", ramp((6, 8, 6), np.int16, 0, 32000), slopes=slopes, modality="PT",
        sop_class=PositronEmissionTomographyImageStorage,
    )  # fmt: skip
    cases["slope_each"]["tolerance"] = 1e-6
    cases["slope"] = series(out, "slope", ramp((6, 8, 6)), slopes=[(0.25, 3.5)] * 6, modality="MR", sop_class=MRImageStorage)
    # 12 signed bits in 16, with rubbish above them.
    signed = ramp((5, 8, 6), np.int16, -2048, 2047)
    rubbish = (signed.astype(np.uint16) & 0x0FFF) | 0x5000
    cases["signed12"] = series(out, "signed12", rubbish, stored=12, slopes=[(1, 0)] * 5, more={"PixelRepresentation": 1})
    cases["signed12"]["values"] = signed.astype(float)
    cases["high_bit"] = series(
        out, "high_bit", (ramp((5, 8, 6), np.uint16, 0, 4095) << 4) | 0x0009, stored=12, high=15, slopes=[(1, 0)] * 5,
    )  # fmt: skip
    # SimpleITK leaves the unused low bits where they are.
    cases["high_bit"]["itk"] = "geometry"
    cases["high_bit"]["values"] = ramp((5, 8, 6), np.uint16, 0, 4095).astype(float)
    cases["thick"] = series(out, "thick", ramp((4, 5, 6)), spacing=(0.5, 0.5, 5.0), thickness=7.5)
    cases["two_slices"] = series(out, "two_slices", ramp((2, 5, 6)))
    return cases


def syntaxes(out):
    cases = {}
    for name, syntax in {
        "implicit": ImplicitVRLittleEndian, "big": ExplicitVRBigEndian, "deflated": DeflatedExplicitVRLittleEndian,
        "rle": RLELossless, "j2k": JPEG2000Lossless, "jpegls": JPEGLSLossless,
    }.items():  # fmt: skip
        # The encoder of JPEG 2000 refuses small pictures.
        side = 40 if name == "j2k" else 16
        cases[name] = series(out, name, ramp((4, side, side + 1)), syntax=syntax)
        cases[name + "_u12"] = series(out, name + "_u12", ramp((3, side, side + 1), np.uint16, 0, 4095), stored=12, syntax=syntax)
        cases[name + "_u8"] = series(out, name + "_u8", ramp((3, side, side + 2), np.uint8, 0, 255), syntax=syntax)
        cases[name + "_u8"]["values"] = ramp((3, side, side + 2), np.uint8, 0, 255).astype(float) - 1024
    for name, syntax in {"bare_implicit": ImplicitVRLittleEndian, "bare_explicit": ExplicitVRLittleEndian}.items():
        cases[name] = series(out, name, ramp((3, 5, 6)), syntax=syntax, preamble=False)
        cases[name]["itk"] = False
    cases["no_endings"] = series(out, "no_endings", ramp((3, 5, 6)), file="sub/IM{:03}")
    cases["no_endings"]["itk"] = False
    return cases


def irregular(out):
    cases = {}
    whole = ramp((9, 8, 10))
    kept = [0, 1, 2, 4, 5, 7, 8]
    case = series(out, "gap", whole[kept], heights=np.array(kept) * 2.5)
    filled = whole.astype(float) - 1024
    for missing in (3, 6):
        filled[missing] = np.round((filled[missing - 1] + filled[missing + 1]) / 2)
    cases["gap"] = {**case, "values": filled, "tolerance": 0.51, "note": "2 slices are missing", "itk": False}

    linear = np.arange(5)[None, None] * 100 + np.arange(4)[None, :, None] * 10 + np.zeros((8, 1, 1))
    heights = np.array([0, 1.0, 2.1, 2.9, 4.0, 5.2, 6.0, 7.0])
    values = (linear + np.round(heights[:, None, None] * 100)).astype(np.int16)
    case = series(out, "varying", values, heights=heights, spacing=(1, 1, 1.0), slopes=[(1, 0)] * 8)
    expected = linear + np.arange(8)[:, None, None] * 100
    cases["varying"] = {**case, "values": expected, "tolerance": 0.51, "note": "resampled linearly", "itk": False}

    # A tilt of one pixel a slice: an object upright in space is slid in the pictures.
    slide = np.outer(np.arange(5), [0, 2.0, 0])
    upright = np.zeros((5, 12, 6), np.int16)
    for z in range(5):
        upright[z, 6 - z, 2] = 1000
    case = series(out, "tilt", upright, spacing=(2, 2, 3.0), slide=slide, slopes=[(1, 0)] * 5)
    straight = np.zeros((5, 16, 6))
    straight[:, 6, 2] = 1000
    cases["tilt"] = {**case, "values": straight, "note": "gantry tilt", "itk": False}

    case = series(out, "duplicate", ramp((5, 6, 7)))
    shutil.copy(next((out / "duplicate").glob("*.dcm")), out / "duplicate" / "copy.dcm")
    cases["duplicate"] = {**case, "note": "copies", "itk": False}

    case = series(out, "no_positions", ramp((5, 6, 7)))
    for file in (out / "no_positions").glob("*.dcm"):
        data = pydicom.dcmread(file)
        del data.ImagePositionPatient, data.ImageOrientationPatient
        data.InstanceNumber = 6 - data.InstanceNumber
        data.save_as(file)
    cases["no_positions"] = {**case, "orientation": None, "origin": None, "note": "SliceThickness", "itk": False}

    case = series(out, "imager", ramp((4, 6, 7)))
    for file in (out / "imager").glob("*.dcm"):
        data = pydicom.dcmread(file)
        data.ImagerPixelSpacing = data.PixelSpacing
        del data.PixelSpacing
        data.save_as(file)
    cases["imager"] = {**case, "note": "ImagerPixelSpacing", "itk": False}
    return cases


def several(out):
    cases = {}
    folder = out / "several"
    first = series(out, "several/a", ramp((4, 6, 7)), series="several a")
    second = series(out, "several/b", ramp((6, 5, 8), np.int16, 0, 99), series="several b")
    localizer = series(
        out, "several/c", ramp((2, 9, 9)), SAGITTAL, series="several b",
        more={"ImageType": ["ORIGINAL", "PRIMARY", "LOCALIZER"]},
    )  # fmt: skip
    uids = {name: uid(2, number(name)) for name in ("several a", "several b")}
    cases["several"] = {**second, "path": folder, "note": "has 2 other volumes", "itk": False}
    cases["several_by_uid"] = {**first, "path": folder, "order": {"series": uids["several a"]}, "itk": False}
    numbers = sorted([uids["several a"], uids["several b"]])
    cases["several_by_number"] = {
        **first, "path": folder, "order": {"series": str(1 if numbers[0] == uids["several a"] else 3)}, "itk": False,
    }  # fmt: skip
    cases["localizer"] = {**localizer, "path": out / "several/c", "itk": False}

    echo = [series(out, f"echoes/{e}", ramp((3, 5, 6)) + e, series="echoes", modality="MR", sop_class=MRImageStorage,
                   more={"EchoNumbers": e, "EchoTime": str(10 * e)}) for e in (1, 2)]  # fmt: skip
    cases["echo"] = {**echo[0], "path": out / "echoes", "note": "echo 2", "itk": False}
    cases["echo2"] = {**echo[1], "path": out / "echoes", "order": {"series": "2"}, "itk": False}

    times = [series(out, f"times/{t}", ramp((3, 5, 6)) + t, series="times", modality="MR", sop_class=MRImageStorage,
                    more={"TemporalPositionIdentifier": t + 1, "AcquisitionNumber": t + 1}) for t in range(3)]  # fmt: skip
    for t in range(3):
        cases[f"time{t}"] = {**times[t], "path": out / "times", "order": {"time": t}, "times": 3, "itk": False}
    return cases


def enhanced(name, values, directions=AXIAL, spacing=(0.8, 0.6, 3.0), origin=(5, -6, 7.5), **how):
    """An enhanced file; its frames are shuffled. `values` are of (time, z, y, x)."""
    data = base(name, how.get("sop_class", EnhancedCTImageStorage), how.get("modality", "CT"))
    data.SOPInstanceUID = uid(4, number(name))
    data.InstanceNumber = 1
    x, y = (np.array(d, float) for d in directions)
    normal = np.cross(x, y)
    shared = Dataset()
    measures, orientation = Dataset(), Dataset()
    measures.PixelSpacing = [text(spacing[1]), text(spacing[0])]
    measures.SliceThickness = text(spacing[2])
    orientation.ImageOrientationPatient = [text(v) for v in [*x, *y]]
    shared.PixelMeasuresSequence = Sequence([measures])
    shared.PlaneOrientationSequence = Sequence([orientation])
    slopes = how.get("slopes")
    if not slopes:
        shared.PixelValueTransformationSequence = Sequence([scaling(1, -1024)])
    times, depth = values.shape[:2]
    order = np.random.default_rng(number(name)).permutation(times * depth)
    frames = []
    for place in order:
        t, z = divmod(int(place), depth)
        group, position, content = Dataset(), Dataset(), Dataset()
        position.ImagePositionPatient = [text(v) for v in np.array(origin) + normal * z * spacing[2]]
        group.PlanePositionSequence = Sequence([position])
        content.StackID, content.InStackPositionNumber = "1", z + 1
        content.TemporalPositionIndex = t + 1
        group.FrameContentSequence = Sequence([content])
        if slopes:
            group.PixelValueTransformationSequence = Sequence([scaling(*slopes[z])])
        frames.append(group)
    data.SharedFunctionalGroupsSequence = Sequence([shared])
    data.PerFrameFunctionalGroupsSequence = Sequence(frames)
    data.NumberOfFrames = len(order)
    pixels(data, values.reshape(-1, *values.shape[2:])[order])
    slopes = slopes or [(1, -1024)] * depth
    scaled = np.stack([[values[t, z] * slopes[z][0] + slopes[z][1] for z in range(depth)] for t in range(times)])
    return data, scaled, (spacing, (x, y, normal), origin)


def scaling(slope, intercept):
    item = Dataset()
    item.RescaleSlope, item.RescaleIntercept, item.RescaleType = text(slope), text(intercept), "US"
    return item


def multi_frame(out):
    cases = {}
    for name, directions in {"enhanced": AXIAL, "enhanced_oblique": oblique()}.items():
        data, scaled, place = enhanced(name, ramp((1, 6, 7, 9)), directions)
        save(data, out / name / "a.dcm")
        cases[name] = expectation(out / name / "a.dcm", scaled[0], *place, itk=False)
    data, scaled, place = enhanced(
        "enhanced_slopes", ramp((1, 5, 7, 9), np.int16, 0, 3000), slopes=[(0.5 + z, 2) for z in range(5)],
        sop_class=EnhancedMRImageStorage, modality="MR",
    )  # fmt: skip
    save(data, out / "enhanced_slopes.dcm")
    cases["enhanced_slopes"] = expectation(out / "enhanced_slopes.dcm", scaled[0], *place, itk=False, tolerance=1e-6)
    for syntax, name in {RLELossless: "rle", JPEG2000Lossless: "j2k", ExplicitVRBigEndian: "big"}.items():
        data, scaled, place = enhanced("enhanced_" + name, ramp((3, 4, 40, 41) if name == "j2k" else (3, 4, 7, 9)))
        save(data, out / f"enhanced_{name}.dcm", syntax)
        for t in range(3):
            cases[f"enhanced_{name}_{t}"] = expectation(
                out / f"enhanced_{name}.dcm", scaled[t], *place, order={"time": t}, times=3, itk=False
            )
    # Many frames without positions.
    data = base("classic frames", SecondaryCaptureImageStorage, "NM")
    data.SOPInstanceUID = uid(4, number("classic frames"))
    data.PixelSpacing, data.SpacingBetweenSlices = ["1.5", "1.25"], "-4"
    values = ramp((5, 6, 7), np.uint16, 0, 5000)
    data.NumberOfFrames = 5
    pixels(data, values)
    save(data, out / "classic_frames.dcm")
    cases["classic_frames"] = expectation(
        out / "classic_frames.dcm", values.astype(float), (1.25, 1.5, 4), None, None, note="SpacingBetweenSlices", itk=False
    )  # fmt: skip
    # Floats.
    for name, kind in {"float": np.float32, "double": np.float64}.items():
        data = base(name, SecondaryCaptureImageStorage, "OT")
        data.SOPInstanceUID = uid(4, number(name))
        data.PixelSpacing = ["1", "1"]
        values = (ramp((1, 6, 7)).astype(kind) / 7)[0]
        pixels(data, np.zeros((6, 7), np.uint16))
        del data.PixelData, data.BitsStored, data.HighBit, data.PixelRepresentation
        data.BitsAllocated = values.itemsize * 8
        setattr(data, "FloatPixelData" if name == "float" else "DoubleFloatPixelData", values.tobytes())
        save(data, out / f"{name}.dcm")
        cases[name] = expectation(out / f"{name}.dcm", values[None].astype(float), (1, 1, 1), None, None, itk=False)
    # A dose grid.
    data = base("dose", "1.2.840.10008.5.1.4.1.1.481.2", "RTDOSE")
    data.SOPInstanceUID = uid(4, number("dose"))
    data.PixelSpacing, data.DoseGridScaling, data.NumberOfFrames = ["2", "3"], "0.001", 4
    data.ImagePositionPatient, data.ImageOrientationPatient = ["1", "2", "3"], ["1", "0", "0", "0", "1", "0"]
    data.GridFrameOffsetVector = ["0", "2.5", "5", "7.5"]
    data.FrameIncrementPointer = 0x3004000C
    values = ramp((4, 5, 6), np.uint32, 0, 80_000)
    pixels(data, values)
    save(data, out / "dose.dcm")
    cases["dose"] = expectation(
        out / "dose.dcm", values * 0.001, (3, 2, 2.5), (*map(np.array, AXIAL), np.array([0, 0, 1])), (1, 2, 3), itk=False
    )
    return cases


def colours(out):
    cases = {}
    rgb = np.stack([ramp((1, 6, 8), np.uint8, 0, 255 - 40 * c)[0] for c in range(3)], -1)
    for name, planar in {"rgb": 0, "rgb_planar": 1}.items():
        data = base(name, SecondaryCaptureImageStorage, "OT")
        data.SOPInstanceUID = uid(4, number(name))
        pixels(data, rgb[..., 0])
        data.SamplesPerPixel, data.PhotometricInterpretation, data.PlanarConfiguration = 3, "RGB", planar
        data.PixelData = (np.moveaxis(rgb, -1, 0) if planar else rgb).tobytes()
        save(data, out / f"{name}.dcm")
        for c in range(3):
            cases[f"{name}_{c}"] = expectation(
                out / f"{name}.dcm", rgb[None, ..., c].astype(float), (1, 1, 1), None, None, order={"component": c},
                components=3, itk=False,
            )  # fmt: skip
    data = base("palette", SecondaryCaptureImageStorage, "OT")
    data.SOPInstanceUID = uid(4, number("palette"))
    index = ramp((1, 6, 8), np.uint8, 0, 250)[0]
    pixels(data, index)
    data.PhotometricInterpretation = "PALETTE COLOR"
    table = np.random.default_rng(1).integers(0, 65536, (3, 200), np.uint16)
    for c, colour in enumerate(("Red", "Green", "Blue")):
        setattr(data, f"{colour}PaletteColorLookupTableDescriptor", [200, 10, 16])
        setattr(data, f"{colour}PaletteColorLookupTableData", table[c].tobytes())
    save(data, out / "palette.dcm")
    for c in range(3):
        values = table[c][np.clip(index.astype(int) - 10, 0, 199)]
        cases[f"palette_{c}"] = expectation(
            out / "palette.dcm", values[None].astype(float), (1, 1, 1), None, None, order={"component": c}, components=3,
            itk=False,
        )  # fmt: skip
    case = series(out, "inverted", ramp((3, 5, 6)), more={"PhotometricInterpretation": "MONOCHROME1"})
    # SimpleITK turns the values round.
    cases["inverted"] = {**case, "note": "zero is white", "itk": "geometry"}
    return cases


def segmentations(out):
    import highdicom as hd
    from highdicom.color import CIELabColor
    from pydicom.sr.codedict import codes

    cases = {}
    values = ramp((6, 8, 10))
    source = series(out, "seg_source", values)
    images = [pydicom.dcmread(file) for file in (out / "seg_source").glob("*.dcm")]
    for image in images:
        image.PatientSex, image.StudyTime, image.AccessionNumber, image.StudyID = "", "", "", ""
        image.ReferringPhysicianName = ""
        image.PositionReferenceIndicator = ""
        image.PatientID = "x"
    images.sort(key=lambda image: float(image.ImagePositionPatient[2]))
    describe = [
        hd.seg.SegmentDescription(
            segment_number=n, segment_label=name, segmented_property_category=codes.SCT.Organ,
            segmented_property_type=codes.SCT.Liver, algorithm_type="MANUAL",
            display_color=CIELabColor(*lab),
        )
        for n, name, lab in ((1, "liver", (54.29, 80.81, 69.89)), (2, "Gefäß", (87.82, -79.27, 80.99)))
    ]  # fmt: skip
    masks = np.zeros((6, 8, 10, 2), np.uint8)
    masks[1:3, 2:6, 2:7, 0] = 1
    masks[2:5, 4:8, 5:9, 1] = 1
    labels = np.where(masks[..., 1] == 1, 2, masks[..., 0]).astype(float)
    common = dict(
        series_instance_uid=uid(2, 77), series_number=1, sop_instance_uid=uid(4, 77), instance_number=1,
        manufacturer="m", manufacturer_model_name="n", software_versions="1", device_serial_number="1",
        segment_descriptions=describe,
    )  # fmt: skip
    kinds = {
        "seg_binary": (masks, hd.seg.SegmentationTypeValues.BINARY, {}),
        "seg_binary_sparse": (masks, hd.seg.SegmentationTypeValues.BINARY, {"omit_empty_frames": True}),
        "seg_labelmap": (labels.astype(np.uint8), hd.seg.SegmentationTypeValues.LABELMAP, {}),
    }
    for name, (array, kind, more) in kinds.items():
        file = hd.seg.Segmentation(source_images=images, pixel_array=array, segmentation_type=kind, **common, **more)
        file.save_as(out / f"{name}.dcm")
        shown = labels
        origin = list(source["origin"])
        heights = sorted({float(f.PlanePositionSequence[0].ImagePositionPatient[2]) for f in file.PerFrameFunctionalGroupsSequence})
        lowest = round((heights[0] - origin[2]) / 2.5)
        highest = round((heights[-1] - origin[2]) / 2.5)
        shown = labels[lowest : highest + 1]
        origin[2] = heights[0]
        cases[name] = {
            **source, "path": out / f"{name}.dcm", "values": shown, "origin": origin, "itk": False,
            "labels": [["liver", [255, 0, 0]], ["Gefäß", [0, 255, 0]]],
            "note": "several segments" if name != "seg_labelmap" else None,
        }  # fmt: skip
    parts = np.zeros((6, 8, 10, 2), np.float32)
    parts[..., 0] = np.linspace(0.1, 1, 480).reshape(6, 8, 10)
    parts[1:3, ..., 1] = 0.5
    file = hd.seg.Segmentation(
        source_images=images, pixel_array=parts, segmentation_type=hd.seg.SegmentationTypeValues.FRACTIONAL,
        fractional_type="PROBABILITY", max_fractional_value=200, **common,
    )  # fmt: skip
    file.save_as(out / "seg_fractional.dcm")
    expected = np.round(parts[..., 0] * 200) / 200
    cases["seg_fractional"] = {**source, "path": out / "seg_fractional.dcm", "values": expected, "itk": False, "tolerance": 0.006}
    return cases


def known_files(data):
    """Files of others: the numbers are pydicom's."""
    files = [file for folder in ("pydicom", "ami_dicom") for file in sorted((data / "formats" / folder).glob("*"))]
    # Those that pydicom carries; others it would download.
    files += sorted((Path(pydicom.__file__).parent / "data/test_files").glob("*.dcm"))
    cases = {}
    for file in files:
        try:
            found = pydicom.dcmread(file)
            if "Rows" not in found:
                continue
            cases[f"file {file.name}"] = known_file(file, found)
        except Exception as problem:  # noqa: BLE001: pydicom raises anything at broken files
            cases[f"file {file.name}"] = {"path": file, "unread": f"{type(problem).__name__}: {problem}"[:90]}
    return cases


def known_file(file, found):
    pixels = found.pixel_array
    if found.SOPClassUID in ("1.2.840.10008.5.1.4.1.1.66.4", "1.2.840.10008.5.1.4.1.1.66.7"):
        raise ValueError("a segmentation")
    colour = found.SamplesPerPixel == 3
    if found.PhotometricInterpretation == "PALETTE COLOR":
        from pydicom.pixels import apply_color_lut

        pixels, colour = apply_color_lut(pixels, found), True
    elif str(found.PhotometricInterpretation).startswith("YBR"):
        pixels = pydicom.pixels.pixel_array(found, raw=False)
    if colour:
        pixels = pixels[..., 0]
    values = pixels.reshape(-1, *pixels.shape[-2:]).astype(float)
    if "PerFrameFunctionalGroupsSequence" not in found and not colour:
        slope = float(found.get("RescaleSlope") or found.get("DoseGridScaling") or 1) or 1.0
        values = values * slope + float(found.get("RescaleIntercept") or 0)
    spacing = [float(v) for v in (found.get("PixelSpacing") or found.get("ImagerPixelSpacing") or [1, 1])]
    case = {"path": file, "values": values, "spacing": [spacing[1], spacing[0], None], "itk": False}
    case["tolerance"] = 1e-6
    if found.file_meta.TransferSyntaxUID in LOSSY:
        case["tolerance"] = 3.01
    return case


LOSSY = ("1.2.840.10008.1.2.4.50", "1.2.840.10008.1.2.4.51", "1.2.840.10008.1.2.4.91", "1.2.840.10008.1.2.4.81")

# Comparison --------------------------------------------------------------------------------------


class Program:
    def __init__(self, path):
        self.process = subprocess.Popen([path], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)

    def read(self, path, values, **order):
        self.process.stdin.write(json.dumps({"path": str(path), "values": str(values), **order}) + "\n")
        self.process.stdin.flush()
        return json.loads(self.process.stdout.readline())


def by_itk(path):
    import SimpleITK as sitk

    if path.is_dir():
        reader = sitk.ImageSeriesReader()
        uids = reader.GetGDCMSeriesIDs(str(path))
        reader.SetFileNames(reader.GetGDCMSeriesFileNames(str(path), uids[0]))
        return reader.Execute()
    return sitk.ReadImage(str(path))


def differences(case, found, values):
    out = []
    wanted = np.asarray(case["values"], float)
    dims = list(wanted.shape[::-1])
    if found["dims"] != dims:
        return [f"size {found['dims']}, not {dims}"]
    for axis, spacing in enumerate(case["spacing"]):
        if spacing is not None and abs(found["spacing"][axis] - spacing) > 1e-6 * spacing:
            out.append(f"spacing {found['spacing']}, not {case['spacing']}")
    for key, allowed in (("orientation", 1e-6), ("origin", 1e-5)):
        if key in case:
            a, b = found[key], case[key]
            if (a is None) != (b is None) or a is not None and np.abs(np.array(a) - np.array(b)).max() > allowed:
                out.append(f"{key} {a}, not {b}")
    apart = np.abs(values.reshape(wanted.shape) - wanted)
    allowed = case.get("tolerance", 0) * (1 if case.get("tolerance", 0) > 1e-3 else np.abs(wanted).max())
    if not apart.max() <= allowed + 1e-9:
        out.append(f"{int((apart > allowed + 1e-9).sum())} of {apart.size} values differ, by {apart.max():.6g} at most")
    for key in ("times", "components"):
        if found[key] != case.get(key, found[key]):
            out.append(f"{key} {found[key]}, not {case[key]}")
    notes = " | ".join(found["notes"])
    if case.get("note") and case["note"] not in notes:
        out.append(f"no note of `{case['note']}`: {notes}")
    if any(word in notes.lower() for word in ("secret", "1901", "2001")):
        out.append(f"a note tells who it is: {notes}")
    if "labels" in case:
        got = [[label["name"], label["colour"]] for label in found["labels"] or [] if label["value"] > 0]
        near = len(got) == len(case["labels"]) and all(
            a[0] == b[0] and np.abs(np.array(a[1], int) - b[1]).max() <= 3 for a, b in zip(got, case["labels"])
        )
        if not near:
            out.append(f"labels {got}, not {case['labels']}")
    return out


def itk_differences(case, found, values):
    import SimpleITK as sitk

    image = by_itk(case["path"])
    out = []
    if list(image.GetSize()) != found["dims"]:
        return [f"ITK: size {image.GetSize()}"]
    theirs = (
        ("spacing", np.array(image.GetSpacing()), np.array(found["spacing"]), 1e-5),
        ("origin", np.array(image.GetOrigin()), np.array(found["origin"]), 1e-4),
        ("orientation", np.array(image.GetDirection()).reshape(3, 3), np.array(found["orientation"]), 1e-5),
    )
    for name, a, b, allowed in theirs:
        if np.abs(a - b).max() > allowed:
            out.append(f"ITK: {name} {a.tolist()}, ours {b.tolist()}")
    apart = np.abs(sitk.GetArrayFromImage(image).astype(float) - values.reshape(found["dims"][::-1]))
    if case.get("itk") != "geometry" and apart.max() > 1e-6 * max(1, np.abs(values).max()):
        out.append(f"ITK: {int((apart > 0).sum())} values differ, by {apart.max():.6g} at most")
    return out


KINDS = {
    plain_series: "series of slices", syntaxes: "transfer syntaxes", irregular: "gaps, tilt, uneven distances",
    several: "several series, times and echoes in a folder", multi_frame: "enhanced and classic multi-frame",
    colours: "colours and palettes", segmentations: "segmentations (SEG)",
}  # fmt: skip
SYNTAXES = {
    "implicit": "implicit VR", "big": "big-endian", "deflated": "deflated", "rle": "RLE", "j2k": "JPEG 2000", "jpegls": "JPEG-LS",
    "bare": "without preamble", "no": "names without endings",
}  # fmt: skip

# What is refused on purpose; JPEG-LS only without its cargo feature.
REFUSALS = ("JPEG-LS", "lossy with 12 bits")


def all_cases(out, data):
    cases = {}
    for maker, kind in KINDS.items():
        for name, case in maker(out).items():
            said = SYNTAXES[name.split("_")[0]] if maker is syntaxes else kind
            cases[name] = {**case, "kind": f"DICOM, {said}"}
    if data:
        cases.update({name: {**case, "kind": "DICOM, files of others"} for name, case in known_files(data).items()})
    return cases


def compare(program, data, out):
    shutil.rmtree(out, ignore_errors=True)
    program, kept = Program(program), out / "values.bin"
    agree = itk_agree = itk_all = compared = 0
    summary = Summary()
    for name, case in all_cases(out, data).items():
        kept.unlink(missing_ok=True)
        found = program.read(case["path"], kept, **case.get("order", {}))
        if "unread" in case:
            print(f"unread   {name}: pydicom says {case['unread']}; ours {found.get('error', found.get('dims'))}")
            continue
        compared += 1
        if "error" in found:
            print(f"refused  {name}: {found['error'].replace(str(case['path']), '')}")
            is_meant = any(reason in found["error"] for reason in REFUSALS)
            summary.add(case["kind"], "pydicom", "refused" if is_meant else "differ")
            continue
        values = np.fromfile(kept, "<f8")
        apart = differences(case, found, values)
        agree += not apart
        library = "pydicom"
        if case.get("itk", True) and found["origin"] is not None:
            library = "pydicom, SimpleITK"
            itk_all += 1
            with_itk = itk_differences(case, found, values)
            itk_agree += not with_itk
            apart += with_itk
        summary.add(case["kind"], library, "differ" if apart else "agree")
        print(f"{'agrees ' if not apart else 'DIFFERS'}  {name} {'; '.join(apart)}")
    summary.print()
    print(f"{compared} compared with pydicom, {agree} agree; {itk_all} compared with SimpleITK, {itk_agree} agree")


def references():
    """Small files for the tests of the repository, and what they hold."""
    shutil.rmtree(FILES, ignore_errors=True)
    cases = all_cases(FILES, None)
    keep = [
        "oblique", "unsigned12", "slope_each", "signed12", "high_bit", "implicit_u8", "big_u12", "deflated_u12", "rle_u12",
        "j2k_u12", "bare_implicit", "gap", "varying", "tilt", "no_positions", "several_by_number", "time1", "echo2",
        "enhanced_oblique", "enhanced_slopes", "enhanced_rle_2", "classic_frames", "double", "dose", "rgb_planar_1",
        "palette_2", "seg_binary", "seg_labelmap", "seg_fractional",
    ]  # fmt: skip
    entries, used = {}, set()
    for name in keep:
        case = cases[name]
        values = np.asarray(case["values"], float)
        used.add(case["path"])
        entries[name] = {
            "path": case["path"].relative_to(FILES).as_posix(),
            "order": case.get("order", {}),
            "dims": list(values.shape[::-1]),
            "spacing": case["spacing"],
            "orientation": case["orientation"],
            "origin": case["origin"],
            "tolerance": case.get("tolerance", 0),
            "sum": float(values.sum()),
            # A sum in which every voxel has a weight of its own.
            "weighted": float((values.ravel() * (np.arange(values.size) % 977 + 1)).sum()),
            "note": case.get("note"),
            "labels": case.get("labels"),
        }
    for file in sorted(FILES.rglob("*"), reverse=True):
        if file.is_dir():
            if not any(file.iterdir()):
                file.rmdir()
        elif not any(file == path or path in file.parents for path in used):
            file.unlink()
    lines = (f"{json.dumps(name)}: {json.dumps(entry)}" for name, entry in entries.items())
    (FILES / "dicom.json").write_text("{\n" + ",\n".join(lines) + "\n}\n")
    size = sum(file.stat().st_size for file in FILES.rglob("*") if file.is_file())
    print(f"{len(entries)} entries, {size} bytes")


if __name__ == "__main__":
    if sys.argv[1:] == ["references"]:
        references()
    elif len(sys.argv) == 5 and sys.argv[1] == "compare":
        compare(Path(sys.argv[2]), Path(sys.argv[3]), Path(sys.argv[4]).resolve())
    else:
        sys.exit(__doc__)

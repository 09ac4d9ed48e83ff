#!/usr/bin/env python3
"""Marching every pixel: this program against VTK, on the same volume, camera, transfer function and step.

Unshaded: vtkFixedPointVolumeRayCastMapper with the same number of threads.
Shadows:  vtkGPUVolumeRayCastMapper with GlobalIlluminationReach 1 and no scattering, on software OpenGL.

    python3 -m venv venv && venv/bin/pip install vtk numpy pillow
    cargo build --release
    venv/bin/python benchmarks/peers/vtk_march.py [--threads 2] [--rounds 5] [-o DIR]

The rounds alternate between the programs, so that a slow moment of the machine meets both. Medians and
ratios go to vtk_march.json, the pictures side by side to vtk_*.png.
"""

import argparse
import json
import os
import platform
import statistics
import subprocess
import tempfile
import time
from pathlib import Path

import numpy as np
import vtk
from PIL import Image
from vtk.util import numpy_support

ROOT = Path(__file__).resolve().parents[2]
SIZE = (1280, 720)
SIDE = 256
STEP = 0.5
CAMERA = [0.75, 0.65, 1.6, 0.0, 0.0, 0.0, 35.0]
LIGHT = [0.5, 1.0, 0.3]
AMBIENT = 0.3

# Name, procedural volume, transfer function (v, r, g, b, opacity per voxel), shadows.
OPAQUE_CT = [[0, 0, 0, 0, 0], [0.2, 0.8, 0.5, 0.4, 0], [0.32, 0.9, 0.6, 0.45, 0.25], [0.5, 1, 0.9, 0.8, 0.9], [1, 1, 1, 1, 0.95]]
SMOKE = [[0, 0, 0, 0, 0], [0.05, 0.6, 0.6, 0.65, 0.0], [0.5, 0.8, 0.8, 0.8, 0.03], [1, 1, 1, 1, 0.08]]
SEE_THROUGH = [[0, 0.1, 0.1, 0.3, 0.0], [0.1, 0.2, 0.4, 0.8, 0.002], [0.5, 0.9, 0.6, 0.3, 0.02], [1, 1, 1, 1, 0.3]]
CASES = [
    ("ct unshaded", "head", OPAQUE_CT, False),
    ("see-through unshaded", "head", SEE_THROUGH, False),
    ("smoke unshaded", "plume", SMOKE, False),
    ("ct shadows", "head", OPAQUE_CT, True),
    ("smoke shadows", "plume", SMOKE, True),
]


def fovolnet(*arguments):
    return subprocess.run([ROOT / "target/release/fovolnet", *map(str, arguments)], check=True, capture_output=True, text=True).stdout


def make_volume(name, folder):
    """A 256³ u8 volume as a raw file, the same bytes for both programs."""
    made = folder / f"{name}.nrrd"
    fovolnet("data", "make", name, made, "--dims", f"{SIDE},{SIDE},{SIDE}")
    text, _, body = made.read_bytes().partition(b"\n\n")
    kind = {b"int16": "<i2", b"short": "<i2", b"float": "<f4", b"uint8": "u1", b"uchar": "u1", b"unsigned char": "u1"}
    dtype = next(kind[line.split(b":")[1].strip()] for line in text.splitlines() if line.startswith(b"type:"))
    values = np.frombuffer(body, dtype).astype(np.float64)
    low, high = values.min(), values.max()
    data = np.round((values - low) / (high - low) * 255).astype(np.uint8).reshape(SIDE, SIDE, SIDE)
    path = folder / f"{name}_{SIDE}x{SIDE}x{SIDE}_uint8.raw"
    data.tofile(path)
    return path, data


class Vtk:
    def __init__(self, data, points, shadows, threads):
        image = vtk.vtkImageData()
        image.SetDimensions(SIDE, SIDE, SIDE)
        voxel = 1.0 / SIDE
        image.SetSpacing(voxel, voxel, voxel)
        image.SetOrigin(*[-0.5 + 0.5 * voxel] * 3)
        image.GetPointData().SetScalars(numpy_support.numpy_to_vtk(data.ravel(), deep=True))
        colour, opacity = vtk.vtkColorTransferFunction(), vtk.vtkPiecewiseFunction()
        for v, r, g, b, a in points:
            colour.AddRGBPoint(255 * v, r, g, b)
            opacity.AddPoint(255 * v, a)
        prop = vtk.vtkVolumeProperty()
        prop.SetColor(colour)
        prop.SetScalarOpacity(opacity)
        prop.SetScalarOpacityUnitDistance(voxel)
        prop.SetInterpolationTypeToLinear()
        if shadows:
            prop.ShadeOn()
            prop.SetAmbient(AMBIENT)
            prop.SetDiffuse(1 - AMBIENT)
            prop.SetSpecular(0)
            mapper = vtk.vtkGPUVolumeRayCastMapper()
            mapper.SetGlobalIlluminationReach(1.0)
            mapper.SetVolumetricScatteringBlending(0.0)
            mapper.SetUseJittering(False)
            mapper.SetAutoAdjustSampleDistances(False)
        else:
            prop.ShadeOff()
            mapper = vtk.vtkFixedPointVolumeRayCastMapper()
            mapper.SetNumberOfThreads(threads)
            mapper.SetAutoAdjustSampleDistances(False)
            mapper.SetInteractiveSampleDistance(STEP * voxel)
            mapper.IntermixIntersectingGeometryOff()
        mapper.SetSampleDistance(STEP * voxel)
        mapper.SetImageSampleDistance(1.0)
        mapper.SetInputData(image)
        volume = vtk.vtkVolume()
        volume.SetMapper(mapper)
        volume.SetProperty(prop)
        self.renderer = vtk.vtkRenderer()
        self.renderer.SetBackground(0, 0, 0)
        self.renderer.AddVolume(volume)
        self.renderer.RemoveAllLights()
        self.renderer.AutomaticLightCreationOff()
        light = vtk.vtkLight()
        light.SetLightTypeToSceneLight()
        light.SetPositional(False)
        light.SetPosition(*[10 * c for c in LIGHT])
        light.SetFocalPoint(0, 0, 0)
        self.renderer.AddLight(light)
        self.window = vtk.vtkRenderWindow()
        self.window.SetOffScreenRendering(True)
        self.window.SetMultiSamples(0)
        self.window.SetSize(*SIZE)
        self.window.AddRenderer(self.renderer)
        camera = self.renderer.GetActiveCamera()
        camera.SetPosition(*CAMERA[:3])
        camera.SetFocalPoint(*CAMERA[3:6])
        camera.SetViewUp(0, 1, 0)
        camera.SetViewAngle(CAMERA[6])
        self.renderer.ResetCameraClippingRange()
        self.window.Render()

    def render(self):
        """One frame; milliseconds."""
        # A camera that has moved (imperceptibly) is rendered anew.
        self.renderer.GetActiveCamera().Azimuth(1e-5)
        started = time.perf_counter()
        self.window.Render()
        self.window.WaitForCompletion()
        return 1e3 * (time.perf_counter() - started)

    def picture(self):
        grab = vtk.vtkWindowToImageFilter()
        grab.SetInput(self.window)
        grab.ReadFrontBufferOff()
        grab.Update()
        image = grab.GetOutput()
        pixels = numpy_support.vtk_to_numpy(image.GetPointData().GetScalars())
        return pixels.reshape(SIZE[1], SIZE[0], -1)[::-1, :, :3]


def ours(volume, tf, shadows, options, simd, picture):
    arguments = [
        "bench", "march", volume, "--size", f"{SIZE[0]}x{SIZE[1]}", "--camera", ",".join(map(str, CAMERA)), "--tf", tf,
        "--step", STEP, "--light", ",".join(map(str, LIGHT)), "--ambient", AMBIENT, "--integration", "plain",
        # VTK shades by the gradient wherever it casts shadows.
        *(["--shadows", "on", "--shading", "gradient"] if shadows else ["--shadows", "off"]),
        "--threads", options.threads, "--simd", simd, "--repeats", 3, "--picture", picture, "--json", "-",
    ]
    report = json.loads(fovolnet(*arguments))
    return report, next(row for row in report["rows"] if row["skip_empty"])


def compare(name, volume, data, tf, points, shadows, options):
    peer = Vtk(data, points, shadows, options.threads)
    times = {"vtk": []}
    rows = {}
    picture = options.output / f"vtk_{name.replace(' ', '_')}.png"
    for _ in range(options.rounds):
        times["vtk"].append(peer.render())
        for simd in options.simd:
            report, row = ours(volume, tf, shadows, options, simd, picture)
            times.setdefault(simd, []).append(row["median_ms"])
            rows[simd] = row
    mine, theirs = np.asarray(Image.open(picture).convert("RGB")), peer.picture()
    Image.fromarray(np.hstack([mine, theirs])).save(picture)
    error = np.mean((mine.astype(float) - theirs.astype(float)) ** 2)
    result = {"case": name, "vtk_ms": statistics.median(times["vtk"]), "psnr_between_pictures": float(10 * np.log10(255**2 / max(error, 1e-9)))}
    print(f"{name:<22} VTK {result['vtk_ms']:9.1f} ms   pictures {result['psnr_between_pictures']:.1f} dB apart")
    for simd in options.simd:
        ms = statistics.median(times[simd])
        row = rows[simd]
        result[simd] = {"ms": ms, "ratio": result["vtk_ms"] / ms, "primary": row["primary_samples"], "shadow": row["shadow_samples"],
                        "million_samples_per_s": (row["primary_samples"] + row["shadow_samples"]) / ms / 1e3}
        print(f"    {simd:<8} {ms:9.1f} ms   {result[simd]['ratio']:6.1f} times faster   {result[simd]['million_samples_per_s']:.0f} Msamples/s")
    return result, report["machine"]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--simd", nargs="+", default=["avx512", "avx2"])
    parser.add_argument("--only", default="", help="cases whose names contain this")
    parser.add_argument("-o", "--output", type=Path, default=ROOT / "out/peers")
    options = parser.parse_args()
    options.output.mkdir(parents=True, exist_ok=True)
    os.environ.setdefault("LP_NUM_THREADS", str(options.threads))
    vtk.vtkMultiThreader.SetGlobalMaximumNumberOfThreads(options.threads)
    vtk.vtkObject.GlobalWarningDisplayOff()
    results, machine = [], None
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        volumes = {}
        for name, kind, points, shadows in CASES:
            if options.only not in name:
                continue
            if kind not in volumes:
                volumes[kind] = make_volume(kind, folder)
            volume, data = volumes[kind]
            tf = folder / f"{name.replace(' ', '_')}.json"
            tf.write_text(json.dumps({"points": points}))
            result, machine = compare(name, volume, data, tf, points, shadows, options)
            results.append(result)
    out = {"vtk": vtk.vtkVersion().GetVTKVersion(), "python": platform.python_version(), "machine": machine, "size": SIZE,
           "volume": [SIDE] * 3, "step": STEP, "rounds": options.rounds, "date": time.strftime("%Y-%m-%d"), "results": results}
    (options.output / "vtk_march.json").write_text(json.dumps(out, indent=1) + "\n")


if __name__ == "__main__":
    main()

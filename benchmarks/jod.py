#!/usr/bin/env python3
"""JOD of reconstructed fly-throughs at constant densities, by FovVideoVDP's own program.

    pip install numpy pillow pyfvvdp==1.2.2
    python benchmarks/jod.py VOLUME[@TF] [VOLUME[@TF] ...] -o FOLDER [--frames 50] [--densities 0.1,0.07,0.03,0.01]
        [--methods network,linear]

Renders a fly-through of each volume at 1280x720 with shadows and without a fovea, sampled at each density, and compares
what the network, pull-push and linear interpolation make of it with the full frames, as a video at 30 frames a second
on the display standard_4k, not foveated: 10 is no difference, 9 one that three of four people see. Every volume and
density is a line of FOLDER/jod.csv. FovVideoVDP is licensed for non-commercial use.
"""

import shutil

import numpy as np
import pyfvvdp
import torch
from PIL import Image

import flythroughs
from flythroughs import METHODS, run, volume, write_rows


def video(folder, name, count):
    """Pictures of `folder` as FovVideoVDP takes them: rows, columns, colours, frames."""
    frames = [np.asarray(Image.open(folder / f"{name}_{t:04}.png").convert("RGB")) for t in range(count)]
    return np.stack(frames, axis=-1)


def rendered(options, arguments, density, method):
    """The frames that `method` makes of samples of this density."""
    how = ["--reconstruct", "wnet", "--weights", options.weights] if method == "network" else ["--reconstruct", method]
    return frames_of(options, arguments, "frame", "--pb", density, "--sigma", "0", *how)


def frames_of(options, arguments, name, *how):
    """The pictures called `name` of a fly-through rendered so."""
    folder = options.output / "frames"
    run(
        options.program, "render", *arguments, "--size", options.size, "--frames", options.frames, "--path", "flythrough",
        "--integration", "plain",
        *how, "--keep", name, "-o", folder,
    )
    pictures = video(folder, name, options.frames)
    shutil.rmtree(folder)
    return pictures


def main():
    defaults = {"weights": "wnet-fast", "densities": "0.1,0.07,0.03,0.01", "methods": ",".join(METHODS)}
    options = flythroughs.options(__doc__, 50, **defaults)
    methods = options.methods.split(",")
    metric = pyfvvdp.fvvdp(display_name="standard_4k", foveated=False, device=torch.device("cpu"))
    rows = []
    for given in options.volumes:
        name, transfer, arguments = volume(given)
        full = frames_of(options, arguments, "reference", "--pb", "1")
        for density in options.densities.split(","):
            row = {"volume": name, "tf": transfer, "density": density}
            for method in methods:
                pictures = rendered(options, arguments, density, method)
                jod, _ = metric.predict(pictures, full, dim_order="HWCF", frames_per_second=30)
                row[method] = round(float(jod), 3)
            rows.append(row)
            print(row, flush=True)
            write_rows(options.output / "jod.csv", rows)
    for density in options.densities.split(","):
        of = [row for row in rows if row["density"] == density]
        means = {method: float(np.mean([row[method] for row in of])) for method in methods}
        print(density, " ".join(f"{method} {jod:.3f}" for method, jod in means.items()))


if __name__ == "__main__":
    main()

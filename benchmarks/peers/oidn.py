#!/usr/bin/env python3
"""Intel's Open Image Denoise after filling, beside the network: what a general denoiser makes of sparse frames.

    pip install numpy pillow scikit-image pyoidn
    python benchmarks/peers/oidn.py VOLUME[@TF] [VOLUME[@TF] ...] -o FOLDER [--frames 12] [--size 1280x720]

Renders a fly-through of each volume as `benchmarks/quality.py` does and gives OIDN the frames that pull-push and linear
interpolation filled. Every volume and method is a line of FOLDER/oidn.csv: PSNR, SSIM and tPSNR over foreground pixels
from the ninth frame on, and the median time of OIDN alone, on all cores.
"""

import statistics
import sys
import time
from pathlib import Path

import numpy as np
import pyoidn

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
import flythroughs  # noqa: E402
from flythroughs import METHODS, volume, write_rows  # noqa: E402
from quality import FIRST, picture, rendered, scores  # noqa: E402

QUALITIES = {"fast": pyoidn.OIDN_QUALITY_FAST, "high": pyoidn.OIDN_QUALITY_HIGH}


def denoised(frames, quality):
    """The frames after OIDN, and how many milliseconds the median of them took."""
    device = pyoidn.Device()
    device.commit()
    color = np.ascontiguousarray(frames[0], np.float32)
    output = np.zeros_like(color)
    height, width, _ = color.shape
    denoiser = pyoidn.Filter(device)
    denoiser.set_image(pyoidn.OIDN_IMAGE_COLOR, color, pyoidn.OIDN_FORMAT_FLOAT3, width, height)
    denoiser.set_image(pyoidn.OIDN_IMAGE_OUTPUT, output, pyoidn.OIDN_FORMAT_FLOAT3, width, height)
    denoiser.set_bool("srgb", True)
    denoiser.set_quality(quality)
    denoiser.commit()
    out, times = [], []
    for frame in frames:
        color[:] = frame
        started = time.perf_counter()
        denoiser.execute()
        times.append(1e3 * (time.perf_counter() - started))
        if problem := device.get_error():
            sys.exit(f"OIDN: {problem}")
        out.append(np.clip(output.astype(np.float64), 0, 1))
    return out, statistics.median(times)


def main():
    options = flythroughs.options(__doc__, 12, weights="wnet-fast", precision="auto")
    rows = []
    for given in options.volumes:
        title, _, arguments = volume(given)
        folders = rendered(options, arguments, options.output / title)
        numbers = range(FIRST, options.frames)
        references = [picture(folders["network"] / f"reference_{t:04}.png") for t in numbers]
        for method in METHODS:
            frames = [picture(folders[method] / f"frame_{t:04}.png") for t in numbers]
            made = [(method, frames, None)]
            if method != "network":
                made += [(f"{method}, OIDN {name}", *denoised(frames, quality)) for name, quality in QUALITIES.items()]
            for name, frames, ms in made:
                psnr, ssim, tpsnr = scores(frames, references)
                row = {"volume": title, "method": name, "PSNR": round(psnr, 2), "SSIM": round(ssim, 4)}
                row |= {"tPSNR": round(tpsnr, 2), "OIDN ms": "" if ms is None else round(ms, 1)}
                rows.append(row)
                print(row, flush=True)
        write_rows(options.output / "oidn.csv", rows)


if __name__ == "__main__":
    main()

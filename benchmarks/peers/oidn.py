#!/usr/bin/env python3
"""Intel's Open Image Denoise after filling, beside the network: what a general denoiser makes of sparse frames.

    pip install numpy pillow scikit-image pyoidn OpenEXR
    python benchmarks/peers/oidn.py VOLUME[@TF] [VOLUME[@TF] ...] -o FOLDER [--frames 12] [--size 1280x720]

Renders a fly-through of each volume as `benchmarks/quality.py` does and gives OIDN the frames that pull-push and linear
interpolation filled. With the guide of the light ratio as its albedo, it also gets the frames of linear interpolation, of
colours and of light ratios. Every volume and method is a line of FOLDER/oidn.csv: PSNR, SSIM and tPSNR over foreground pixels
from the ninth frame on, and the median time of OIDN alone, on all cores.
"""

import statistics
import sys
import time
from pathlib import Path

import numpy as np
import OpenEXR
import pyoidn

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
import flythroughs  # noqa: E402
from flythroughs import METHODS, run, volume, write_rows  # noqa: E402
from quality import FIRST, picture, rendered, scores  # noqa: E402

QUALITIES = {"fast": pyoidn.OIDN_QUALITY_FAST, "high": pyoidn.OIDN_QUALITY_HIGH}


def with_guide(options, arguments, folder):
    """The folder of frames whose light ratios were filled by linear interpolation, and of their guides."""
    run(options.program, "render", *arguments, "--size", options.size, "--frames", options.frames, "--path", "flythrough",
        "--integration", "plain", "--pb", "0.03", "--sigma", "0.02", "--reconstruct", "linear", "--guide", "quarter",
        "--density", "adaptive", "--keep", "frame,guide", "-o", folder)
    return folder


def guide(file):
    """Colours without shadows, rows by columns by red, green and blue."""
    return np.ascontiguousarray(OpenEXR.File(str(file)).channels()["RGBA"].pixels[:, :, :3], np.float32)


def denoised(frames, quality, guides=None):
    """The frames after OIDN, and how many milliseconds the median of them took. `guides` are its auxiliary pictures."""
    device = pyoidn.Device()
    device.commit()
    color = np.ascontiguousarray(frames[0], np.float32)
    output = np.zeros_like(color)
    height, width, _ = color.shape
    denoiser = pyoidn.Filter(device)
    denoiser.set_image(pyoidn.OIDN_IMAGE_COLOR, color, pyoidn.OIDN_FORMAT_FLOAT3, width, height)
    denoiser.set_image(pyoidn.OIDN_IMAGE_OUTPUT, output, pyoidn.OIDN_FORMAT_FLOAT3, width, height)
    if guides:
        albedo = np.ascontiguousarray(guides[0])
        denoiser.set_image(pyoidn.OIDN_IMAGE_ALBEDO, albedo, pyoidn.OIDN_FORMAT_FLOAT3, width, height)
    denoiser.set_bool("srgb", True)
    denoiser.set_quality(quality)
    denoiser.commit()
    out, times = [], []
    for number, frame in enumerate(frames):
        color[:] = frame
        if guides:
            albedo[:] = guides[number]
        started = time.perf_counter()
        denoiser.execute()
        times.append(1e3 * (time.perf_counter() - started))
        if problem := device.get_error():
            sys.exit(f"OIDN: {problem}")
        out.append(np.clip(output.astype(np.float64), 0, 1))
    return out, statistics.median(times)


def main():
    options = flythroughs.options(
        __doc__, 12, weights="wnet-fast", precision="auto", reconstruct="wnet", guide="auto", density="auto", shadow_rays="exact"
    )
    rows = []
    for given in options.volumes:
        title, _, arguments = volume(given)
        folders = rendered(options, arguments, options.output / title)
        numbers = range(FIRST, options.frames)
        guided = with_guide(options, arguments, options.output / title / "guided")
        guides = [guide(guided / f"guide_{t:04}.exr") for t in numbers]
        folders |= {"ratio linear": guided}
        references = [picture(folders["network"] / f"reference_{t:04}.png") for t in numbers]
        for method in [*METHODS, "ratio linear"]:
            frames = [picture(folders[method] / f"frame_{t:04}.png") for t in numbers]
            made = [(method, frames, None)]
            if method != "network":
                made += [(f"{method}, OIDN {name}", *denoised(frames, quality)) for name, quality in QUALITIES.items()]
            if "linear" in method:
                high = denoised(frames, QUALITIES["high"], guides)
                made.append((f"{method}, OIDN high with guide", *high))
            for name, frames, ms in made:
                psnr, ssim, tpsnr = scores(frames, references)
                row = {"volume": title, "method": name, "PSNR": round(psnr, 2), "SSIM": round(ssim, 4)}
                row |= {"tPSNR": round(tpsnr, 2), "OIDN ms": "" if ms is None else round(ms, 1)}
                rows.append(row)
                print(row, flush=True)
        write_rows(options.output / "oidn.csv", rows)


if __name__ == "__main__":
    main()

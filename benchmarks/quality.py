#!/usr/bin/env python3
"""How much better a network is than filling without one, on volumes that it has not learned from.

    pip install numpy pillow scikit-image
    python benchmarks/quality.py --weights FILE.safetensors VOLUME[@TF] [VOLUME[@TF] ...] -o FOLDER [--frames 16]

Renders a fly-through of each volume with shadows at 1280x720, sampled at (P_b, sigma) = (0.03, 0.02), reconstructs it
with the network, with pull-push and with linear interpolation, and compares all three with the full frames, over the
pixels that show something, from the ninth frame on: PSNR of all of them together, SSIM (Gaussian window, standard
deviation 1.5) as the mean of its map, tPSNR of the differences between frames. Every volume is a line of
FOLDER/quality.csv; FOLDER/VOLUME.png shows the last frame: sparse, pull-push, network, full, and four times the error
of the network; above the whole frame, then a part where the eye looks, then one where it does not.
"""

import numpy as np
from PIL import Image
from skimage.metrics import structural_similarity

import flythroughs
from flythroughs import METHODS, run, volume, write_rows

FIRST = 8


def picture(path):
    """Red, green and blue as 0 to 1."""
    return np.asarray(Image.open(path).convert("RGB"), dtype=np.float64) / 255


def rendered(options, arguments, folder):
    """The folders of each method's frames; the first one has the full and the sparse frames too."""
    folders = {method: folder / method for method in METHODS}
    common = [options.program, "render", *arguments, "--size", options.size, "--frames", options.frames]
    common += ["--path", "flythrough", "--integration", "plain", "--pb", "0.03", "--sigma", "0.02"]
    network = ["--reconstruct", options.reconstruct, "--weights", options.weights]
    network += ["--precision", options.precision, "--guide", options.guide, "--density", options.density]
    network += ["--shadow-rays", options.shadow_rays]
    run(*common, *network, "--keep", "frame,sparse,reference", "-o", folders["network"])
    for method in METHODS[1:]:
        run(*common, "--reconstruct", method, "-o", folders[method])
    return folders


def decibels(errors):
    """The peak signal-to-noise ratio of squared errors."""
    return float(-10 * np.log10(max(np.mean(np.concatenate(errors)), 1e-12)))


def luminance(colours):
    """The mean of sRGB values, weighed as Rec. 709 does."""
    return float((colours @ [0.2126, 0.7152, 0.0722]).mean())


def scores(frames, references):
    """PSNR, SSIM and tPSNR over what the references show."""
    squares, steps, similar = [], [], []
    for t, (frame, reference) in enumerate(zip(frames, references)):
        shown = np.abs(reference - reference[0, 0]).max(axis=2) > 1.5 / 255
        squares.append(((frame - reference) ** 2)[shown].ravel())
        _, similarity = structural_similarity(
            reference, frame, channel_axis=2, data_range=1, gaussian_weights=True, sigma=1.5,
            use_sample_covariance=False, full=True,
        )
        similar.append(similarity[shown].mean())
        if t > 0:
            step = (frame - frames[t - 1]) - (reference - references[t - 1])
            steps.append((step**2)[shown].ravel())
    return decibels(squares), float(np.mean(similar)), decibels(steps)


def enlarged(part, size):
    """A part of a picture at `size`, columns and rows, with its pixels to be seen."""
    return np.asarray(Image.fromarray((part * 255).astype(np.uint8)).resize(size, Image.NEAREST))


def comparison(folders, name, number, references, frames, path):
    """The last frame of all, side by side: whole, where the eye looks, and the most detailed part elsewhere."""
    sparse = picture(folders["network"] / f"sparse_{number:04}.png")
    error = np.clip(4 * np.abs(frames["network"][-1] - references[-1]), 0, 1)
    shown = [sparse, frames["pull-push"][-1], frames["network"][-1], references[-1], error]
    height, width, _ = references[-1].shape
    part = (height // 6, width // 12)
    detail = np.abs(references[-1] - references[-1].mean(axis=(0, 1))).sum(axis=2)
    eye = ((height - part[0]) // 2, (width - part[1]) // 2)
    blocks = [
        (y, x)
        for y in range(0, height - part[0], part[0] // 2)
        for x in range(0, width - part[1], part[1] // 2)
        if abs(y - eye[0]) > part[0] or abs(x - eye[1]) > part[1]
    ]
    elsewhere = max(blocks, key=lambda at: detail[at[0] : at[0] + part[0], at[1] : at[1] + part[1]].sum())
    size = (width // 4, height // 4)
    small = [Image.fromarray((p * 255).astype(np.uint8)).resize(size) for p in shown]
    lines = [np.concatenate([np.asarray(p) for p in small], axis=1)]
    for y, x in [eye, elsewhere]:
        parts = [enlarged(p[y : y + part[0], x : x + part[1]], (size[0], 2 * size[1])) for p in shown]
        lines.append(np.concatenate(parts, axis=1))
    Image.fromarray(np.concatenate(lines, axis=0)).save(path / f"{name}.png")


def main():
    options = flythroughs.options(__doc__, 16, precision="f32", reconstruct="wnet", guide="auto", density="auto", shadow_rays="exact")
    rows = []
    for given in options.volumes:
        title, transfer, arguments = volume(given)
        folders = rendered(options, arguments, options.output / title)
        numbers = range(FIRST, options.frames)
        references = [picture(folders["network"] / f"reference_{t:04}.png") for t in numbers]
        frames = {m: [picture(folders[m] / f"frame_{t:04}.png") for t in numbers] for m in METHODS}
        shown = np.abs(references[-1] - references[-1][0, 0]).max(axis=2) > 1.5 / 255
        row = {"volume": title, "tf": transfer, "luminance": round(luminance(references[-1][shown]), 3)}
        for method in METHODS:
            psnr, ssim, tpsnr = scores(frames[method], references)
            row |= {f"{method} PSNR": round(psnr, 2), f"{method} SSIM": round(ssim, 4)}
            row |= {f"{method} tPSNR": round(tpsnr, 2)}
        for measure in ["PSNR", "tPSNR"]:
            best = max(row[f"{method} {measure}"] for method in METHODS[1:])
            row[f"gain {measure}"] = round(row[f"network {measure}"] - best, 2)
        best = max(row[f"{method} SSIM"] for method in METHODS[1:])
        row["share of 1 - SSIM"] = round((1 - row["network SSIM"]) / (1 - best), 3)
        comparison(folders, title, options.frames - 1, references, frames, options.output)
        rows.append(row)
        print(row, flush=True)
        write_rows(options.output / "quality.csv", rows)
    for measure in ["gain PSNR", "gain tPSNR", "share of 1 - SSIM"]:
        print(f"mean {measure}: {np.mean([row[measure] for row in rows]):.3f}")


if __name__ == "__main__":
    main()

"""Expected values of FovVideoVDP, from its published program (licensed for non-commercial use).

    pip install numpy torch scikit-image pytorch-msssim pyfvvdp==1.2.2
    python fvvdp.py > fvvdp.json

The clips are integer formulas, so that the Rust test makes the same ones, bit by bit.
"""

import itertools
import json

import numpy as np
import pyfvvdp
import torch

from metrics import noise, triangle

# Width, height, frames, frames a second (0: a picture), display, gaze in pixels.
CLIPS = [
    (64, 48, 1, 0, "standard_4k", None),
    (160, 120, 1, 0, "standard_hmd", None),
    (160, 120, 1, 0, "standard_4k", (40, 100)),
    (128, 72, 8, 30, "standard_4k", None),
    (96, 128, 6, 30, "standard_hmd", (20, 30)),
    (128, 96, 20, 60, "standard_fhd", None),
    (112, 80, 6, 24, "standard_fhd", (111, 0)),
    (97, 75, 6, 30, "standard_fhd", None),
]
FLAWS = [("noise", 10), ("noise", 120), ("blur", 1), ("blur", 4), ("shift", 2), ("brighter", 12), ("flicker", 20)]


def scene(width, height, frame, shift):
    """Values 0…255, [height, width, 3]: moving waves and a disc."""
    y, x, c = (v.astype(np.int64) for v in np.meshgrid(np.arange(height), np.arange(width), np.arange(3), indexing="ij"))
    x = x + shift
    waves = (triangle(3 * x + 2 * y + 5 * frame, 40 + 9 * c) + triangle(x * (c + 1) + 7 * frame, 23)) // 2
    disc = (x - width // 3 - 2 * frame) ** 2 + (y - height // 2) ** 2 < (height // 3) ** 2
    return np.where(disc, 200 - 60 * c, waves)


def blurred(values, radius):
    """Means over squares, with repeated edges, rounded."""
    height, width, _ = values.shape
    padded = np.pad(values, ((radius, radius), (radius, radius), (0, 0)), mode="edge")
    side = 2 * radius + 1
    total = sum(padded[i : i + height, j : j + width] for i, j in itertools.product(range(side), range(side)))
    return (total + side * side // 2) // (side * side)


def picture(width, height, frame, flaw, size):
    """A frame, as f32 in [0, 1]."""
    values = scene(width, height, frame, size if flaw == "shift" else 0)
    if flaw == "noise":
        y, x, c = (v.astype(np.int64) for v in np.meshgrid(np.arange(height), np.arange(width), np.arange(3), indexing="ij"))
        values = values + (noise(x, y, c, frame) - 128) * size // 128
    elif flaw == "blur":
        values = blurred(values, size)
    elif flaw == "brighter" or flaw == "flicker" and frame % 2 == 1:
        values = values + size
    return np.clip(values, 0, 255).astype(np.float32) / np.float32(255)


def case(clip, flaw, size):
    width, height, frames, fps, display, gaze = clip
    metric = pyfvvdp.fvvdp(
        display_name=display, foveated=gaze is not None, heatmap="raw", quiet=True, device=torch.device("cpu")
    )
    reference = np.stack([picture(width, height, f, "none", 0) for f in range(frames)])
    test = np.stack([picture(width, height, f, flaw, size) for f in range(frames)])
    if fps == 0:
        reference, test = reference[0], test[0]
    fixation = None if gaze is None else torch.tensor(gaze, dtype=torch.float32)
    order = "HWC" if fps == 0 else "FHWC"
    jod, found = metric.predict(test, reference, dim_order=order, frames_per_second=fps, fixation_point=fixation)
    return {
        "size": [width, height],
        "frames": frames,
        "fps": fps,
        "display": display,
        "gaze": gaze,
        "flaw": flaw,
        "amount": size,
        "jod": round(float(jod), 5),
        # Half precision in the program: three digits.
        "map_mean": round(float(found["heatmap"].float().mean()), 4),
    }


if __name__ == "__main__":
    rows = [json.dumps(case(clip, *flaw)) for clip, flaw in itertools.product(CLIPS, FLAWS)]
    print("[\n" + ",\n".join(rows) + "\n]")

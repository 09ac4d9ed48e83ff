"""Expected values of FovVideoVDP, from its published program (licensed for non-commercial use).

    pip install numpy torch pyfvvdp==1.2.2
    python fvvdp.py > fvvdp.json

The clips are integer formulas, so that the Rust test makes the same ones, bit by bit.
"""

import itertools
import json

import numpy as np
import pyfvvdp
import torch

from clips import picture

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

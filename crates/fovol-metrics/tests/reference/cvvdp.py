"""Expected values of ColorVideoVDP, from its published program (MIT licence).

    pip install numpy torch cvvdp==0.5.7
    python cvvdp.py > cvvdp.json

The clips are integer formulas, so that the Rust test makes the same ones, bit by bit.
"""

import itertools
import json

import numpy as np
import pycvvdp
import torch

from clips import picture

# Width, height, frames, frames a second (0: a picture), display.
CLIPS = [
    (64, 48, 1, 0, "standard_4k"),
    (160, 120, 1, 0, "standard_hmd"),
    (97, 75, 1, 0, "standard_fhd"),
    (53, 40, 1, 0, "standard_fhd"),
    (4, 5, 1, 0, "standard_4k"),
    (12, 9, 1, 0, "standard_hmd"),
    (400, 256, 1, 0, "standard_hmd"),
    (320, 180, 3, 30, "standard_4k"),
    (128, 72, 12, 30, "standard_4k"),
    (96, 128, 10, 24, "standard_hmd"),
    (75, 64, 20, 60, "standard_fhd"),
    (40, 31, 6, 23.976, "standard_hmd"),
]
FLAWS = [
    ("noise", 10),
    ("noise", 120),
    ("blur", 1),
    ("blur", 4),
    ("shift", 2),
    ("brighter", 12),
    ("flicker", 20),
    ("tint", 15),
]


def case(clip, flaw, size):
    width, height, frames, fps, display = clip
    metric = pycvvdp.cvvdp(display_name=display, quiet=True, device=torch.device("cpu"))
    reference = np.stack([picture(width, height, f, "none", 0) for f in range(frames)])
    test = np.stack([picture(width, height, f, flaw, size) for f in range(frames)])
    jod, _ = metric.predict(test, reference, dim_order="FHWC", frames_per_second=fps)
    return {
        "size": [width, height],
        "frames": frames,
        "fps": fps,
        "display": display,
        "flaw": flaw,
        "amount": size,
        "jod": round(float(jod), 5),
    }


if __name__ == "__main__":
    torch.set_grad_enabled(False)
    rows = [json.dumps(case(clip, *flaw)) for clip, flaw in itertools.product(CLIPS, FLAWS)]
    print("[\n" + ",\n".join(rows) + "\n]")

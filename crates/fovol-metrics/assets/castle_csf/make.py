"""Makes sensitivity.f32 from a table of ColorVideoVDP's package.

    pip install numpy cvvdp==0.5.7
    python make.py FOLDER_OF_PACKAGES/pycvvdp/vvdp_data/csf_lut_weber_fixed_size.json
"""

import json
import sys
from pathlib import Path

import numpy as np

table = json.loads(Path(sys.argv[1]).read_text())
channels = ["o0_c1", "o0_c2", "o0_c3", "o5_c1"]
values = np.array([table[channel] for channel in channels], dtype="<f4")
assert values.shape == (4, 32, 32)
for axis, low, high in [("L_bkg", 0.005, 1e4), ("rho", 0.1, 64)]:
    assert np.allclose(table[axis], np.geomspace(low, high, 32))
values.tofile(Path(__file__).with_name("sensitivity.f32"))

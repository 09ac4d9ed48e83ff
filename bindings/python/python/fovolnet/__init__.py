"""Volume rendering in a fraction of the rays.

A NumPy array becomes a picture in one line::

    import numpy as np, fovolnet as fv
    fv.show(np.load("scan.npy"), spacing=(1, 1, 2.5), clim=(-200, 900))

`Scene` holds volumes, a camera and settings. `read` opens files. `Reconstructor` fills sparse frames of any renderer.
Settings have the names of the command line's flags, with ``_`` for ``-``.
"""

import os
import sys

# Mesa complains on standard error where there is no desktop to ask for the preferred GPU.
if sys.platform == "linux" and "XDG_RUNTIME_DIR" not in os.environ:
    os.environ.setdefault("NODEVICE_SELECT", "1")

from . import metrics, programs
from ._native import FovolnetError, Frame, Volume, __version__
from .camera import Camera
from .clip import write_clip
from .layer import Layer
from .picture import Picture
from .reconstruction import Reconstructor
from .scene import Scene
from .show import show
from .programs import repro
from .volumes import as_volume, read, write
from .weights import export_onnx, load_weights, save_weights

__all__ = [
    "Camera",
    "FovolnetError",
    "Frame",
    "Layer",
    "Picture",
    "Reconstructor",
    "Scene",
    "Volume",
    "__version__",
    "as_volume",
    "export_onnx",
    "load_weights",
    "metrics",
    "programs",
    "read",
    "repro",
    "save_weights",
    "show",
    "write",
    "write_clip",
]

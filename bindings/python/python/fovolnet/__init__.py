"""Volume rendering in a fraction of the rays.

A NumPy array becomes a picture in one line::

    import numpy as np, fovolnet as fv
    fv.show(np.load("scan.npy"), spacing=(1, 1, 2.5), clim=(-200, 900))

`Scene` holds volumes, a camera and settings. `read` opens files. `Reconstructor` fills sparse frames of any renderer.
Settings have the names of the command line's flags, with ``_`` for ``-``.
"""

from . import metrics
from ._native import FovolnetError, Frame, Volume, __version__
from .camera import Camera
from .picture import Picture
from .reconstruction import Reconstructor
from .scene import Scene
from .show import show
from .volumes import as_volume, read

__all__ = [
    "Camera",
    "FovolnetError",
    "Frame",
    "Picture",
    "Reconstructor",
    "Scene",
    "Volume",
    "__version__",
    "as_volume",
    "metrics",
    "read",
    "show",
]

"""Small pictures on the processor."""

from __future__ import annotations

from typing import Any

import numpy as np

import fovolnet as fv
from fovolnet.show import OF_VOLUME

#: Width and height.
SIZE = (96, 64)


def picture(data: object, **options: Any) -> np.ndarray[Any, Any]:
    """The picture of ``data`` on the processor."""
    of_volume = {name: options.pop(name) for name in OF_VOLUME if name in options}
    with fv.Scene(size=SIZE, device="cpu", **options) as scene:
        scene.add_volume(data, **of_volume)
        return scene.render()

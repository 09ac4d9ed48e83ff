"""Reconstruction of sparse frames of any renderer."""

from __future__ import annotations

from typing import Any

import numpy as np

from . import _native
from .settings_text import settings_json


class Reconstructor:
    """Fills sparse frames of a clip. Networks remember earlier frames: call it in order, and `reset` after a cut.

    Parameters
    ----------
    weights : str
        ``"wnet-fast"``, ``"wnet-paper"``, ``"deepfovea-fvn"``, a file of weights; or ``"linear"`` or ``"pull-push"``, which need none.
    **settings
        Flags of the command line with ``_`` for ``-``, such as ``precision="f32"``: some processors multiply numbers of 16 bits, if this
        is left out.
    """

    def __init__(self, weights: str = "wnet-fast", **settings: Any) -> None:
        self.weights = weights
        self.settings = settings
        self._native: _native.Reconstructor | None = None
        self._size: tuple[int, int] | None = None

    def __call__(self, colours: Any, mask: Any, motion: Any = None) -> np.ndarray:
        """Reconstructs the next frame.

        Parameters
        ----------
        colours : array (height, width, 3 or 4)
            Display colours, float 0 to 1 or uint8. Only those of the mask count.
        mask : array (height, width)
            Which pixels are known.
        motion : array (height, width, 2), optional
            Way of each pixel to its place in the last frame, right and down, in pixels.

        Returns
        -------
        array (height, width, 3)
            float32, 0 to 1.
        """
        colours, mask = np.asarray(colours), np.asarray(mask, dtype=bool)
        if colours.dtype == np.uint8:
            colours = colours / np.float32(255.0)
        if colours.ndim != 3:
            raise ValueError(f"colours have the shape (height, width, 3 or 4), not {colours.shape}")
        height, width = colours.shape[:2]
        if self._size != (width, height):
            is_fill = self.weights in ("linear", "pull-push")
            how = {"reconstruct": self.weights} if is_fill else {"weights": self.weights}
            self._native = _native.Reconstructor(width, height, settings_json({**self.settings, **how}))
            self._size = (width, height)
        way = None if motion is None else np.ascontiguousarray(motion, dtype=np.float32)
        assert self._native is not None
        filled = self._native.reconstruct(
            np.ascontiguousarray(colours, dtype=np.float32), np.ascontiguousarray(mask), way
        )
        return filled[..., :3]

    def reset(self) -> None:
        """Forgets earlier frames, as after a cut."""
        if self._native is not None:
            self._native.reset()

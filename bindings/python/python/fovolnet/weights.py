"""Weights of networks, for training and for other programs."""

from __future__ import annotations

import os

import numpy as np
from numpy.typing import NDArray

from . import _native


def load_weights(weights: str | os.PathLike[str] = "wnet-fast") -> dict[str, NDArray[np.float32]]:
    """Arrays of a network.

    Parameters
    ----------
    weights : str or path
        ``"wnet-fast"``, ``"wnet-paper"``, ``"deepfovea-fvn"``, or a file: safetensors, or a state dict of PyTorch (.pt).

    Returns
    -------
    dict of float32 arrays
        From their names. Kernels have the shape (outputs, inputs, height, width), as in PyTorch.
    """
    return _native.weights(os.fspath(weights))


def save_weights(path: str | os.PathLike[str], weights: str | os.PathLike[str] = "wnet-fast") -> None:
    """Writes a network as a safetensors file, whose metadata say how it is built.

    Parameters
    ----------
    path : path
        The file.
    weights : str or path
        See `load_weights`.
    """
    with open(path, "wb") as file:
        file.write(_native.safetensors(os.fspath(weights)))


def export_onnx(path: str | os.PathLike[str], weights: str | os.PathLike[str] = "wnet-fast") -> int:
    """Writes a network as ONNX, opset 17, for any height and width.

    Parameters
    ----------
    path : path
        The file.
    weights : str or path
        See `load_weights`.

    Returns
    -------
    int
        Heights and widths are multiples of this.
    """
    return _native.export_onnx(os.fspath(path), os.fspath(weights))

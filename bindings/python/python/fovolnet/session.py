"""Session files: everything that a picture depends on."""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from typing import Any

from ._native import Volume, read_session, write_session
from .layer import Layer
from .settings_text import settings_json


def read(path: str | os.PathLike[str]) -> tuple[Layer, dict[str, Any]]:
    """The volumes of a session file, as one layer, and its settings, with names of Python."""
    source, reading, rendering = read_session(os.fspath(path))
    settings = {name.replace("-", "_"): value for name, value in json.loads(rendering).items()}
    return Layer(Volume.read(source, reading), "volume 0", settings.pop("tf", None)), settings


def write(path: str | os.PathLike[str], layers: Sequence[Layer], settings: dict[str, Any]) -> None:
    """Writes a session of ``layers``, whose volumes come from files, and ``settings``."""
    first, *others = [layer for layer in layers if layer.visible]
    reading = reading_of(first)
    for other in others:
        if set(reading_of(other)) - {"range"}:
            raise ValueError(f"layer {other.name!r} was read with settings, which a session keeps of the first layer alone; convert its file")
        reading.setdefault("overlay", []).append(f"{other.volume.source}@{other.transfer}")
    write_session(os.fspath(path), first.volume.source, json.dumps(reading), settings_json(settings))


def reading_of(layer: Layer) -> dict[str, Any]:
    """Settings that the volume of ``layer`` was read with, and its range if that was chosen."""
    text = layer.volume.read_settings
    if text is None:
        raise ValueError(
            f"layer {layer.name!r} is an array, which a session cannot hold; write it with fovolnet.write, and read it from there"
        )
    settings: dict[str, Any] = json.loads(text)
    if layer.volume.range_is_chosen:
        settings.pop("window", None)
        settings["range"] = list(layer.clim)
    return settings

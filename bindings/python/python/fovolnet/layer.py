"""Volumes of a scene and how they are shown."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, SupportsIndex, overload

from ._native import Volume
from .transfer_functions import transfer_text
from .volumes import pair


class Layer:
    """A volume of a scene and how it is shown. Changes of its attributes show in the next picture.

    `Scene.add_volume` makes layers. They cannot be used in several scenes.

    Attributes
    ----------
    name : str
        Name in `Scene.layers`.
    volume : Volume
        Voxels.
    cmap, opacity
        Colours and opacities, see `Scene.add_volume`.
    clim : (float, float)
        Values shown as 0 and 1.
    visible : bool
        Whether it is shown.
    """

    def __init__(self, volume: Volume, name: str, cmap: Any = None, opacity: Any = None) -> None:
        self.name = name
        self.visible = True
        self._volume, self._cmap, self._opacity = volume, cmap, opacity
        self._transfer: str | None = None

    @property
    def volume(self) -> Volume:
        return self._volume

    @property
    def cmap(self) -> Any:
        return self._cmap

    @cmap.setter
    def cmap(self, cmap: Any) -> None:
        self._cmap, self._transfer = cmap, None

    @property
    def opacity(self) -> Any:
        return self._opacity

    @opacity.setter
    def opacity(self, opacity: Any) -> None:
        self._opacity, self._transfer = opacity, None

    @property
    def clim(self) -> tuple[float, float]:
        low, high = self._volume.range
        return low, high

    @clim.setter
    def clim(self, clim: Sequence[float]) -> None:
        self._volume, self._transfer = self._volume.with_range(pair(clim)), None

    @property
    def transfer(self) -> str:
        """The transfer function: a name, or JSON."""
        if self._transfer is None:
            self._transfer = transfer_text(self._volume, self._cmap, self._opacity)
        return self._transfer

    def __repr__(self) -> str:
        return f"<fovolnet.Layer {self.name!r} of {self._volume!r}>"


class Layers(list[Layer]):
    """Layers of a scene, by their numbers or names: ``scene.layers["ct"]``."""

    @overload
    def __getitem__(self, which: SupportsIndex | str) -> Layer: ...

    @overload
    def __getitem__(self, which: slice) -> list[Layer]: ...

    def __getitem__(self, which: SupportsIndex | str | slice) -> Layer | list[Layer]:
        if not isinstance(which, str):
            return super().__getitem__(which)
        for layer in self:
            if layer.name == which:
                return layer
        names = ", ".join(repr(layer.name) for layer in self) or "none"
        raise KeyError(f"the scene has no layer {which!r}; its layers are {names}")

"""The camera of a scene."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np


@dataclass
class Camera:
    """A camera around a target, with +y up. The longest side of the volume is 1, and its centre is at 0.

    Attributes
    ----------
    azimuth, elevation : float
        Degrees around the target: from the front to its left on the picture's right, and upwards.
    distance : float
        From the eye to the target.
    target : array of three floats
    fovy : float
        Vertical field of view in degrees.
    """

    azimuth: float
    elevation: float
    distance: float
    target: np.ndarray = field(default_factory=lambda: np.zeros(3))
    fovy: float = 45.0

    @classmethod
    def looking(cls, eye: object, target: object, fovy: float) -> Camera:
        """The camera at ``eye`` that looks at ``target``, both (x, y, z)."""
        target = np.asarray(target, dtype=float)
        x, y, z = np.asarray(eye, dtype=float) - target
        distance = float(np.sqrt(x * x + y * y + z * z))
        azimuth = float(np.degrees(np.arctan2(x, z)))
        elevation = float(np.degrees(np.arcsin(np.clip(y / distance, -1.0, 1.0)))) if distance > 0.0 else 0.0
        return cls(azimuth, elevation, distance, target, float(fovy))

    @property
    def eye(self) -> np.ndarray:
        """Position of the eye, (x, y, z)."""
        azimuth, elevation = np.radians([self.azimuth, self.elevation])
        away = [np.cos(elevation) * np.sin(azimuth), np.sin(elevation), np.cos(elevation) * np.cos(azimuth)]
        return np.asarray(self.target, dtype=float) + self.distance * np.asarray(away)

    def turned(self, degrees: float) -> Camera:
        """The camera that far around the target, to its right."""
        return replace(self, azimuth=self.azimuth + degrees)

    def as_setting(self) -> list[float]:
        """Eye, target and field of view, as the setting ``camera``."""
        return [*map(float, self.eye), *map(float, self.target), float(self.fovy)]

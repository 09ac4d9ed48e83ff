"""Motions of a camera by pointer, wheel and keys."""

from __future__ import annotations

import numpy as np

from .camera import Camera

#: Degrees that a drag over the height of the picture turns the view.
TURN = 180.0
#: Elevations end before the poles, where the picture would flip.
HIGHEST = 89.0
#: Bounds of the distance. The longest side of the volume is 1.
NEAREST, FARTHEST = 0.01, 100.0


def turn(camera: Camera, right: float, down: float) -> None:
    """Turns ``camera`` about its target, as if the volume were dragged ``right`` and ``down``, in heights of the picture."""
    camera.azimuth = (camera.azimuth - TURN * right + 180.0) % 360.0 - 180.0
    camera.elevation = float(np.clip(camera.elevation + TURN * down, -HIGHEST, HIGHEST))


def pan(camera: Camera, right: float, down: float) -> None:
    """Moves ``camera`` and its target, as if the volume were dragged ``right`` and ``down``, in heights of the picture."""
    camera.target = np.asarray(camera.target, dtype=float) - in_target_plane(camera, right, down)


def zoom(camera: Camera, factor: float, right: float = 0.0, down: float = 0.0) -> None:
    """Multiplies the distance of ``camera`` with ``factor``. The place ``right`` of and ``down`` from the centre of the picture,
    in heights, stays where it is."""
    distance = float(np.clip(camera.distance * factor, NEAREST, FARTHEST))
    kept = distance / camera.distance
    towards = in_target_plane(camera, right, down) * (1.0 - kept)
    camera.target = np.asarray(camera.target, dtype=float) + towards
    camera.distance = distance


def in_target_plane(camera: Camera, right: float, down: float) -> np.ndarray:
    """Way in world space, in the plane of the target, that is ``right`` and ``down`` in heights of the picture."""
    azimuth, elevation = np.radians([camera.azimuth, camera.elevation])
    to_right = np.array([np.cos(azimuth), 0.0, -np.sin(azimuth)])
    up = np.array([-np.sin(elevation) * np.sin(azimuth), np.cos(elevation), -np.sin(elevation) * np.cos(azimuth)])
    height = 2.0 * camera.distance * np.tan(np.radians(camera.fovy) / 2.0)
    return np.asarray(height * (right * to_right - down * up))

"""Clips in files."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable
from fractions import Fraction

from ._native import Clip, Frame


def write_clip(
    path: str | os.PathLike[str],
    frames: Iterable[Frame],
    *,
    fps: float = 30.0,
    progress: Callable[[int, int], object] | None = None,
    n: int | None = None,
) -> str:
    """Writes frames to a clip. The file gets its name when it is complete.

    Parameters
    ----------
    path : path
        The extension chooses the format: .mp4, .gif, .webm and others where ffmpeg is installed, and .y4m everywhere.
    frames : iterable of Frame
        Such as those of `Scene.frames`, all of one size.
    fps : float
        Frames a second.
    progress : callable, optional
        It is called after each frame, with the number of frames so far and ``n``.
    n : int, optional
        Number of frames, if it is known.

    Returns
    -------
    str
        The file: ``path``, or with ``.y4m`` added where ffmpeg is needed and not installed.
    """
    clip: Clip | None = None
    rate = Fraction(fps).limit_denominator(1001)
    done = 0
    for frame in frames:
        if clip is None:
            height, width = frame.shape
            clip = Clip(os.fspath(path), width, height, f"{rate.numerator}/{rate.denominator}")
        clip.push(frame)
        done += 1
        if progress is not None:
            progress(done, n if n is not None else done)
    if clip is None:
        raise ValueError("there are no frames to write")
    return clip.finish()

"""Quality of pictures and clips."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import _native


def psnr(reference: Any, test: Any) -> float:
    """Peak signal-to-noise ratio in dB of two pictures, 100 for equal ones.

    Parameters
    ----------
    reference, test : array (height, width, 3 or 4)
        uint8, or float 0 to 1.
    """
    return _native.psnr(floats(reference), floats(test))


def ssim(reference: Any, test: Any) -> float:
    """Structural similarity of two pictures, 1 for equal ones. Parameters as for `psnr`."""
    return _native.ssim(floats(reference), floats(test))


def ms_ssim(reference: Any, test: Any) -> float:
    """Structural similarity of two pictures at five resolutions, 1 for equal ones. Parameters as for `psnr`."""
    return _native.ms_ssim(floats(reference), floats(test))


def tpsnr(reference: Sequence[Any], test: Sequence[Any]) -> float:
    """Peak signal-to-noise ratio in dB of the change between neighbouring frames, averaged over a clip.

    Parameters
    ----------
    reference, test : sequences of two or more pictures
        See `psnr`.
    """
    if len(reference) != len(test) or len(test) < 2:
        raise ValueError(f"tpsnr compares two clips of two or more frames, not of {len(reference)} and {len(test)}")
    errors = []
    for i in range(1, len(test)):
        pairs = [(floats(clip[i - 1]), floats(clip[i])) for clip in (reference, test)]
        errors.append(10.0 ** (-0.1 * _native.tpsnr(*pairs)))
    return float(-10.0 * np.log10(np.mean(errors)))


def jod(
    reference: Any,
    test: Any,
    *,
    fps: float = 30.0,
    gaze: Sequence[float] | Iterable[Sequence[float]] | None = None,
    display: str = "standard_4k",
    metric: str = "fvvdp",
) -> float:
    """How much the differences of two clips, or of two pictures, disturb a viewer, in just-objectionable differences.

    Parameters
    ----------
    reference, test : array (frames, height, width, 3 or 4), iterable of pictures, or a picture
        uint8, or float 0 to 1.
    fps : float
        Frames a second.
    gaze : (float, float), or one of them for each frame, optional
        Where the eye looks, as fractions of the picture from its top left; everywhere, if not given. Not for ``"cvvdp"``.
    display : {"standard_4k", "standard_fhd", "standard_hmd"}
        The display and the distance of the viewer.
    metric : {"fvvdp", "cvvdp"}
        FovVideoVDP, or ColorVideoVDP, which judges colours too.

    Returns
    -------
    float
        10 where no difference can be seen; one less where 75 % of viewers prefer the reference.
    """
    if metric not in ("fvvdp", "cvvdp"):
        raise ValueError(f"metric is 'fvvdp' or 'cvvdp', not {metric!r}")
    if metric == "cvvdp" and gaze is not None:
        raise ValueError("ColorVideoVDP has no gaze; leave it out, or take metric='fvvdp'")
    is_picture = isinstance(reference, np.ndarray) and reference.ndim == 3
    clips = ([reference], [test]) if is_picture else (reference, test)
    judge = _native.Jod(display, None if is_picture else float(fps), metric == "cvvdp")
    gazes = gazes_of(gaze)
    for a, b in zip(*clips, strict=True):
        judge.push(floats(a), floats(b), next(gazes))
    value = judge.value()
    if value is None:
        raise ValueError("there are no frames to compare")
    return value


def gazes_of(gaze: Any) -> Iterator[Any]:
    """The gaze of each frame: ``gaze`` for ever if it is one."""
    gaze = None if gaze is None else [tuple(map(float, point)) for point in np.atleast_2d(np.asarray(list(gaze), dtype=float))]
    if gaze is None or len(gaze) == 1:
        while True:
            yield None if gaze is None else gaze[0]
    yield from gaze
    raise ValueError(f"gaze has {len(gaze)} points, and the clips have more frames")


def floats(picture: Any) -> NDArray[np.float32]:
    """``picture`` as float32, 0 to 1, in C order."""
    picture = np.asarray(picture)
    if picture.dtype == np.uint8:
        picture = picture / np.float32(255.0)
    if picture.dtype.kind not in "f":
        raise ValueError(f"a picture has the type uint8, or float with values 0 to 1, not {picture.dtype}")
    return np.ascontiguousarray(picture, dtype=np.float32)

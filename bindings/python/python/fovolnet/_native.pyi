# Written by bindings/python/stubs; do not edit.

from typing import Any

import numpy as np
from numpy.typing import NDArray
from typing_extensions import Buffer
from _typeshed import SupportsGetItem, SupportsLenAndGetItem
from typing import Final, SupportsFloat, SupportsIndex, final
__version__: Final[str]

@final
class Clip:
    """
    Writes a clip frame by frame. The file gets its name when it is finished.
    """
    def __new__(cls, /, path: str, width: SupportsIndex, height: SupportsIndex, fps: str) -> Clip:
        """
        Begins the clip `path` with frames of `width` by `height` pixels, `fps` a second (a number or a fraction, as text).
        """
    def finish(self, /) -> str:
        """
        Completes the clip and returns its path, which ends in .y4m where ffmpeg is needed and not installed.
        """
    def push(self, /, frame: Frame) -> None:
        """
        Appends a frame.
        """

@final
class Frame:
    """
    A rendered frame.

    Arrays are made anew at every access: keep them where they are needed more than once.
    """
    def __repr__(self, /) -> str: ...
    @property
    def density(self, /) -> float:
        """
        Share of the pixels that were marched.
        """
    @property
    def depth(self, /) -> NDArray[np.float32] | None:
        """
        Distances of the marched pixels from the eye: float32 of shape (height, width), in world units, in which the longest side of
        the volume is 1; infinite elsewhere and where nothing shows. None if every pixel was marched.
        """
    @property
    def image(self, /) -> NDArray[np.uint8]:
        """
        The picture: uint8 of shape (height, width, 3), display colours.
        """
    @property
    def image_rgba(self, /) -> NDArray[np.uint8]:
        """
        The picture with opacity: uint8 of shape (height, width, 4), colours not premultiplied.
        """
    @property
    def index(self, /) -> int:
        """
        Number of the frame.
        """
    @property
    def mask(self, /) -> NDArray[np.bool_]:
        """
        Which pixels were marched: bool of shape (height, width).
        """
    @property
    def motion(self, /) -> NDArray[np.float32] | None:
        """
        Way of each pixel to its place in the last frame: float32 of shape (height, width, 2), right and down. None for the first
        frame, and unless a network uses it.
        """
    @property
    def rgba(self, /) -> NDArray[np.float32]:
        """
        The picture: float32 of shape (height, width, 4), display colours 0 to 1 and opacity.
        """
    @property
    def samples(self, /) -> int:
        """
        Number of marched pixels, repeated ones included.
        """
    @property
    def shape(self, /) -> tuple[int, int]:
        """
        Height and width in pixels.
        """
    @property
    def sparse(self, /) -> NDArray[np.float32]:
        """
        Colours of the marched pixels: float32 of shape (height, width, 4); zeros elsewhere, alpha 1 where marched.
        """
    @property
    def times(self, /) -> dict[str, float]:
        """
        Times of the stages in milliseconds: a dict from their names, and the total.
        """

@final
class FrameProducer:
    """
    Makes the pictures of an interactive view: frames within a budget while it moves, then the full frame piece by piece.

    It works on the calling thread without the interpreter's lock, and does not look for signals: call it from a thread of its own.
    """
    def __new__(cls, /, volume: Volume, settings: str = "{}", device: str | None = None, threads: SupportsIndex | None = None) -> FrameProducer:
        """
        A producer of pictures of `volume`. `settings` is a JSON object with the names of the command line's flags. Opens nothing yet.
        """
    def change(self, /, settings: str) -> None:
        """
        Takes other settings for the next pictures, at the size of the last ones.
        """
    @staticmethod
    def check(volume: Volume, settings: str) -> None:
        """
        Checks settings for `volume`. Renders and opens nothing.
        """
    @staticmethod
    def default_camera(volume: Volume, settings: str) -> tuple[list[float], list[float], float]:
        """
        Camera of `settings` for `volume`: eye, target, vertical field of view in degrees. Opens nothing.
        """
    def encode(self, /, encoding: str = "jpeg", quality: SupportsIndex = 85) -> tuple[bytes, int, int]:
        """
        The current picture: its bytes as `jpeg`, `png` or `raw` (RGBA), its width and its height.
        """
    def go_to(self, /, camera: tuple[SupportsLenAndGetItem[SupportsFloat | SupportsIndex], SupportsLenAndGetItem[SupportsFloat | SupportsIndex], SupportsFloat | SupportsIndex], size: tuple[SupportsIndex, SupportsIndex], gaze: tuple[SupportsFloat | SupportsIndex, SupportsFloat | SupportsIndex] = ..., budget: SupportsFloat | SupportsIndex = 80.0) -> dict[str, Any]:
        """
        Makes a picture of a view in motion in about `budget` milliseconds, at most as large as `size`. `gaze` is a place of the
        picture, 0 to 1 from the top left. Returns a dict: width, height, way, ms, and share, 1 for the full frame.
        """
    @property
    def image(self, /) -> NDArray[np.uint8]:
        """
        The current picture: uint8 of shape (height, width, 3).
        """
    def refine(self, /, gaze: tuple[SupportsFloat | SupportsIndex, SupportsFloat | SupportsIndex] = ..., ms: SupportsFloat | SupportsIndex = 70.0) -> float:
        """
        Works about `ms` milliseconds on the full frame of the last view, around `gaze` first. Returns the share that is done; the
        picture of share 1 equals that of a `Renderer`.
        """

@final
class Jod:
    """
    Just-objectionable differences of a clip, frame by frame: FovVideoVDP, or ColorVideoVDP where colours count.
    """
    def __new__(cls, /, display: str, fps: SupportsFloat | SupportsIndex | None, colour: bool) -> Jod:
        """
        A judge of clips with `fps` frames a second on the display `display`; of one still picture where `fps` is None.
        """
    def push(self, /, reference: NDArray[np.float32], test: NDArray[np.float32], gaze: SupportsLenAndGetItem[SupportsFloat | SupportsIndex] | None = None) -> None:
        """
        Looks at the next frame of both clips; `gaze` is where the eye looks, as fractions of the frame from its top left.
        """
    def value(self, /) -> float | None:
        """
        JOD of the frames so far: 10 where no difference can be seen, lower the more it disturbs. None without frames.
        """

@final
class Reconstructor:
    """
    Reconstructs the sparse frames of one clip, of any renderer. Networks remember earlier frames.
    """
    def __new__(cls, /, width: SupportsIndex, height: SupportsIndex, settings: str = "{}") -> Reconstructor:
        """
        A reconstructor of frames of `width` by `height` pixels. `settings` is a JSON object with the names of the command line's
        flags.
        """
    def reconstruct(self, /, colours: NDArray[np.float32], mask: NDArray[np.bool_], motion: NDArray[np.float32] | None = None) -> NDArray[np.float32]:
        """
        Reconstructs the next frame of the clip: `colours` is float32 of shape (height, width, 3), 0 to 1; `mask`, bool of shape
        (height, width), says which of them count; `motion`, float32 of shape (height, width, 2), is the way of each pixel to its place
        in the last frame. Returns float32 of shape (height, width, 4).
        """
    def reset(self, /) -> None:
        """
        Forgets earlier frames, as after a cut.
        """
    @property
    def uses_motion(self, /) -> bool:
        """
        Whether it uses the motion of pixels.
        """

@final
class Renderer:
    """
    Renders frames of a volume.

    Its methods take settings as a JSON object with the names of the command line's flags. What these have in common with the last
    ones stays.
    """
    def __new__(cls, /, volume: Volume, device: str | None = None, threads: SupportsIndex | None = None) -> Renderer:
        """
        A renderer of `volume` on `device` with so many threads. It prepares the volume when it first renders.
        """
    def camera(self, /, settings: str, i: SupportsIndex = 0) -> tuple[list[float], list[float], float]:
        """
        The camera of frame `i`: eye, target, vertical field of view in degrees.
        """
    def depth(self, /, settings: str, i: SupportsIndex = 0) -> NDArray[np.float32]:
        """
        Distance of every pixel of frame `i` from the eye, along its ray, to where its opacity passes one half; where it
        never does, the mean distance of what shows: float32 of shape (height, width), in world units; infinite where nothing shows.
        """
    def gpu(self, /, settings: str) -> str | None:
        """
        Name of the GPU that renders, or None where the processor does.
        """
    def notes(self, /, settings: str) -> list[str]:
        """
        Assumptions and omissions, one line each.
        """
    def reference(self, /, settings: str, i: SupportsIndex = 0) -> NDArray[np.float32]:
        """
        Frame `i` with every pixel marched and exact shadows: float32 of shape (height, width, 4).
        """
    def render(self, /, settings: str, i: SupportsIndex = 0, motion: bool = False) -> Frame:
        """
        Renders frame `i`, seen by the camera of the settings or along their path. Frames have the motion of their pixels where
        `motion` is true.
        """
    def reset(self, /) -> None:
        """
        Forgets all earlier frames, as after a cut.
        """
    def show(self, /, volume: Volume) -> None:
        """
        Shows another volume. Networks go on with what they have seen.
        """

@final
class Volume(Buffer):
    """
    A volume: voxels, their spacing, and what its file says about them.

    Make one with `read` or `as_volume`. `numpy.asarray(volume)` shows its stored values without a copy, as [z, y, x]; values are
    slope · stored + intercept, see `rescale`.
    """
    def __repr__(self, /) -> str: ...
    @property
    def directions(self, /) -> list[list[float]] | None:
        """
        Unit vectors along the axes x, y, z of the voxels, one after the other, in the space of `origin`; None where nothing says.
        """
    @property
    def dtype(self, /) -> str:
        """
        Type of the stored values: u8, i8, u16, i16, u32, i32, u64, i64, f16, f32 or f64.
        """
    @staticmethod
    def from_array(array: NDArray[Any], facts: str = "{}") -> Volume:
        """
        The volume of `array`, in C order, of shape (z, y, x) or (z, y, x, components), without a copy. `facts` is a JSON object.
        """
    @property
    def has_own_colours(self, /) -> bool:
        """
        Whether the volume says which colours it has: those of its file, of labels, or of a procedural volume.
        """
    @property
    def layers(self, /) -> int:
        """
        Number of volumes shown together: 1, and 1 more for each further channel or layer.
        """
    @property
    def notes(self, /) -> list[str]:
        """
        Assumptions while the file was read, one line each.
        """
    @property
    def origin(self, /) -> list[float] | None:
        """
        Centre of the first voxel, (x, y, z), in patient space (left, posterior, superior) where the volume is a patient's; None where
        nothing says.
        """
    @property
    def range(self, /) -> list[float]:
        """
        Values shown as 0 and 1.
        """
    @property
    def range_is_chosen(self, /) -> bool:
        """
        Whether `range` was chosen, rather than found in the values.
        """
    @staticmethod
    def read(source: str, settings: str = "{}") -> Volume:
        """
        Reads a file, a folder or a procedural volume. `settings` is a JSON object with the names of the command line's flags.
        """
    @property
    def read_settings(self, /) -> str | None:
        """
        Settings that the volume was read with, as JSON; None if it comes from an array.
        """
    @property
    def rescale(self, /) -> tuple[float, float]:
        """
        Slope and intercept: values are slope · stored + intercept.
        """
    @property
    def shape(self, /) -> tuple[int, int, int]:
        """
        Number of voxels along z, y, x.
        """
    @property
    def source(self, /) -> str:
        """
        Path or name that the volume was read from.
        """
    @property
    def spacing(self, /) -> list[float]:
        """
        Distance of voxels along x, y, z.
        """
    def transfer_function(self, /, what: str) -> str:
        """
        The transfer function of the text `what` over the values shown, as JSON with `points` [value, r, g, b, opacity], all 0 to 1.
        """
    @property
    def units(self, /) -> str | None:
        """
        Unit of the spacing, such as "mm", or None where nothing says.
        """
    def with_layer(self, /, other: Volume, tf: str) -> Volume:
        """
        Copy that is shown with `other`, whose transfer function is the text `tf`, on its box.
        """
    def with_range(self, /, range: SupportsLenAndGetItem[SupportsFloat | SupportsIndex]) -> Volume:
        """
        Copy that shows other values as 0 and 1, with the same voxels.
        """
    def write(self, /, path: str) -> list[str]:
        """
        Writes the volume in the format of the extension of `path`. Returns notes on what the format cannot hold.
        """

def export_onnx(path: str, weights: str) -> int:
    """
    Writes the network `weights` as ONNX, opset 17. Returns the number that height and width are multiples of.
    """

def ms_ssim(reference: NDArray[np.float32], test: NDArray[np.float32]) -> float:
    """
    Structural similarity of two pictures at five resolutions.
    """

def psnr(reference: NDArray[np.float32], test: NDArray[np.float32]) -> float:
    """
    Peak signal-to-noise ratio of two pictures in dB: float32 of shape (height, width, 3 or 4), 0 to 1.
    """

def read_session(path: str) -> tuple[str, str, str]:
    """
    Reads the session file `path`: the name of its volume, and as JSON the settings to read the volume and to render it.

    Raises where the volume is missing or has changed.
    """

def run_command(arguments: SupportsGetItem[int, str]) -> int:
    """
    Runs the command `fovolnet` with `arguments`, the first of which is the program, and returns its exit status.

    It is meant for a process of its own: it listens to signals, and changes the limits of the process.
    """

def run_viewer(arguments: SupportsGetItem[int, str]) -> int:
    """
    Runs the command `fovolnet-viewer` with `arguments`, the first of which is the program, and returns its exit status.

    It is meant for the first thread of a process of its own, for the same reasons.
    """

def safetensors(weights: str) -> bytes:
    """
    Bytes of the network `weights` as a safetensors file, which says how the network is built.
    """

def ssim(reference: NDArray[np.float32], test: NDArray[np.float32]) -> float:
    """
    Structural similarity of two pictures, with the Gaussian window of its authors.
    """

def tpsnr(reference: tuple[NDArray[np.float32], NDArray[np.float32]], test: tuple[NDArray[np.float32], NDArray[np.float32]]) -> float:
    """
    Temporal PSNR of two pairs of neighbouring frames in dB.
    """

def weights(weights: str) -> dict[str, NDArray[np.float32]]:
    """
    Arrays of the network `weights`: float32, from their names.
    """

def write_session(path: str, source: str, read: str, render: str) -> None:
    """
    Writes the session of the volume `source` to `path`. The settings are JSON objects.
    """


class FovolnetError(ValueError): ...

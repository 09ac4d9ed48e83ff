"""What every section is given: the program, its volumes, the record, and how large everything is."""

from dataclasses import dataclass
from pathlib import Path

from program import Program, Volumes
from record import Record


@dataclass(frozen=True)
class Scale:
    """How large everything is."""

    # Sides of volumes; those that pictures are compared of and whole frames are made of have the first one.
    sides: tuple
    # Sizes of frames; the first one is that of which most is promised.
    sizes: tuple
    # Volumes that pictures are compared of.
    compared: tuple
    # Volumes that whole frames are made of.
    filmed: tuple
    # Volume, side, size of frames and step of scenes that take long: one of each volume, then ones that take longer.
    heavy: tuple
    # Size of the frames of networks that are compared, and how many these are.
    clip: tuple
    # Repetitions of what is timed alone, and frames of clips, at the first size; of larger frames there are fewer.
    repeats: int
    frames: int
    # But no fewer than so many: a device's clock rises while there is work.
    least_frames: int
    # Seconds that each way of a peer is repeated for.
    peer_seconds: float


FULL = Scale(
    sides=(256, 512, 1024),
    sizes=("1280x720", "1920x1080", "3840x2160"),
    compared=("head", "supernova", "engine", "plume", "reptile", "angiogram", "marschner-lobb", "vortices"),
    filmed=("head", "supernova", "plume", "engine"),
    heavy=tuple(
        (name, side, "3840x2160", step)
        for side, step in [(256, 0.5), (512, 0.5), (512, 0.25), (1024, 0.25)]
        for name in ("head", "supernova", "plume", "engine")
        # A volume of this side and floats takes 4 GB, and half a minute to be made and read.
        if side < 1024 or name in ("head", "engine")
    ),
    clip=("1280x720", 16),
    repeats=150,
    frames=600,
    least_frames=60,
    peer_seconds=0.5,
)
QUICK = Scale(
    sides=(32,),
    sizes=("64x48",),
    compared=("head", "engine"),
    filmed=("head",),
    heavy=(("head", 64, "96x64", 0.25),),
    clip=("48x32", 3),
    repeats=2,
    frames=6,
    least_frames=6,
    peer_seconds=0.05,
)


@dataclass
class Bench:
    """What every section is given."""

    record: Record
    program: Program
    volumes: Volumes
    scale: Scale
    # The device that is asked for.
    device: str
    # What peers compute on: cuda or cpu.
    peers_on: str
    # A folder for what is needed for a moment.
    folder: Path

    def share(self, size):
        """How many times as many pixels as of the first size there are, or 1 if there are fewer."""
        return max(1.0, pixels(size) / pixels(self.scale.sizes[0]))

    def has_matrices(self):
        """Whether the GPU that is measured multiplies by cooperative matrices."""
        return bool(self.gpu().get("matrices"))

    def gpu(self):
        """What the program knows about the GPU that is measured."""
        known = {gpu["name"]: gpu for gpu in self.record.facts["devices"]["gpus"]}
        return known.get(self.record.facts.get("gpu"), {})


def pixels(size):
    """The pixels of a frame of `WxH`."""
    width, height = map(int, size.split("x"))
    return width * height

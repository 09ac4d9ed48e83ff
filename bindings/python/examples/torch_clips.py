"""Sparse clips as a PyTorch data set: made while they are asked for, instead of being kept on a disk.

A clip is a camera on a short way around a volume. It is rendered twice along the same way: with few pixels, and with all. An item is a
dict of float32 tensors:

    colours  [frames, 3, height, width]  colours of the marched pixels, 0 to 1; zeros elsewhere
    mask     [frames, 1, height, width]  1 where a pixel was marched
    motion   [frames, 2, height, width]  way of each pixel to its place in the last frame, right and down; zeros in the first frame
    full     [frames, 3, height, width]  the frames with every pixel marched

Clip number i follows from the seed and i alone. Neither the number of workers nor their order changes it.

    pip install fovolnet torch
    python torch_clips.py --volumes head scan.nrrd --clips 8 --workers 2

Workers have to be new processes (the context "spawn", which this script gives to `DataLoader`). A fork copies memory but no threads: the
child of a process that has rendered waits for threads that it does not have. fovolnet raises an error then.
"""

from __future__ import annotations

import argparse
import os
from typing import Any

import numpy as np
import torch
import torch.nn.functional as F
from torch import Tensor
from torch.utils.data import DataLoader, Dataset

import fovolnet as fv

Clip = dict[str, Tensor]


class SparseClips(Dataset[Clip]):
    """Clips of `frames` frames of one of `volumes` each.

    A process opens a volume when it first needs it, and keeps it open.
    """

    def __init__(
        self, volumes: list[str], clips: int, *, frames: int = 8, size: tuple[int, int] = (256, 144), seed: int = 0, threads: int = 1
    ) -> None:
        self.volumes, self.clips, self.frames, self.size = volumes, clips, frames, size
        self.seed, self.threads = seed, threads
        self._scenes: dict[str, fv.Scene] = {}

    def __len__(self) -> int:
        return self.clips

    def __getitem__(self, i: int) -> Clip:
        if not 0 <= i < self.clips:
            raise IndexError(f"there are {self.clips} clips, and none has the number {i}")
        random = np.random.default_rng((self.seed, i))
        scene = self._scene(self.volumes[random.integers(len(self.volumes))])
        cameras = self._cameras(scene, random)
        noise = {"pb": float(random.uniform(0.02, 0.1)), "first_frame": int(random.integers(64))}
        sparse = self._rendered(scene, cameras, return_sparse=True, reconstruct="none", **noise)
        full = self._rendered(scene, cameras, sampling="full")
        still = np.zeros((self.size[1], self.size[0], 2), np.float32)
        return {
            "colours": tensor([frame.sparse[..., :3] for frame in sparse]),
            "mask": tensor([frame.mask[..., None] for frame in sparse]),
            "motion": tensor([still if frame.motion is None else frame.motion for frame in sparse]),
            "full": tensor([frame.rgba[..., :3] for frame in full]),
        }

    def __getstate__(self) -> dict[str, Any]:
        """Everything but the scenes, which belong to one process: workers open their own."""
        return {**self.__dict__, "_scenes": {}}

    def _scene(self, volume: str) -> fv.Scene:
        if volume not in self._scenes:
            self._scenes[volume] = fv.Scene(size=self.size, threads=self.threads)
            self._scenes[volume].add_volume(volume)
        return self._scenes[volume]

    def _cameras(self, scene: fv.Scene, random: np.random.Generator) -> list[fv.Camera]:
        """A steady turn from a random side and distance."""
        scene.camera = None
        first = scene.camera.turned(random.uniform(0, 360))
        first.elevation = random.uniform(-40, 40)
        first.distance *= random.uniform(0.6, 1.1)
        turn = random.uniform(-4, 4)
        return [first.turned(turn * i) for i in range(self.frames)]

    def _rendered(self, scene: fv.Scene, cameras: list[fv.Camera], **settings: Any) -> list[fv.Frame]:
        """A frame for each camera. The scene's camera is moved before each frame is asked for."""
        frames, clip = [], scene.frames(len(cameras), path=None, **settings)
        for camera in cameras:
            scene.camera = camera
            frames.append(next(clip))
        return frames


def tensor(images: list[np.ndarray[Any, Any]]) -> Tensor:
    """Pictures [height, width, channels] as one tensor [pictures, channels, height, width]."""
    return torch.from_numpy(np.stack(images)).float().permute(0, 3, 1, 2).contiguous()


def square_means(image: Tensor, size: int) -> Tensor:
    """Means of size x size pixels around each pixel, zeros beyond the border: columns first, then rows."""
    half = size // 2
    return F.avg_pool2d(F.avg_pool2d(image, (size, 1), 1, (half, 0)), (1, size), 1, (0, half))


def nearest_means(colours: Tensor, mask: Tensor) -> Tensor:
    """A trivial reconstruction: each pixel is the mean of the samples in the smallest square around it that has one."""
    filled, known = colours, mask
    for size in (3, 5, 9, 17, 33, 65, 129):
        share = square_means(mask, size)
        mean = square_means(colours, size) / share.clamp(min=1e-9)
        is_new = (known == 0) & (share > 0)
        filled, known = torch.where(is_new, mean, filled), torch.where(is_new, 1.0, known)
    return filled


def psnr(reference: Tensor, test: Tensor) -> float:
    """Peak signal-to-noise ratio in dB of a batch."""
    return float(-10 * torch.log10(F.mse_loss(test, reference)))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--volumes", nargs="+", default=["head", "marschner-lobb"], help="files, or names of procedural volumes")
    parser.add_argument("--clips", type=int, default=8, help="number of clips [default: 8]")
    parser.add_argument("--frames", type=int, default=8, help="frames of each clip [default: 8]")
    parser.add_argument("--size", default="256x144", help="width x height [default: 256x144]")
    parser.add_argument("--workers", type=int, default=2, help="processes that render; 0 for this one [default: 2]")
    parser.add_argument("--seed", type=int, default=0, help="another seed, other clips [default: 0]")
    given = parser.parse_args()
    width, height = map(int, given.size.split("x"))
    threads = max(1, (os.cpu_count() or 1) // max(1, given.workers))
    clips = SparseClips(given.volumes, given.clips, frames=given.frames, size=(width, height), seed=given.seed, threads=threads)
    context = "spawn" if given.workers else None
    batches = DataLoader(clips, batch_size=2, num_workers=given.workers, multiprocessing_context=context)
    for number, batch in enumerate(batches):
        clip = {name: values.flatten(0, 1) for name, values in batch.items()}
        filled = nearest_means(clip["colours"], clip["mask"])
        share = float(clip["mask"].mean())
        print(f"batch {number}: {share:.1%} of the pixels, means of the nearest samples {psnr(clip['full'], filled):.2f} dB", flush=True)


if __name__ == "__main__":
    main()

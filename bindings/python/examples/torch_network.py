"""The networks wnet-fast and wnet-paper in PyTorch, with fovolnet's weights, beside fovolnet's own reconstruction.

It renders sparse frames of a clip, gives them to both, and prints the largest difference of each frame, in colours of 0 to 1. Both
begin without memory and remember their own frames. Both multiply numbers of 32 bits, so only the order of sums differs.

    pip install fovolnet torch
    python torch_network.py
    python torch_network.py scan.nrrd --weights wnet-paper --size 320x240 --frames 20

A network is called with colours (zero where nothing was marched), mask and motion of one frame and the state of the last one. It returns
the picture and the next state. Tensors are [batch, channels, rows, columns]. Layers are in `torch_layers.py`.
"""

from __future__ import annotations

import argparse
import sys

import numpy as np
import torch
import torch.nn.functional as F
from numpy.typing import NDArray
from torch import Tensor, nn
from torch_layers import (
    Block,
    PredictedKernel,
    around,
    confidence,
    enlarged,
    reprojected,
    splatted,
    spread,
    warped,
)

import fovolnet as fv

State = dict[str, Tensor]


class UNet(nn.Module):
    """The four encoders and three decoders that both networks have."""

    def __init__(self, inputs: int, encoder: list[int], decoder: list[int], is_recurrent: bool) -> None:
        super().__init__()
        self.encoder = nn.ModuleList(map(Block, [inputs, *encoder[:-1]], encoder))
        below = [*decoder[1:], encoder[-1]]
        own = decoder if is_recurrent else [0, 0, 0]
        self.decoder = nn.ModuleList(map(Block, map(sum, zip(encoder, below, own)), decoder))

    def features(self, inputs: list[Tensor], last: list[Tensor]) -> list[Tensor]:
        """Outputs of the decoders, finest first, and of the last encoder. `last` are those of the last frame, if decoders read them."""
        skips = [self.encoder[0](*inputs)]
        for block in self.encoder[1:]:
            skips.append(block(F.avg_pool2d(skips[-1], 2)))
        features = [skips.pop()]
        for depth in (2, 1, 0):
            features.insert(0, self.decoder[depth](skips[depth], enlarged(features[0]), *last[depth : depth + 1]))
        return features


class FastNetwork(UNet):
    """wnet-fast: algorithm.md, section 5."""

    multiple = 16

    def __init__(self) -> None:
        # Four pixels of colours, weight and last picture are channels of one; the picture of this frame has half the resolution.
        super().__init__(4 * (3 + 1 + 3) + 3, [16, 16, 32, 48], [16, 16, 32], is_recurrent=False)
        self.kernel = nn.ModuleDict({"only": PredictedKernel(16, 11, expand=2)})
        self.addition = nn.Conv2d(16, 12, 1)

    def start(self, height: int, width: int) -> State:
        """The state before the first frame."""
        return {"points": torch.zeros(1, 6, height, width), "picture": torch.zeros(1, 3, height, width)}

    def forward(self, colours: Tensor, mask: Tensor, motion: Tensor, state: State) -> tuple[Tensor, State]:
        last = warped(state["picture"], motion)
        new = torch.cat([colours, mask], dim=1)
        fresh, smooth = spread(new)
        share = confidence(new, last, smooth)
        kept = 0.98 * F.interpolate(share, scale_factor=8, mode="bilinear", align_corners=False)
        before = reprojected(state["points"], motion)
        points = torch.cat([new + (1 - mask) * kept * before[:, :4], (1 - mask) * before[:, 4:]], dim=1)
        samples = splatted(points)
        weight = samples[:, 3:]
        filled = samples[:, :3] + (1 - weight) * enlarged(spread(samples)[0])

        folded = [F.pixel_unshuffle(image, 2) for image in (filled, weight, last)]
        features = self.features([*folded, fresh], [])[0]
        # Eleven taps: the last picture, the filled one and its neighbours, and the one filled from this frame alone.
        picture = self.kernel["only"](features, last[:, None], around(filled), enlarged(fresh)[:, None])
        picture = picture + F.pixel_shuffle(self.addition(features), 2)
        picture = mask * colours + (1 - mask) * picture
        return picture, {"points": points, "picture": picture.clamp(0, 1)}


class PaperNetwork(UNet):
    """wnet-paper: algorithm.md, section 4."""

    multiple = 8

    def __init__(self) -> None:
        super().__init__(3 + 3, [64, 64, 80, 96], [64, 64, 80], is_recurrent=True)
        self.output = nn.Conv2d(64, 3, 1)
        self.kernel = nn.ModuleDict({"bottom": PredictedKernel(96, 9)})
        self.kernel["down"] = nn.ModuleList(PredictedKernel(channels, 9) for channels in (64, 64, 80))
        self.kernel["up"] = nn.ModuleList(PredictedKernel(channels, 10) for channels in (64, 64, 80))

    def start(self, height: int, width: int) -> State:
        """The state before the first frame."""
        decoders = {f"decoder.{i}": torch.zeros(1, n, height >> i, width >> i) for i, n in enumerate((64, 64, 80))}
        return {"direct": torch.zeros(1, 3, height, width), **decoders}

    def forward(self, colours: Tensor, mask: Tensor, motion: Tensor, state: State) -> tuple[Tensor, State]:
        names = ["decoder.0", "decoder.1", "decoder.2"]
        features = self.features([colours, state["direct"]], [state[name] for name in names])
        direct = F.relu(self.output(features[0]))
        picture = self.filtered(direct, features)
        return picture, {"direct": direct, **dict(zip(names, features))}

    def filtered(self, picture: Tensor, features: list[Tensor]) -> Tensor:
        """The direct prediction, filtered at four levels by kernels that the features predict."""
        down, up, skips = self.kernel.get_submodule("down"), self.kernel.get_submodule("up"), []
        for depth in (0, 1, 2):
            skips.append(down.get_submodule(str(depth))(features[depth], around(picture)))
            picture = F.avg_pool2d(skips[depth], 2)
        picture = self.kernel["bottom"](features[3], around(picture))
        for depth in (2, 1, 0):
            picture = up.get_submodule(str(depth))(features[depth], around(enlarged(picture)), skips[depth][:, None])
        return picture


def loaded(name: str) -> FastNetwork | PaperNetwork:
    """The network of that name with its weights. PyTorch checks all names and shapes."""
    network = FastNetwork() if name == "wnet-fast" else PaperNetwork()
    network.load_state_dict({key: torch.from_numpy(array) for key, array in fv.load_weights(name).items()})
    return network.eval().requires_grad_(False)


class TorchReconstructor:
    """A network with its state, called as `fovolnet.Reconstructor` is."""

    def __init__(self, name: str) -> None:
        self.network = loaded(name)
        self.state: State | None = None

    def __call__(self, colours: NDArray[np.float32], mask: NDArray[np.bool_], motion: NDArray[np.float32] | None) -> NDArray[np.float32]:
        """The next frame: float32 of shape (height, width, 3)."""
        height, width = mask.shape
        motion = np.zeros((height, width, 2), colours.dtype) if motion is None else motion
        inputs = [self.padded(colours * mask[..., None]), self.padded(mask[..., None].astype(colours.dtype)), self.padded(motion)]
        if self.state is None:
            self.state = self.network.start(*inputs[0].shape[-2:])
        picture, self.state = self.network(*inputs, self.state)
        return np.asarray(picture[0, :, :height, :width].clamp(0, 1).permute(1, 2, 0))

    def padded(self, image: NDArray[np.float32]) -> Tensor:
        """The tensor of a picture, whose border is repeated until the network can halve its sides."""
        tensor = torch.from_numpy(np.ascontiguousarray(image)).permute(2, 0, 1)[None]
        height, width = image.shape[:2]
        return F.pad(tensor, (0, -width % self.network.multiple, 0, -height % self.network.multiple), mode="replicate")


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("volume", nargs="?", default="head", help="a file, or the name of a procedural volume [default: head]")
    parser.add_argument("--weights", choices=["wnet-fast", "wnet-paper"], default="wnet-fast", help="the network [default: wnet-fast]")
    parser.add_argument("--size", default="200x120", help="width x height [default: 200x120]")
    parser.add_argument("--frames", type=int, default=12, help="length of the clip [default: 12]")
    given = parser.parse_args()
    width, height = map(int, given.size.split("x"))
    ours, theirs = fv.Reconstructor(given.weights, precision="f32"), TorchReconstructor(given.weights)
    largest = 0.0
    with fv.Scene(size=(width, height)) as scene:
        scene.add_volume(given.volume)
        for frame in scene.frames(given.frames, return_sparse=True, reconstruct="none", frames=100):
            colours, mask, motion = frame.sparse[..., :3], frame.mask, frame.motion
            difference = float(np.abs(ours(colours, mask, motion) - theirs(colours, mask, motion)).max())
            largest = max(largest, difference)
            print(f"frame {frame.index}: {mask.mean():.1%} of the pixels, largest difference {difference:.1e}")
    print(f"largest difference of all frames: {largest:.1e}")
    return 0


if __name__ == "__main__":
    sys.exit(main())

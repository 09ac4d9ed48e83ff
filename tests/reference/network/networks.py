"""The networks in plain PyTorch, written from their description, to compare the engines with.

Tensors are [batch, channels, rows, columns]. A network is called with a padded frame and the states of the last
one, and gives the picture (neither clamped nor cropped) and the next states; `run` does whole clips. Parameters
have the names of the weights files, so that `state_dict()` is such a file's content.

Works in float32 and, after `.double()`, in float64; to measure speed also in float16, and on any device.
"""

import numpy as np
import torch
import torch.nn.functional as F
from torch import nn

SQUARED_EPSILON = 1e-6
NORM_EPSILON = 1e-5
PULL_LEVELS = 5
SMALLEST_WEIGHT = 1e-8
DOUBT_EPSILON = 1e-6
DOUBT_ALLOWED = 0.25
DOUBT_SHARE = 0.5
DOUBT_LEVEL = 3
# A pixel and those around it, rows down and columns right of it.
SQUARE = [(down, right) for down in (-1, 0, 1) for right in (-1, 0, 1)]


def wnet(encoder, decoder, **changes):
    """The configuration of a W-shaped network as it stands in a weights file; the paper's unless changed."""
    paper = {
        "kind": "wnet",
        "encoder": encoder,
        "decoder": decoder,
        "feedback": "direct",
        "kernels": True,
        "normalisation": "squared",
        "fold": False,
        "mask": False,
        "prefill": False,
        "bypass": False,
        "history": None,
        "reproject": False,
        "filled": None,
        "flat": None,
        "accumulate": 0.0,
        "points": False,
        "fresh": None,
        "coarse": False,
        "doubt": False,
        "corrections": 0,
        "residual": False,
        "addition": False,
        "recurrent": True,
        "direct": True,
    }
    return paper | changes


ALL_ON = {name: True for name in ["fold", "mask", "prefill", "bypass", "reproject"]}
OURS = ALL_ON | {"feedback": "output", "history": "centre", "filled": "around", "flat": "centre"}
OURS |= {"accumulate": 0.98, "points": True, "fresh": "centre", "doubt": True, "corrections": 1}
OURS |= {"coarse": True, "addition": True, "recurrent": False, "direct": False}
CONFIGS = {
    "wnet-paper": wnet([64, 64, 80, 96], [64, 64, 80]),
    "wnet-narrow": wnet([64, 64, 80, 96], [32, 64, 80]),
    "wnet-fast": wnet([16, 16, 32, 48], [16, 16, 32], **OURS),
    "deepfovea-fvn": wnet(
        [32, 64, 128, 128, 128], [32, 64, 128, 128], feedback="none", kernels=False
    ),
    "deepfovea-orig": {"kind": "deepfovea", "encoder": [32, 64, 128, 128, 128], "bottleneck": 128},
}


# Steps without parameters.


def bilinear_up(image):
    """Twice as many pixels along each axis, between pixel centres, replicated at the border."""
    return F.interpolate(image, scale_factor=2, mode="bilinear", align_corners=False)


def nearest_up(image):
    """Each pixel four times."""
    return F.interpolate(image, scale_factor=2, mode="nearest")


def pixels(image):
    """The columns and rows of its pixels, in no less than float32: halves count to 2048 only."""
    height, width = image.shape[-2:]
    kind = {"dtype": torch.promote_types(image.dtype, torch.float32), "device": image.device}
    return torch.arange(width, **kind), torch.arange(height, **kind)[:, None]


def warp(state, motion):
    """The value that was at p + motion(p), bilinear, zero outside.

    Motion is in pixels of the frame, x right and y down. For a state at 1/f of the resolution it is averaged over
    f x f pixels and divided by f. Pixel centres have whole coordinates.
    """
    height, width = state.shape[-2:]
    factor = motion.shape[-1] // width
    motion = F.avg_pool2d(motion, factor) / factor
    columns, rows = pixels(state)
    x, y = columns + motion[:, 0], rows + motion[:, 1]
    # grid_sample counts from -1 at the left edge of the first pixel to 1 at the right edge of the last.
    grid = torch.stack([(2 * x + 1) / width - 1, (2 * y + 1) / height - 1], dim=-1)
    return F.grid_sample(state, grid.to(state.dtype), mode="bilinear", padding_mode="zeros", align_corners=False)


def reproject(points, motion):
    """Points [batch, 6, rows, columns] where they are now: of each pixel what is known (three numbers times the weight,
    and the weight), and how far right of and below its centre that lies, -0.5 to below 0.5.

    A pixel p takes the points that were in the square of a pixel's size around p + motion(p): the mean of what they say
    and of where they are, both by weight, with the largest of their weights.
    """
    columns, rows = pixels(points)
    from_x, from_y = columns + motion[:, :1], rows + motion[:, 1:]
    near_x, near_y = from_x.round(), from_y.round()
    total, largest, colours, places = 0, torch.zeros_like(points[:, 3:4]), 0, 0
    # Those in the square belong to the nearest pixel or one beside it: none lies outside its own pixel.
    for down, right in SQUARE:
        x, y = near_x + right, near_y + down
        point = points_at(points, x, y)
        moved = torch.cat([x + point[:, 4:5] - from_x, y + point[:, 5:] - from_y], dim=1)
        met = ((moved >= -0.5) & (moved < 0.5)).all(dim=1, keepdim=True)
        weight = point[:, 3:4] * met
        total = total + weight
        largest = torch.maximum(largest, weight)
        colours = colours + point[:, :3] * met
        places = places + weight * moved
    total = total.masked_fill(largest <= 0, 1)
    return torch.cat([colours / total * largest, largest, (places / total).to(points.dtype)], dim=1)


def points_at(points, x, y):
    """The points of the pixels in columns `x` and rows `y` [batch, 1, rows, columns], zeros outside the frame."""
    height, width = points.shape[-2:]
    inside = (x >= 0) & (x < width) & (y >= 0) & (y < height)
    index = y.clamp(0, height - 1).long() * width + x.clamp(0, width - 1).long()
    index = index.flatten(2).expand(-1, points.shape[1], -1)
    return points.flatten(2).gather(2, index).reshape(points.shape) * inside


def splat(points):
    """What points tell of the centres of pixels [batch, 4, rows, columns].

    Each counts for the four centres around it by bilinear shares; divided by the sum of these where that is more than one.
    """
    height, width = points.shape[-2:]
    known, shares = 0, 0
    points = F.pad(points, (1, 1, 1, 1))
    for down, right in SQUARE:
        point = points[:, :, 1 + down :, 1 + right :][:, :, :height, :width]
        near = (1 - (right + point[:, 4:5]).abs()).clamp(min=0) * (1 - (down + point[:, 5:]).abs()).clamp(min=0)
        share = near * (point[:, 3:4] > 0)
        known = known + share * point[:, :4]
        shares = shares + share
    return known / shares.clamp(min=1)


def normalised(weights, normalisation):
    """Weights [batch, taps, rows, columns] as kernels with a sum of 1 over the taps."""
    if normalisation == "softmax":
        return F.softmax(weights, dim=1)
    squares = weights * weights
    taps = weights.shape[1]
    return (squares + SQUARED_EPSILON) / (squares.sum(dim=1, keepdim=True) + taps * SQUARED_EPSILON)


def around(image):
    """The 3x3 around each pixel, row by row, zeros beyond the border: [batch, 9, channels, rows, columns]."""
    batch, channels, height, width = image.shape
    columns = F.unfold(image, kernel_size=3, padding=1)
    return columns.reshape(batch, channels, 9, height, width).transpose(1, 2)


def centre(image):
    """The pixel itself as its only tap."""
    return image[:, None]


MORE_IMAGES = ["history", "filled", "fresh"]
TAPS = {None: 0, "centre": 1, "around": 9}


def weighed(image, taps):
    """The taps of that name."""
    return around(image) if taps == "around" else centre(image)


def apply_kernels(kernels, taps):
    """The sum of `taps` (a list of [batch, taps, channels, rows, columns]) weighed by the kernels, per channel."""
    return (kernels[:, :, None] * torch.cat(taps, dim=1)).sum(dim=1)


def averaged(image, size, stride):
    """Means of size x size pixels, weights falling from the middle along both axes, replicated at the border."""
    # Made on the device: nothing is copied to it while a CUDA graph is recorded.
    places = torch.arange(size, dtype=image.dtype, device=image.device) - (size - 1) / 2
    weights = (2 - places.abs()) / 4
    kernel = (weights[:, None] * weights).expand(image.shape[1], 1, size, size)
    padded = F.pad(image, (1, 1, 1, 1), mode="replicate")
    return F.conv2d(padded, kernel, stride=stride, groups=image.shape[1])


def halved(image):
    """Means of 4x4 pixels by (1, 3, 3, 1)/8 along both axes, replicated at the border, at half the resolution."""
    return averaged(image, 4, 2)


def smoothed(image):
    """Means of 3x3 pixels by (1, 2, 1)/4 along both axes, replicated at the border."""
    return averaged(image, 3, 1)


def above_zero(weight):
    """A weight by which can be divided, in halves too."""
    return weight.clamp(min=max(SMALLEST_WEIGHT, torch.finfo(weight.dtype).tiny))


def joined(colour, weight):
    """Three channels of colour times weight, and the weight, 0 to 1."""
    return torch.cat([colour, weight], dim=1)


def pull_push(known, levels, lowest):
    """What is `joined` spread over the frame, at 1/2^lowest of the resolution, without the weights.

    With c_0 and w_0 the parts of `known`, and sides that can be halved `levels` times:

    Pull, for l = 0 .. levels - 1:
        c_{l+1} = `halved` c'_l,  w_{l+1} = `halved` w'_l,
        w'_{l+1} = min(8 w_{l+1}, 1),  c'_{l+1} = c_{l+1} w'_{l+1} / max(w_{l+1}, 1e-8).
    Push, with `up` the bilinear doubling of resolution, L the coarsest level:
        C_L = c'_L,  W_L = w'_L,
        C_l = c'_l + (1 - w'_l) up(C_{l+1}),  W_l = w'_l + (1 - w'_l) up(W_{l+1})  for l = L - 1 .. lowest.
    The result is C / max(W, 1e-8): squares without any sample do not darken their neighbours.
    """
    pyramid = [known]
    for _ in range(levels):
        mean = halved(pyramid[-1])
        weight = (8 * mean[:, 3:]).clamp(max=1)
        pyramid.append(joined(mean[:, :3] * weight / above_zero(mean[:, 3:]), weight))
    filled = pyramid.pop()
    for finer in reversed(pyramid[lowest:]):
        filled = finer + (1 - finer[:, 3:]) * bilinear_up(filled)
    return filled[:, :3] / above_zero(filled[:, 3:])


def beside(known, picture):
    """What samples differ by from `picture`, times their weights."""
    return known[:, :3] - known[:, 3:] * picture


def spread(known, base, levels):
    """The picture at half the resolution that `known` gives; with `base`, that one corrected by it."""
    if base is None:
        return pull_push(known, levels, 1)
    return base + pull_push(joined(beside(known, bilinear_up(base)), known[:, 3:]), levels, 1)


def corrected(known, corrections, levels):
    """The picture at half the resolution: spread, and as often smoothed and corrected. And the first smooth one."""
    picture, first = spread(known, None, levels), None
    for _ in range(corrections):
        smooth = smoothed(picture)
        first = smooth if first is None else first
        picture = spread(known, smooth, levels)
    return picture, smoothed(picture) if first is None else first


def blend(known, base):
    """`known`, and the doubled `base` as far as it is not."""
    return known[:, :3] + (1 - known[:, 3:]) * bilinear_up(base)


def doubt(known, prior, fresh, levels):
    """How far what was known before is believed, at an eighth of the resolution if that is among the levels."""
    mask = known[:, 3:]
    pictures = [prior, bilinear_up(fresh)]
    error, own = [(beside(known, picture) ** 2).mean(dim=1, keepdim=True) for picture in pictures]
    squares = joined(torch.cat([error, own, torch.zeros_like(mask)], dim=1), mask)
    squares = pull_push(squares, levels, min(levels, DOUBT_LEVEL))
    error, own = squares[:, :1], squares[:, 1:2] + DOUBT_EPSILON
    return own / (own + DOUBT_SHARE * torch.clamp(error - DOUBT_ALLOWED * own, min=0))


def accumulated(known, before, share, fade):
    """`known`, and as far as it is not, `before`, faded and as far as it is believed; of points their places as they are."""
    factor = fade
    if share is not None:
        scale = known.shape[-1] // share.shape[-1]
        if scale > 1:
            share = F.interpolate(share, scale_factor=scale, mode="bilinear", align_corners=False)
        factor = fade * share
    open = 1 - known[:, 3:]
    return torch.cat([known + open * factor * before[:, :4], open * before[:, 4:]], dim=1)


def bypass(colour, mask, picture):
    """Samples where there are any, the picture elsewhere."""
    return mask * colour + (1 - mask) * picture


# Layers and networks.


class Block(nn.Module):
    """Two 3x3 convolutions, each with ReLU, zeros beyond the border."""

    def __init__(self, inputs, outputs):
        super().__init__()
        self.conv1 = nn.Conv2d(inputs, outputs, 3, padding=1)
        self.conv2 = nn.Conv2d(outputs, outputs, 3, padding=1)

    def forward(self, *inputs):
        return F.relu(self.conv2(F.relu(self.conv1(torch.cat(inputs, dim=1)))))


class PredictedKernel(nn.Conv2d):
    """A 1x1 convolution that predicts a kernel for each pixel, and its application.

    With `expand` = 2 a feature serves 2x2 pixels: channel 4k + 2y + x is tap k of pixel (x, y) of the four, the order
    of `pixel_shuffle`.
    """

    def __init__(self, features, taps, expand, normalisation):
        super().__init__(features, taps * expand * expand, 1)
        self.expand, self.normalisation = expand, normalisation

    def forward(self, features, taps):
        weights = F.pixel_shuffle(super().forward(features), self.expand)
        return apply_kernels(normalised(weights, self.normalisation), taps)


class KernelNetwork(nn.Module):
    """K: the picture filtered by predicted kernels, down and up again."""

    def __init__(self, features, config):
        super().__init__()
        deepest = len(features) - 1

        def kernel(depth, taps):
            expand = 2 if config["fold"] and depth == 0 else 1
            return PredictedKernel(features[depth], taps, expand, config["normalisation"])

        more = sum(TAPS[config[image]] for image in MORE_IMAGES)

        def up_taps(depth):
            return 10 + more if depth == 0 else 10

        self.config = config
        if config["flat"]:
            self.only = kernel(0, TAPS[config["flat"]] * config["direct"] + more)
            return
        self.down = nn.ModuleList(kernel(depth, 9) for depth in range(deepest))
        self.bottom = kernel(deepest, 9)
        self.up = nn.ModuleList(kernel(depth, up_taps(depth)) for depth in range(deepest))

    def forward(self, picture, features, images):
        config = self.config
        more = [weighed(images[name], config[name]) for name in MORE_IMAGES if config[name]]
        if config["flat"]:
            direct = [weighed(picture, config["flat"])] if config["direct"] else []
            return self.only(features[0], direct + more)
        skips = []
        for kernel, feature in zip(self.down, features):
            skips.append(kernel(feature, [around(picture)]))
            picture = F.avg_pool2d(skips[-1], 2)
        picture = self.bottom(features[-1], [around(picture)])
        for depth in reversed(range(len(self.up))):
            taps = [around(bilinear_up(picture)), centre(skips[depth])]
            if depth == 0:
                taps += more
            picture = self.up[depth](features[depth], taps)
        return picture


class WNet(nn.Module):
    """A U-Net with recurrent decoders that predicts the picture, and predicted kernels that filter it."""

    def __init__(self, config):
        super().__init__()
        self.config = config
        encoder, decoder = config["encoder"], config["decoder"]
        self.multiple = 2 ** (len(decoder) + config["fold"])
        self.pull_levels = min(len(decoder) + config["fold"], PULL_LEVELS)
        self.has_feedback = config["feedback"] != "none"
        pixels = 4 if config["fold"] else 1
        whole = 3 * (bool(config["fresh"]) and not config["coarse"])
        inputs = pixels * (3 + config["mask"] + whole + 3 * self.has_feedback) + 3 * config["coarse"]
        self.encoder = nn.ModuleList(map(Block, [inputs] + encoder[:-1], encoder))
        below = decoder[1:] + encoder[-1:]
        read = [e + b + d * config["recurrent"] for e, b, d in zip(encoder, below, decoder)]
        self.decoder = nn.ModuleList(map(Block, read, decoder))
        if config["direct"]:
            self.output = nn.Conv2d(decoder[0] + 3 * pixels * config["residual"], 3 * pixels, 1)
        if config["addition"]:
            self.addition = nn.Conv2d(decoder[0], 3 * pixels, 1)
        if config["kernels"]:
            # Folded, the finest features serve the whole pixels as well as the 2x2 squares.
            finest = decoder[:1] if config["fold"] else []
            self.kernel = KernelNetwork(finest + decoder + encoder[-1:], config)

    def initial_states(self, height, width, dtype, device="cpu"):
        """Zeros for a padded frame."""
        states = {}

        def add(name, channels, edge=1):
            states[name] = torch.zeros(1, channels, height // edge, width // edge, dtype=dtype, device=device)

        for depth, channels in enumerate(self.config["decoder"] if self.config["recurrent"] else []):
            add(f"decoder.{depth}", channels, 2 ** (depth + self.config["fold"]))
        if self.config["accumulate"] > 0:
            add("samples", 6 if self.config["points"] else 4)
        if self.has_feedback or self.config["history"]:
            add("output", 3)
        return states

    def forward(self, colour, mask, motion, states):
        config, following = self.config, {}
        if config["reproject"]:
            whole = {"samples"} if config["points"] else set()
            states = {name: (reproject if name in whole else warp)(state, motion) for name, state in states.items()}

        filled, weights, fresh, levels = colour, mask, None, self.pull_levels
        if config["prefill"]:
            known, corrections = joined(colour, mask), config["corrections"]
            if config["fresh"]:
                coarse, smooth = corrected(known, min(corrections, 1) if config["coarse"] else corrections, levels)
                fresh = bilinear_up(coarse) if config["coarse"] else blend(known, coarse)
            if config["accumulate"] > 0:
                share = None
                if config["doubt"]:
                    share = doubt(known, states["output"], smooth, levels)
                known = accumulated(known, states["samples"], share, config["accumulate"])
                following["samples"] = known
                known = splat(known) if config["points"] else known
                weights = known[:, 3:]
            filled = blend(known, corrected(known, corrections, levels)[0])
        inputs = [filled]
        if config["mask"]:
            inputs.append(weights)
        if config["fresh"] and not config["coarse"]:
            inputs.append(fresh)
        if self.has_feedback:
            inputs.append(states["output"])
        if config["fold"]:
            inputs = [F.pixel_unshuffle(image, 2) for image in inputs]
        if config["coarse"]:
            inputs.append(coarse)

        skips = [self.encoder[0](*inputs)]
        for block in self.encoder[1:]:
            skips.append(block(F.avg_pool2d(skips[-1], 2)))
        features = [skips[-1]]
        for depth in reversed(range(len(self.decoder))):
            read = [skips[depth], bilinear_up(features[0])]
            if config["recurrent"]:
                read.append(states[f"decoder.{depth}"])
            output = self.decoder[depth](*read)
            if config["recurrent"]:
                following[f"decoder.{depth}"] = output
            features.insert(0, output)

        direct = None
        if config["direct"]:
            read = torch.cat([features[0], inputs[0]], dim=1) if config["residual"] else features[0]
            direct = F.relu(self.output(read))
            if config["fold"]:
                direct = F.pixel_shuffle(direct, 2)
        picture = direct
        if config["kernels"]:
            finest = features[:1] if config["fold"] else []
            images = {"history": states.get("output"), "filled": filled, "fresh": fresh}
            picture = self.kernel(filled if direct is None else direct, finest + features, images)
        if config["addition"]:
            added = self.addition(features[0])
            picture = picture + (F.pixel_shuffle(added, 2) if config["fold"] else added)
        if config["bypass"]:
            picture = bypass(colour, mask, picture)
        if "output" in states:
            fed_back = {"direct": direct, "output": picture.clamp(0, 1), "none": picture}
            following["output"] = fed_back[config["feedback"]]
        return picture, following


def replicating_conv(inputs, outputs, stride=1):
    """A 3x3 convolution that finds the nearest pixel beyond the border."""
    return nn.Conv2d(inputs, outputs, 3, stride, padding=1, padding_mode="replicate")


class FoveaEncoder(nn.Module):
    """What is skipped over, and the same at half the resolution."""

    def __init__(self, inputs, outputs):
        super().__init__()
        self.conv1 = replicating_conv(inputs, outputs)
        self.conv2 = replicating_conv(outputs, outputs, stride=2)

    def forward(self, image):
        skip = F.elu(self.conv1(image))
        return skip, F.elu(self.conv2(skip))


class FoveaBottleneck(nn.Module):
    """Two convolutions."""

    def __init__(self, inputs, outputs):
        super().__init__()
        self.conv1 = replicating_conv(inputs, outputs)
        self.conv2 = replicating_conv(outputs, outputs)

    def forward(self, image):
        return F.elu(self.conv2(F.elu(self.conv1(image))))


class FoveaDecoder(nn.Module):
    """Up, joined with the skip, then with its own last output, which is the state."""

    def __init__(self, below, skip, outputs):
        super().__init__()
        self.conv1 = replicating_conv(below + skip, outputs)
        self.conv2 = replicating_conv(2 * outputs, outputs)
        self.norm = nn.GroupNorm(1, outputs, eps=NORM_EPSILON)

    def forward(self, below, skip, state):
        joined = F.elu(self.conv1(torch.cat([nearest_up(below), skip], dim=1)))
        return F.elu(self.norm(self.conv2(torch.cat([joined, state], dim=1))))


class DeepFovea(nn.Module):
    """The generator of DeepFovea."""

    def __init__(self, config):
        super().__init__()
        widths, bottleneck = config["encoder"], config["bottleneck"]
        self.widths = widths
        self.multiple = 2 ** len(widths)
        self.encoder = nn.ModuleList(map(FoveaEncoder, [4] + widths[:-1], widths))
        self.bottleneck = FoveaBottleneck(widths[-1], bottleneck)
        self.decoder = nn.ModuleList(map(FoveaDecoder, widths[1:] + [bottleneck], widths, widths))
        self.output = nn.Conv2d(widths[0], 3, 1)

    def initial_states(self, height, width, dtype, device="cpu"):
        """Zeros for a padded frame."""
        return {
            f"decoder.{depth}": torch.zeros(
                1, channels, height >> depth, width >> depth, dtype=dtype, device=device
            )
            for depth, channels in enumerate(self.widths)
        }

    def forward(self, colour, mask, motion, states):
        signed = 2 * colour - 1
        image = torch.cat([signed, 2 * mask - 1], dim=1)
        skips, following = [], {}
        for block in self.encoder:
            skip, image = block(image)
            skips.append(skip)
        image = self.bottleneck(image)
        for depth in reversed(range(len(self.decoder))):
            name = f"decoder.{depth}"
            image = following[name] = self.decoder[depth](image, skips[depth], states[name])
        picture = bypass(signed, mask, self.output(image))
        return (picture + 1) / 2, following


def build(config, seed):
    """The network of `config` with the seeded weights, in float32."""
    network = WNet(config) if config["kind"] == "wnet" else DeepFovea(config)
    arrays = {name: seeded_weights(name, tuple(p.shape), seed) for name, p in network.state_dict().items()}
    network.load_state_dict({name: torch.from_numpy(array) for name, array in arrays.items()})
    return network.eval().requires_grad_(False)


def run(network, frames):
    """Pictures of a clip, clamped to 0..1, and the states after it, padded.

    `frames` has (colour, mask, motion) of shapes [3 | 1 | 2, rows, columns]; all are padded by replication at right
    and bottom to the network's multiple, and pictures are cropped again.
    """
    dtype = next(network.parameters()).dtype
    height, width = frames[0][0].shape[-2:]
    right, bottom = -width % network.multiple, -height % network.multiple
    states = network.initial_states(height + bottom, width + right, dtype)
    pictures = []
    for frame in frames:
        inputs = [torch.as_tensor(image)[None].to(dtype) for image in frame]
        inputs = [F.pad(image, (0, right, 0, bottom), mode="replicate") for image in inputs]
        picture, states = network(*inputs, states)
        pictures.append(picture[0, :, :height, :width].clamp(0, 1))
    return pictures, {name: state[0] for name, state in states.items()}


# Seeded weights.

GOLDEN = 0x9E37_79B9_7F4A_7C15
MASK_64 = 2**64 - 1


def fnv1a(text):
    """FNV-1a of 64 bits."""
    value = 0xCBF2_9CE4_8422_2325
    for byte in text.encode():
        value = ((value ^ byte) * 0x100_0000_01B3) & MASK_64
    return value


def seeded_weights(name, shape, seed):
    """The float32 array `name` of a network with seeded weights.

    Number i is u = (mix(k + (i + 1) GOLDEN) >> 40) / 2^24 with k = FNV-1a(name) xor seed GOLDEN and SplitMix64's mix.
    A weight is (2u - 1) sqrt(5 / fan-in), a bias 0.05 (2u - 1), a factor of a normalisation 1 + 0.1 (2u - 1).
    """
    key = np.uint64(fnv1a(name) ^ (seed * GOLDEN & MASK_64))
    z = key + np.arange(1, np.prod(shape) + 1, dtype=np.uint64) * np.uint64(GOLDEN)
    z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58_476D_1CE4_E5B9)
    z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D0_49BB_1331_11EB)
    u = ((z ^ (z >> np.uint64(31))) >> np.uint64(40)).astype(np.float64) / 2.0**24
    if len(shape) > 1:
        middle, reach = 0.0, np.sqrt(5.0 / np.prod(shape[1:]))
    else:
        middle, reach = (1.0, 0.1) if name.endswith(".weight") else (0.0, 0.05)
    return (middle + (2.0 * u - 1.0) * reach).astype(np.float32).reshape(shape)

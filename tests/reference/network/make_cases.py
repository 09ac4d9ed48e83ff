#!/usr/bin/env python3
"""Reference cases for the engines of fovol-net: whole networks over a few frames, and single layers.

    pip install torch numpy safetensors
    python tests/reference/network/make_cases.py [FOLDER]

Writes safetensors files to FOLDER (`crates/fovol-net/tests/reference` by default). Everything is computed in float64
from float32 inputs and weights, and rounded to float32 at the end. Weights are seeded and not in the files, but for
those of single layers.

A network's file has for each frame t `input.t` [3, H, W], `mask.t` [1, H, W], `motion.t` [2, H, W] where the network
uses motion, and `output.t` [3, H, W], clamped and cropped. After the last frame it has each state, padded and not
clamped, as `state.NAME` [c, h, w]; where they are large only `state_moments.NAME` (mean, mean of squares) and
`state_samples.NAME`, every n-th of the flattened state with n = max(1, length / 64), at most 64. The header says
`network`, `seed`, `config`, `width`, `height`, `frames`.

`layers.safetensors` has `NAME.in0`, `NAME.in1` ..., `NAME.weight` and `NAME.bias` where there are any, and
`NAME.out`; the header says for each NAME as JSON what the layer is.

`state_dict.pt` and `state_dict.safetensors` are the same weights of a very small network, as PyTorch saves them and
as a weights file. `checkpoint.pt` has them once more as training scripts save them: with an optimiser and an epoch,
`module.` before the names, and tensors of several types that lie in their storages in several ways.

Prints how far float32 is from float64, and whether states stay bounded.
"""

import argparse
import json
from pathlib import Path

import numpy as np
import torch
import torch.nn.functional as F
from safetensors.numpy import save_file

import networks

SEED = 7
# Files with all states stay below this.
LARGEST_FILE = 400_000
# Very small networks that have each option in another company than the named ones.
VARIANTS = {
    "variant-masked": networks.wnet([6, 8, 10], [6, 8], feedback="none", mask=True, history="around", reproject=True),
    "variant-softmax": networks.wnet([8, 12], [8], feedback="output", normalisation="softmax", bypass=True),
    "variant-folded": networks.wnet([6, 8, 10], [6, 8], fold=True, kernels=False, prefill=True, bypass=True),
    "variant-history": networks.wnet(
        [6, 8, 10], [5, 7], fold=True, normalisation="softmax", history="around", reproject=True
    ),
    "variant-filled": networks.wnet([6, 8, 10], [5, 7], history="around", filled="centre", **networks.ALL_ON),
    "variant-flat": networks.wnet([6, 8], [5], flat="around", mask=True, normalisation="softmax"),
    "variant-accumulating": networks.wnet([6, 8], [5], mask=True, prefill=True, accumulate=0.6, corrections=1),
    "variant-direct": networks.wnet([6, 8], [5], **networks.OURS | {"residual": True, "direct": True, "corrections": 2}),
    "variant-fresh": networks.wnet([6, 8], [5], **networks.OURS | {"coarse": False, "corrections": 2}),
    "variant-interpolated": networks.wnet([6, 8], [5], **networks.OURS | {"points": False}),
    "variant-samples": networks.wnet([6, 8, 10], [5, 7], feedback="none", direct=False),
    "variant-fovea": {"kind": "deepfovea", "encoder": [5, 7], "bottleneck": 6},
}
CONFIGS = networks.CONFIGS | VARIANTS
# Name, width, height, frames, seed.
CASES = [(name, 37, 29, 5, SEED) for name in networks.CONFIGS]
CASES += [("wnet-paper", 1, 1, 2, SEED), ("wnet-paper", 64, 40, 2, SEED)]
# With the seed above most of this network's picture is cut to black by its last ReLU; with this one hardly any is.
CASES += [("deepfovea-fvn", 37, 29, 2, 8)]
CASES += [(name, 21, 13, 3, SEED) for name in VARIANTS]
HERE = Path(__file__).resolve().parent
DEFAULT_FOLDER = HERE.parents[2] / "crates/fovol-net/tests/reference"


def frames(width, height, count):
    """Colour, mask and motion of a clip: a moving pattern, a moving fovea in sparse samples, swirling motion."""
    random = np.random.default_rng(1)
    x, y = np.meshgrid(np.arange(width), np.arange(height))
    for t in range(count):
        fovea = np.hypot(x - width * (0.4 + 0.05 * t), y - height * (0.5 - 0.03 * t))
        density = np.where(fovea < 0.2 * min(width, height) + 0.5, 0.8, 0.15)
        mask = (random.random((1, height, width)) < density).astype(np.float32)
        waves = [np.sin(0.21 * (1 + c) * x + 0.17 * (3 - c) * y + 0.4 * t + c) for c in range(3)]
        colour = (0.5 + 0.5 * np.stack(waves)) * mask
        motion = [3 * np.sin(0.11 * x + 0.07 * y + 0.5 * t + 0.3), 3 * np.cos(0.09 * x - 0.13 * y + 0.7 * t)]
        yield colour.astype(np.float32), mask, np.stack(motion).astype(np.float32)


def numpy32(tensor):
    """The tensor rounded to float32."""
    return np.ascontiguousarray(tensor.numpy().astype(np.float32))


def save(arrays, path, **facts):
    """Writes a file, and says how large it is."""
    save_file(arrays, path, metadata={name: str(fact) for name, fact in facts.items()})
    print(f"{path.name}: {path.stat().st_size} bytes")


def size(arrays):
    """Bytes of all arrays."""
    return sum(array.nbytes for array in arrays.values())


def state_arrays(states, room):
    """All states if they fit in `room` bytes, else what is known of each."""
    whole = {f"state.{name}": numpy32(state) for name, state in states.items()}
    if size(whole) <= room:
        return whole
    some = {}
    for name, state in states.items():
        flat = state.flatten()
        some[f"state_moments.{name}"] = numpy32(torch.stack([flat.mean(), (flat * flat).mean()]))
        some[f"state_samples.{name}"] = numpy32(flat[:: max(1, len(flat) // 64)][:64])
    return some


def network_case(name, width, height, count, seed, folder):
    """One network over one clip."""
    config = CONFIGS[name]
    clip = list(frames(width, height, count))
    network = networks.build(config, seed)
    # float32 first: double() changes the network itself.
    single, single_states = networks.run(network, clip)
    pictures, states = networks.run(network.double(), clip)

    arrays = {}
    for t, ((colour, mask, motion), picture) in enumerate(zip(clip, pictures)):
        arrays |= {f"input.{t}": colour, f"mask.{t}": mask, f"output.{t}": numpy32(picture)}
        if config.get("reproject"):
            arrays[f"motion.{t}"] = motion
    # Headers take a few kilobytes.
    arrays |= state_arrays(states, LARGEST_FILE - 4096 - size(arrays))

    suffix = "" if seed == SEED else f"_seed{seed}"
    path = folder / f"{name}_{width}x{height}{suffix}.safetensors"
    facts = {"width": width, "height": height, "frames": count}
    save(arrays, path, network=name, seed=seed, config=json.dumps(config), **facts)
    differences = [(a - b).abs().max().item() for a, b in zip(single, pictures)]
    print(f"  float32 - float64, pictures frame by frame: {' '.join(f'{d:.1e}' for d in differences)}")
    for state, exact in states.items():
        difference = (single_states[state] - exact).abs().max() / exact.abs().max()
        print(f"  float32 - float64, state {state}, of its largest: {difference:.1e}")
    return network


def check_bounds(name, network):
    """Prints what happens over 16 frames."""
    pictures, _ = networks.run(network, list(frames(37, 29, 16)))
    for t in [0, 4, 15]:
        _, states = networks.run(network, list(frames(37, 29, t + 1)))
        picture = pictures[t]
        low, high = (picture <= 0).double().mean(), (picture >= 1).double().mean()
        largest = ", ".join(f"{state} {tensor.abs().max():.3g}" for state, tensor in states.items())
        print(
            f"  {name} frame {t}: mean {picture.mean():.3f}, deviation {picture.std():.3f}, "
            f"{100 * low:.0f} % black, {100 * high:.0f} % white; largest of states: {largest}"
        )


class Layers:
    """Gathers single layers."""

    def __init__(self):
        self.arrays, self.facts = {}, {}

    def array(self, name, shape, low=-1.0, high=1.0):
        """Numbers that depend on the name alone."""
        random = np.random.default_rng(networks.fnv1a(name))
        self.arrays[name] = random.uniform(low, high, shape).astype(np.float32)
        return self.double(name)

    def double(self, name):
        """An array as the layers take it."""
        return torch.from_numpy(self.arrays[name]).double()[None]

    def parameters(self, name, weight_shape):
        """Weights and biases."""
        fan_in = int(np.prod(weight_shape[1:]))
        weight = self.array(f"{name}.weight", weight_shape, -((3 / fan_in) ** 0.5), (3 / fan_in) ** 0.5)
        return weight[0], self.array(f"{name}.bias", weight_shape[:1])[0]

    def add(self, name, out, **facts):
        """A finished layer."""
        self.arrays[f"{name}.out"] = numpy32(out[0])
        self.facts[name] = json.dumps(facts)


RESIZES = {"same": lambda image: image, "bilinear": networks.bilinear_up, "nearest": networks.nearest_up}
ACTIVATIONS = {"none": lambda image: image, "relu": F.relu, "elu": F.elu}
PADDINGS = {"zero": "constant", "replicate": "replicate"}
TAPS = {"around": networks.around, "centre": networks.centre}


def add_conv(layers, name, reads, outputs, size=3, stride=1, padding="zero", activation="none", shape=(6, 10)):
    """A convolution over `reads`, pairs of channels and resize, at the resolution `shape`."""
    images = []
    for i, (channels, resize) in enumerate(reads):
        factor = 1 if resize == "same" else 2
        image = layers.array(f"{name}.in{i}", (channels, shape[0] // factor, shape[1] // factor))
        images.append(RESIZES[resize](image))
    image = torch.cat(images, dim=1)
    weight, bias = layers.parameters(name, (outputs, image.shape[1], size, size))
    border = size // 2
    padded = F.pad(image, (border, border, border, border), mode=PADDINGS[padding])
    out = ACTIVATIONS[activation](F.conv2d(padded, weight, bias, stride=stride))
    facts = {"size": size, "stride": stride, "padding": padding, "activation": activation}
    layers.add(name, out, kind="conv", resizes=[resize for _, resize in reads], **facts)


def add_filter(layers, name, images, normalisation, expand=1, features=6, channels=3, shape=(6, 8)):
    """A predicted kernel over `images`, pairs of resize and taps, at the resolution `shape`; in0 is the features."""
    feature = layers.array(f"{name}.in0", (features, shape[0] // expand, shape[1] // expand))
    taps = []
    for i, (resize, which) in enumerate(images):
        factor = 1 if resize == "same" else 2
        edges = (shape[0] // factor, shape[1] // factor)
        taps.append(TAPS[which](RESIZES[resize](layers.array(f"{name}.in{i + 1}", (channels, *edges)))))
    count = sum(tap.shape[1] for tap in taps)
    weight, bias = layers.parameters(name, (count * expand * expand, features, 1, 1))
    kernel = networks.PredictedKernel(features, count, expand, normalisation).double().requires_grad_(False)
    kernel.load_state_dict({"weight": weight, "bias": bias})
    facts = {"normalisation": normalisation, "expand": expand}
    layers.add(name, kernel(feature, taps), kind="filter", images=images, **facts)


def add_warp(layers, name, level, shape):
    """A state of `shape` moved along smooth motion at 2^level times the resolution."""
    height, width = (edge << level for edge in shape)
    (_, _, motion), = frames(width, height, 1)
    state = layers.array(f"{name}.in0", (4, *shape))
    layers.arrays[f"{name}.in1"] = motion * np.float32(1 << level)
    layers.add(name, networks.warp(state, layers.double(f"{name}.in1")), kind="warp", level=level)


def points_case(layers, name, shape):
    """Random points as `in0`."""
    random = np.random.default_rng(networks.fnv1a(name))
    weights = random.uniform(0.1, 1, (1, *shape)) * (random.random((1, *shape)) < 0.5)
    points = np.concatenate([random.random((3, *shape)) * weights, weights, random.uniform(-0.5, 0.5, (2, *shape))])
    layers.arrays[f"{name}.in0"] = (points * (weights > 0)).astype(np.float32)
    return layers.double(f"{name}.in0")


def add_points(layers):
    """What is done with points."""
    (_, _, motion), = frames(13, 9, 1)
    points = points_case(layers, "reproject", (9, 13))
    layers.arrays["reproject.in1"] = motion
    moved = networks.reproject(points, layers.double("reproject.in1"))
    layers.add("reproject", moved, kind="reproject")
    layers.add("splat", networks.splat(points_case(layers, "splat", (7, 11))), kind="splat")
    before = points_case(layers, "accumulate_points", (4, 6))
    known = known_case(layers, "accumulate_points_known", (4, 6), 0.3, 1.0)
    layers.arrays["accumulate_points.in0"] = layers.arrays.pop("accumulate_points_known.in0")
    layers.arrays["accumulate_points.in1"] = numpy32(before[0])
    accumulated = networks.accumulated(known, before, None, 0.75)
    layers.add("accumulate_points", accumulated, kind="accumulate", fade=0.75)


def known_case(layers, name, shape, density, least):
    """Random samples of weights from `least` to 1 as `in0`; the left half has none where `density` is below 0.01."""
    random = np.random.default_rng(networks.fnv1a(name))
    mask = (random.random((1, *shape)) < density).astype(np.float32)
    if density < 0.01:
        mask[:, :, : shape[1] // 2] = 0
    if least < 1:
        mask *= random.uniform(least, 1.0, mask.shape).astype(np.float32)
    layers.array(f"{name}.in0", (4, *shape), 0.0, 1.0)
    layers.arrays[f"{name}.in0"][3] = 1
    layers.arrays[f"{name}.in0"] *= mask
    return layers.double(f"{name}.in0")


def add_spread(layers, name, shape, density, levels, least=1.0, corrects=False):
    """Samples spread; `in1` is what they correct."""
    known = known_case(layers, name, shape, density, least)
    half = (3, shape[0] // 2, shape[1] // 2)
    base = layers.array(f"{name}.in1", half, 0.0, 1.0) if corrects else None
    layers.add(name, networks.spread(known, base, levels), kind="spread", levels=levels)


def add_fills(layers):
    """Everything that fills frames."""
    add_spread(layers, "spread_5_levels", (32, 64), 0.05, 5)
    add_spread(layers, "spread_1_level", (6, 10), 0.5, 1)
    add_spread(layers, "spread_none", (16, 16), 0.0, 4)
    add_spread(layers, "spread_weights", (16, 48), 0.3, 4, least=0.2)
    # Squares of the coarsest level without samples.
    add_spread(layers, "spread_gaps", (16, 48), 0.009, 4)
    add_spread(layers, "spread_corrects", (16, 48), 0.3, 4, least=0.2, corrects=True)
    layers.add("smooth", networks.smoothed(layers.array("smooth.in0", (3, 5, 7))), kind="smooth")
    known = known_case(layers, "blend", (6, 10), 0.5, 0.2)
    layers.add("blend", networks.blend(known, layers.array("blend.in1", (3, 3, 5), 0.0, 1.0)), kind="blend")
    for levels in [2, 4]:
        name = f"doubt_{levels}_levels"
        known = known_case(layers, name, (16, 48), 0.1, 0.3)
        prior = layers.array(f"{name}.in1", (3, 16, 48), 0.0, 1.0)
        fresh = layers.array(f"{name}.in2", (3, 8, 24), 0.0, 1.0)
        layers.add(name, networks.doubt(known, prior, fresh, levels), kind="doubt", levels=levels)
    known = known_case(layers, "accumulate", (16, 24), 0.3, 1.0)
    before = layers.array("accumulate.in1", (4, 16, 24), 0.0, 1.0)
    share = layers.array("accumulate.in2", (1, 2, 3), 0.0, 1.0)
    layers.add("accumulate", networks.accumulated(known, before, share, 0.5), kind="accumulate", fade=0.5)
    known = known_case(layers, "accumulate_all", (4, 6), 0.3, 1.0)
    before = layers.array("accumulate_all.in1", (4, 4, 6), 0.0, 1.0)
    layers.add("accumulate_all", networks.accumulated(known, before, None, 0.75), kind="accumulate", fade=0.75)


def layer_cases(folder):
    """Single layers, all in one file."""
    layers = Layers()
    add_conv(layers, "conv3_zero", [(5, "same")], 7)
    add_conv(layers, "conv3_zero_joined", [(3, "same"), (4, "bilinear"), (2, "same")], 5, activation="relu")
    add_conv(layers, "conv3_zero_stride2", [(4, "same")], 6, stride=2, activation="relu")
    add_conv(layers, "conv3_replicate", [(5, "same")], 7, padding="replicate", activation="elu")
    nearest = [(4, "nearest"), (3, "same")]
    add_conv(layers, "conv3_replicate_joined", nearest, 5, padding="replicate", activation="elu")
    add_conv(layers, "conv3_replicate_stride2", [(4, "same")], 6, stride=2, padding="replicate", activation="elu")
    add_conv(layers, "conv3_zero_one_pixel", [(3, "same")], 4, shape=(1, 1))
    add_conv(layers, "conv3_replicate_one_pixel", [(3, "same")], 4, padding="replicate", shape=(1, 1))
    add_conv(layers, "conv1", [(9, "same")], 3, size=1)
    add_conv(layers, "conv1_joined", [(4, "bilinear"), (5, "same")], 12, size=1, activation="relu")
    # More channels than vectors have lanes, and not a multiple of them.
    add_conv(layers, "conv3_zero_wide", [(19, "same"), (18, "bilinear")], 37, shape=(6, 18), activation="relu")

    image = layers.array("pool.in0", (5, 6, 8))
    layers.add("pool", F.avg_pool2d(image, 2), kind="pool")
    image = layers.array("space_to_depth.in0", (3, 6, 8))
    layers.add("space_to_depth", F.pixel_unshuffle(image, 2), kind="space-to-depth")
    image = layers.array("depth_to_space.in0", (12, 3, 4))
    layers.add("depth_to_space", F.pixel_shuffle(image, 2), kind="depth-to-space")
    image = layers.array("norm_elu.in0", (6, 5, 7), -1.0, 3.0)
    weight, bias = layers.parameters("norm_elu", (6,))
    image = F.elu(F.group_norm(image, 1, weight, bias, eps=networks.NORM_EPSILON))
    layers.add("norm_elu", image, kind="norm", activation="elu")
    pictures = [layers.array(f"add.in{i}", (3, 4, 5)) for i in range(2)]
    layers.add("add", pictures[0] + pictures[1], kind="add")
    colour = layers.array("bypass.in0", (3, 4, 5), 0.0, 1.0)
    layers.arrays["bypass.in1"] = (layers.array("bypass.in1", (1, 4, 5)) > 0).float().numpy()[0]
    picture = layers.array("bypass.in2", (3, 4, 5))
    layers.add("bypass", networks.bypass(colour, layers.double("bypass.in1"), picture), kind="bypass")

    taps = {
        9: [("same", "around")],
        10: [("bilinear", "around"), ("same", "centre")],
        19: [("bilinear", "around"), ("same", "centre"), ("same", "around")],
    }
    for normalisation in ["squared", "softmax"]:
        for count, images in taps.items():
            for expand in [1, 2]:
                add_filter(layers, f"filter_{normalisation}_{count}_expand{expand}", images, normalisation, expand)
    # Kernels made of epsilon alone: all weights are 0.
    add_filter(layers, "filter_squared_zero", taps[9], "squared")
    for name in ["weight", "bias"]:
        layers.arrays[f"filter_squared_zero.{name}"][...] = 0
    image = layers.double("filter_squared_zero.in1")
    layers.arrays["filter_squared_zero.out"] = numpy32(networks.around(image).mean(dim=1)[0])

    add_warp(layers, "warp_level0", 0, (9, 11))
    add_warp(layers, "warp_level2", 2, (5, 6))
    add_fills(layers)
    add_points(layers)
    save(layers.arrays, folder / "layers.safetensors", **layers.facts)


def state_dict_case(folder):
    """The weights of a very small network in PyTorch's format and in a weights file."""
    config = networks.wnet([4, 4], [4])
    network = networks.build(config, SEED)
    path = folder / "state_dict.pt"
    torch.save(network.state_dict(), path)
    print(f"{path.name}: {path.stat().st_size} bytes")
    arrays = {name: numpy32(tensor) for name, tensor in network.state_dict().items()}
    save(arrays, folder / "state_dict.safetensors", **{"fovolnet.config": json.dumps(config)})


def in_columns(tensor):
    """The same tensor with its last dimension first in memory."""
    return tensor.movedim(-1, 0).contiguous().movedim(0, -1)


def in_the_middle(tensor):
    """The same tensor as a part of a larger storage, every third number."""
    around = torch.full((tensor.shape[0] + 2, *tensor.shape[1:], 3), 9.0)
    around[1:-1, ..., 1] = tensor
    return around[1:-1, ..., 1]


# How `checkpoint.pt` keeps each tensor, in turn.
KEEPINGS = [
    torch.Tensor.half,
    torch.Tensor.bfloat16,
    torch.Tensor.double,
    in_columns,
    in_the_middle,
    torch.nn.Parameter,
    lambda tensor: in_columns(tensor.half()),
]


def checkpoint_case(folder):
    """The same weights as a training script saves them."""
    network = networks.build(networks.wnet([4, 4], [4]), SEED)
    optimiser = torch.optim.Adam(network.output.requires_grad_().parameters(), lr=1e-3)
    sum(parameter.sum() for parameter in network.output.parameters()).backward()
    optimiser.param_groups[0]["lr"] = 0.0
    optimiser.step()
    state = torch.nn.DataParallel(network).state_dict()
    # Two tensors that are parts of one storage.
    joined = torch.cat([state[f"module.encoder.{depth}.conv1.bias"] for depth in range(2)])
    for i, name in enumerate(state):
        state[name] = KEEPINGS[i % len(KEEPINGS)](state[name])
    for depth in range(2):
        state[f"module.encoder.{depth}.conv1.bias"] = joined[4 * depth : 4 * depth + 4]
    path = folder / "checkpoint.pt"
    facts = {"epoch": 3, "losses": [0.5, 0.25], "best": None, "seed": 2**64 - 1, "rate": (1, 2.0, "cosine")}
    torch.save(facts | {"model": state, "optimizer": optimiser.state_dict()}, path)
    print(f"{path.name}: {path.stat().st_size} bytes")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", nargs="?", type=Path, default=DEFAULT_FOLDER)
    folder = parser.parse_args().folder
    folder.mkdir(parents=True, exist_ok=True)
    for name, width, height, count, seed in CASES:
        network = network_case(name, width, height, count, seed, folder)
        if width > 1:
            check_bounds(name, network)
    layer_cases(folder)
    state_dict_case(folder)
    checkpoint_case(folder)
    print(f"together: {sum(path.stat().st_size for path in folder.iterdir())} bytes")


if __name__ == "__main__":
    main()

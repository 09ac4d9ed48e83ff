#!/usr/bin/env python3
"""Reference values for the losses of training/fovol-train.

    pip install torch torchvision safetensors pytorch-msssim lpips
    python tests/reference/training/make_losses.py [FOLDER]

Writes to FOLDER (this one by default):

* `losses.safetensors`: a small clip and what is to come out of it. `outputs` and `references` [T, N, 3, H, W] are
  bytes, 255 is 1; to the i-th number of `outputs` one adds (i mod 997)·1e-6, so that no differences are 0, where
  absolute values have no slope. `motion` [T, N, 2, H, W] is signed bytes, 8 is a pixel. `gradient` is every 11th number of the
  gradient of the paper's loss with respect to the outputs. The header's `values` are numbers as JSON.
* `losses_vgg19.safetensors`, `losses_vgg16.safetensors`: made-up weights with few channels under the names of
  torchvision, in float16; the second also has the heads of LPIPS.
* `losses_legacy.pth`: a VGG-16 of one channel as PyTorch saved parameters before 1.6. The weights of its second
  convolution are 1, 5, 9, 2, 6, 10, 3, 7, 11.

The values come from PyTorch in float64, pytorch-msssim and lpips, or are what the paper and the authors' public
training code say, written down as plainly as possible.
"""

import argparse
import collections
import json
import math
from pathlib import Path

import lpips
import numpy as np
import torch
import torch.nn.functional as F
import torchvision
from pytorch_msssim import ms_ssim, ssim
from safetensors.torch import save_file

FRAMES, HEIGHT, WIDTH = 4, 20, 24
VGG19 = [4, 4, "M", 5, 5, "M", 5, 6, 6, 5, "M", 6, 5, 6, 5, "M", 5, 6, 5, 6]
VGG16 = [4, 4, "M", 5, 5, "M", 5, 6, 5, "M", 6, 5, 6, "M", 5, 6, 5]
FOVOLNET = [0.52879148, 0.13693107, 0.05858061, 0.09629559, 0.17940125]
DEEPFOVEA = [1 / 16, 1 / 28, 1 / 40, 1 / 100, 1 / 9]
DEEPFOVEA_FRAMES = [1e-5, 5e-5, 1e-4, 5e-4, 1e-3, 5e-3, 0.01, 0.05, 0.1, 0.5]


def smooth_noise(generator, *shape):
    """Noise of two sizes in 0...1."""
    *batch, height, width = shape
    noise = torch.zeros(shape, dtype=torch.float64)
    for size, weight in [(1, 0.4), (4, 0.6)]:
        coarse = torch.rand([*batch, height // size + 2, width // size + 2], generator=generator, dtype=torch.float64)
        flat = coarse.reshape(1, -1, *coarse.shape[-2:])
        noise += weight * F.interpolate(flat, (height, width), mode="bilinear").reshape(shape)
    return noise


def clip(generator):
    """Outputs, references (multiples of 1/255) and motion (multiples of 1/8 of a pixel)."""
    # A texture that moves by (2, -1) pixels a frame, and changes a little.
    texture = smooth_noise(generator, 1, 1, 3, HEIGHT + FRAMES, WIDTH + 2 * FRAMES)
    moved = [texture[..., t : t + HEIGHT, 2 * (FRAMES - t) : 2 * (FRAMES - t) + WIDTH] for t in range(FRAMES)]
    noise = lambda channels: smooth_noise(generator, FRAMES, 1, channels, HEIGHT, WIDTH) - 0.5
    references = torch.cat(moved) + 0.03 * noise(3)
    outputs = (references + 0.3 * noise(3)).clamp(0, 1)
    motion = torch.tensor([-2.0, 1.0]).double().view(1, 1, 2, 1, 1) + noise(2)
    byte = lambda x: (x * 255).round() / 255
    apart = torch.arange(outputs.numel()).view(outputs.shape) % 997 * 1e-6
    return byte(outputs) + apart, byte(references), (motion * 8).round() / 8


def vgg(layers, generator):
    """torchvision's layers with few channels."""
    features = torchvision.models.vgg.make_layers(layers)
    for parameter in features.parameters():
        fan_in = parameter[0].numel()
        scale = math.sqrt(6 / fan_in) if parameter.dim() == 4 else 0.1
        values = (torch.rand(parameter.shape, generator=generator, dtype=torch.float64) * 2 - 1) * scale
        # As they will be read from the file.
        parameter.data = values.half().double()
        parameter.requires_grad_(False)
    return features.double()


def fovolnet_vgg(features, output, reference):
    """The slices of the authors' code, with torchvision's ReLUs that overwrite their input."""
    loss = 0
    for (start, end), weight in zip([(0, 3), (3, 8), (8, 17), (17, 26), (26, 35)], FOVOLNET):
        output, reference = features[start:end](output), features[start:end](reference)
        loss = loss + (output.clone() - reference.clone()).abs().mean() * weight
    return loss


def deepfovea_vgg(features, output, reference):
    mean = torch.tensor([0.485, 0.456, 0.406], dtype=torch.float64).view(1, 3, 1, 1)
    deviation = torch.tensor([0.229, 0.224, 0.225], dtype=torch.float64).view(1, 3, 1, 1)
    output, reference = (output - mean) / deviation, (reference - mean) / deviation
    loss, last = 0, 0
    # Up to and with relu1_2, relu2_2, relu3_2, relu4_2, relu5_2.
    for end, weight in zip([4, 9, 14, 23, 32], DEEPFOVEA):
        output, reference = features[last:end](output), features[last:end](reference)
        loss = loss + (output - reference).abs().mean() * weight
        last = end
    return loss


def small_lpips(features, generator):
    """lpips.LPIPS with the backbone `features` and made-up heads."""
    original = torchvision.models.vgg16
    torchvision.models.vgg16 = lambda **_: type("Backbone", (), {"features": features})
    measure = lpips.LPIPS(net="vgg", pretrained=False, pnet_rand=True, verbose=False)
    torchvision.models.vgg16 = original
    heads = {}
    for stage, channels in enumerate([4, 5, 5, 6, 5]):
        head = torch.rand([1, channels, 1, 1], generator=generator, dtype=torch.float64).half()
        convolution = torch.nn.Conv2d(channels, 1, 1, bias=False).double()
        convolution.weight.data = head.double()
        measure.lins[stage].model[1] = convolution
        heads[f"lin{stage}.model.1.weight"] = head
    measure.scaling_layer.double()
    return measure.eval(), heads


def warp(image, motion):
    """`image` where `motion` leads, by grid_sample: the outside is 0, corners are not aligned."""
    height, width = image.shape[-2:]
    y, x = torch.meshgrid(torch.arange(height).double(), torch.arange(width).double(), indexing="ij")
    grid = torch.stack([(2 * (x + motion[:, 0]) + 1) / width - 1, (2 * (y + motion[:, 1]) + 1) / height - 1], -1)
    return F.grid_sample(image, grid, mode="bilinear", padding_mode="zeros", align_corners=False)


def block_matching(current, previous, radius=7, patch=5, sigma=2.0):
    """The authors' single-level search: the best whole offset of each pixel, and by how much it is the best."""
    grey = lambda rgb: (rgb * torch.tensor([0.2989, 0.587, 0.114]).double().view(1, 3, 1, 1)).sum(1, keepdim=True)
    count = 2 * radius + 1
    height, width = current.shape[-2:]
    shifted = F.unfold(grey(previous), count, padding=radius).view(1, count * count, height, width)
    x = torch.arange(patch).double() - (patch - 1) / 2
    window = torch.exp(-(x[:, None] ** 2 + x[None] ** 2) / (2 * sigma**2))
    window = (window / window.sum()).expand(count * count, 1, patch, patch)
    distance = F.conv2d((grey(current) - shifted).abs(), window, padding=patch // 2, groups=count * count)
    two, best = distance.topk(2, dim=1, largest=False)
    best = best[:, 0]
    return torch.stack([best % count - radius, best // count - radius], 1), (two[:, 1] - two[:, 0]).min().item()


def paper_loss(features, outputs, references, flows):
    """L of the paper with the normalisation of the authors' code, and all pairs."""
    frames = len(outputs)
    l1 = lambda a, b: (a - b).abs().mean()
    spatial = perceptual = plain = temporal = flow = 0
    for i in range(frames):
        weight = (1 - math.exp(-0.5 * i)) / frames
        perceptual = perceptual + weight * fovolnet_vgg(features, outputs[i], references[i])
        plain = plain + weight * l1(outputs[i], references[i])
        for j in range(i):
            temporal = temporal + l1(outputs[i] - outputs[j], references[i] - references[j])
        if i > 0:
            flow = flow + l1(outputs[i], warp(outputs[i - 1], flows[i]))
    temporal = temporal / (frames * (frames - 1) / 2)
    spatial = 0.9 * perceptual + 0.1 * plain
    total = 0.8 * spatial + 1.0 * (1.0 * temporal + 0.1 * flow)
    return {
        "total": total,
        "spatial": spatial,
        "perceptual": perceptual,
        "l1": plain,
        "temporal": temporal,
        "flow": flow,
    }


def deepfovea_fvn_loss(features, outputs, references, flows):
    """What the authors of FoVolNet trained DeepFovea with."""
    spatial = sum(fovolnet_vgg(features, y, r) for y, r in zip(outputs, references)) / len(outputs)
    pairs = range(1, len(outputs))
    return spatial + 0.1 * sum((outputs[i] - warp(outputs[i - 1], flows[i])).abs().mean() for i in pairs)


def deepfovea_loss(features, outputs, references, flows):
    """100 VGG + 20 flow of DeepFovea, on pictures in -1...1 where flow is concerned."""
    frames = len(outputs)
    spatial = sum(
        DEEPFOVEA_FRAMES[i] * deepfovea_vgg(features, outputs[i], references[i]) for i in range(frames)
    )
    flow = 0
    signed = lambda pictures: [2 * p - 1 for p in pictures]
    # The outside of a frame is -1 here, which is black.
    follow = lambda picture, motion: 2 * warp((picture + 1) / 2, motion) - 1
    y, r = signed(outputs), signed(references)
    for i in range(1, frames):
        certain = ((r[i] - follow(r[i - 1], flows[i])).abs().sum(1, keepdim=True) < 0.1).double()
        flow = flow + (certain * (y[i] - follow(y[i - 1], flows[i])).abs()).mean()
        print(f"{certain.mean():.0%} of frame {i} can be followed")
    return 100 * spatial / frames + 20 * flow / (frames - 1)


def gradient_l1(output, reference):
    """As Intel's and the authors' training code has it."""
    def gradient(x):
        corner = x[..., :-1, :-1]
        return torch.cat([x[..., 1:, :-1] - corner, x[..., :-1, 1:] - corner], -3)

    return (gradient(output) - gradient(reference)).abs().mean()


def large_pair():
    """Pictures [1, 3, 167, 190] that integers define: multiples of 1/255."""
    c, y, x = np.meshgrid(np.arange(3), np.arange(167), np.arange(190), indexing="ij")
    triangle = lambda k, period: np.abs(k % (2 * period) - period) * 255 // period
    reference = (triangle(3 * x + y + 20 * c, 64) + triangle(2 * y + 200 - x, 23) + (x * y * (c + 3)) % 97) // 3
    output = np.clip(reference + (x * 7 + y * 13 + c * 5) % 41 - 20, 0, 255)
    return [torch.from_numpy(p).double()[None] / 255 for p in (output, reference)]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", nargs="?", type=Path, default=Path(__file__).resolve().parent)
    folder = parser.parse_args().folder
    generator = torch.Generator().manual_seed(5)

    outputs, references, motion = clip(generator)
    vgg19, vgg16 = vgg(VGG19, generator), vgg(VGG16, generator)
    measure, heads = small_lpips(vgg16, generator)
    # lpips measures between two pictures of -1...1; its slices of the backbone are made anew with each LPIPS.
    first = [p[3] * 2 - 1 for p in (outputs, references)]

    values = {}
    leaves = outputs.clone().requires_grad_()
    for name, value in paper_loss(vgg19, list(leaves), list(references), list(motion)).items():
        if name == "total":
            (gradient,) = torch.autograd.grad(value, leaves, retain_graph=True)
        values[f"paper.{name}"] = value.item()
    values["deepfovea_fvn"] = deepfovea_fvn_loss(vgg19, outputs, references, motion).item()
    values["deepfovea"] = deepfovea_loss(vgg19, outputs, references, motion).item()
    values["fovolnet_vgg"] = fovolnet_vgg(vgg19, outputs[3], references[3]).item()
    values["deepfovea_vgg"] = deepfovea_vgg(vgg19, outputs[3], references[3]).item()
    values["lpips"] = measure(*first).mean().item()
    values["gradient_l1"] = gradient_l1(outputs[3], references[3]).item()
    values["ssim"] = ssim(outputs[3], references[3], data_range=1.0).item()
    large = large_pair()
    values["ssim_large"] = ssim(*large, data_range=1.0).item()
    values["ms_ssim_large"] = ms_ssim(*large, data_range=1.0).item()
    offsets, margin = block_matching(references[1], references[0])
    print("the best offset of a pixel is better than the second by", margin)
    for name, value in values.items():
        print(f"{name:20} {value:.9f}")

    save_file(
        {
            "outputs": (outputs * 255).round().to(torch.uint8),
            "references": (references * 255).round().to(torch.uint8),
            "motion": (motion * 8).round().to(torch.int8),
            "warped": warp(references[0], motion[1]).float(),
            "offsets": offsets.to(torch.int8),
            "gradient": gradient.flatten()[::11].float().contiguous(),
        },
        folder / "losses.safetensors",
        {"values": json.dumps(values)},
    )
    named = lambda features: {f"features.{k}": v.half() for k, v in features.state_dict().items()}
    save_file(named(vgg19), folder / "losses_vgg19.safetensors")
    save_file(named(vgg16) | heads, folder / "losses_vgg16.safetensors")
    # One channel each; one weight is not laid out row by row, and lies within a larger storage.
    legacy = vgg([1 if width != "M" else width for width in VGG16], generator).float().state_dict()
    legacy["2.weight"] = torch.arange(12.0).view(3, 4)[:, 1:].t()[None, None]
    legacy = [(f"features.{name}", torch.nn.Parameter(tensor)) for name, tensor in legacy.items()]
    legacy += [("classifier.6.bias", torch.nn.Parameter(torch.zeros(2)))]
    torch.save(
        collections.OrderedDict(legacy), folder / "losses_legacy.pth", _use_new_zipfile_serialization=False
    )


if __name__ == "__main__":
    main()

"""Layers of the networks in PyTorch, for `torch_network.py`: earlier samples, filling, convolutions and predicted kernels.

Tensors are [batch, channels, rows, columns]. Samples are four channels: colour times weight, and weight. Points are samples with two
more channels, their place right of and below the pixel's centre, -0.5 to 0.5. The guide's page algorithm.md has the equations.
"""

from __future__ import annotations

import torch
import torch.nn.functional as F
from torch import Tensor, nn

#: A pixel and its neighbours: rows down and columns right of it.
SQUARE = [(down, right) for down in (-1, 0, 1) for right in (-1, 0, 1)]


def enlarged(image: Tensor) -> Tensor:
    """Twice as many pixels along both axes, bilinear."""
    return F.interpolate(image, scale_factor=2, mode="bilinear", align_corners=False)


def averaged(image: Tensor, size: int, stride: int) -> Tensor:
    """Weighted means of size x size pixels. Weights fall linearly from the middle; the border is repeated."""
    weights = (2 - (torch.arange(size, dtype=image.dtype) - (size - 1) / 2).abs()) / 4
    kernel = (weights[:, None] * weights).expand(image.shape[1], 1, size, size)
    return F.conv2d(F.pad(image, (1, 1, 1, 1), mode="replicate"), kernel, stride=stride, groups=image.shape[1])


def around(image: Tensor) -> Tensor:
    """The 3x3 pixels around each, zeros beyond the border: [batch, 9, channels, rows, columns]."""
    batch, channels, height, width = image.shape
    return F.unfold(image, 3, padding=1).reshape(batch, channels, 9, height, width).transpose(1, 2)


def coordinates(image: Tensor) -> tuple[Tensor, Tensor]:
    """Columns and rows of the pixels."""
    height, width = image.shape[-2:]
    return torch.arange(width, dtype=image.dtype), torch.arange(height, dtype=image.dtype)[:, None]


def warped(picture: Tensor, motion: Tensor) -> Tensor:
    """The picture at p + motion(p), bilinear, zero outside."""
    height, width = picture.shape[-2:]
    columns, rows = coordinates(picture)
    x, y = columns + motion[:, 0], rows + motion[:, 1]
    grid = torch.stack([(2 * x + 1) / width - 1, (2 * y + 1) / height - 1], dim=-1)
    return F.grid_sample(picture, grid, mode="bilinear", padding_mode="zeros", align_corners=False)


def taken(points: Tensor, x: Tensor, y: Tensor) -> Tensor:
    """The points of the pixels in columns `x` and rows `y`, zeros outside the frame."""
    height, width = points.shape[-2:]
    inside = (x >= 0) & (x < width) & (y >= 0) & (y < height)
    place = y.clamp(0, height - 1).long() * width + x.clamp(0, width - 1).long()
    return points.flatten(2).gather(2, place.flatten(2).expand(-1, 6, -1)).reshape(points.shape) * inside


def reprojected(points: Tensor, motion: Tensor) -> Tensor:
    """Points of the last frame where they are now.

    A pixel takes the points that come to lie in it: their mean by weight, with the largest weight. Places are found from fractions of
    pixels alone. Sums with large coordinates would be rounded more, and points at the border of a pixel would fall into another.
    """
    columns, rows = coordinates(points)
    whole = motion.round()
    part = motion - whole
    colours, places = torch.zeros_like(points[:, :3]), torch.zeros_like(points[:, 4:])
    total, largest = torch.zeros_like(points[:, 3:4]), torch.zeros_like(points[:, 3:4])
    for down, right in SQUARE:
        point = taken(points, columns + whole[:, :1] + right, rows + whole[:, 1:] + down)
        place = torch.cat([right + point[:, 4:5] - part[:, :1], down + point[:, 5:] - part[:, 1:]], dim=1)
        is_here = ((place >= -0.5) & (place < 0.5)).all(dim=1, keepdim=True)
        weight = point[:, 3:4] * is_here
        colours, places = colours + point[:, :3] * is_here, places + weight * place
        total, largest = total + weight, torch.maximum(largest, weight)
    total = total.masked_fill(largest <= 0, 1)
    return torch.cat([colours / total * largest, largest, places / total], dim=1)


def splatted(points: Tensor) -> Tensor:
    """Samples at the centres of pixels. A point counts for four centres by bilinear shares."""
    height, width = points.shape[-2:]
    known, shares = torch.zeros_like(points[:, :4]), torch.zeros_like(points[:, :1])
    padded = F.pad(points, (1, 1, 1, 1))
    for down, right in SQUARE:
        point = padded[:, :, 1 + down :, 1 + right :][:, :, :height, :width]
        share = (1 - (right + point[:, 4:5]).abs()).clamp(min=0) * (1 - (down + point[:, 5:]).abs()).clamp(min=0)
        share = share * (point[:, 3:4] > 0)
        known, shares = known + share * point[:, :4], shares + share
    return known / shares.clamp(min=1)


def pull_push(known: Tensor, lowest: int = 1, levels: int = 4) -> Tensor:
    """Colours of the samples `known`, averaged over ever larger squares and spread back to level `lowest`, 1 for half the resolution."""
    pyramid = [known]
    for _ in range(levels):
        mean = averaged(pyramid[-1], 4, 2)
        weight = (8 * mean[:, 3:]).clamp(max=1)
        pyramid.append(torch.cat([mean[:, :3] * weight / mean[:, 3:].clamp(min=1e-8), weight], dim=1))
    filled = pyramid.pop()
    for finer in reversed(pyramid[lowest:]):
        filled = finer + (1 - finer[:, 3:]) * enlarged(filled)
    return filled[:, :3] / filled[:, 3:].clamp(min=1e-8)


def residual(known: Tensor, picture: Tensor) -> Tensor:
    """Difference of the samples from `picture`, times their weights."""
    return known[:, :3] - known[:, 3:] * picture


def spread(known: Tensor) -> tuple[Tensor, Tensor]:
    """The samples spread at half the resolution and corrected once by their residuals; and the smooth picture before that."""
    smooth = averaged(pull_push(known), 3, 1)
    return smooth + pull_push(torch.cat([residual(known, enlarged(smooth)), known[:, 3:]], dim=1)), smooth


def confidence(known: Tensor, last: Tensor, smooth: Tensor) -> Tensor:
    """Share of the weight that earlier samples keep: less where the last picture predicts the new samples badly."""
    squares = [(residual(known, picture) ** 2).mean(dim=1, keepdim=True) for picture in (last, enlarged(smooth))]
    spread_squares = pull_push(torch.cat([*squares, torch.zeros_like(squares[0]), known[:, 3:]], dim=1), lowest=3)
    error, own = spread_squares[:, :1], spread_squares[:, 1:2] + 1e-6
    return own / (own + 0.5 * (error - 0.25 * own).clamp(min=0))


class Block(nn.Module):
    """Two 3x3 convolutions, each with ReLU."""

    def __init__(self, inputs: int, outputs: int) -> None:
        super().__init__()
        self.conv1, self.conv2 = nn.Conv2d(inputs, outputs, 3, padding=1), nn.Conv2d(outputs, outputs, 3, padding=1)

    def forward(self, *inputs: Tensor) -> Tensor:
        return F.relu(self.conv2(F.relu(self.conv1(torch.cat(inputs, dim=1)))))


class PredictedKernel(nn.Conv2d):
    """A 1x1 convolution that predicts a kernel for each pixel and applies it. A feature may serve 2x2 pixels."""

    def __init__(self, features: int, taps: int, expand: int = 1) -> None:
        super().__init__(features, taps * expand**2, 1)
        self.expand = expand

    def forward(self, features: Tensor, *taps: Tensor) -> Tensor:  # pyright: ignore[reportIncompatibleMethodOverride]
        squares = F.pixel_shuffle(super().forward(features), self.expand) ** 2 + 1e-6
        return (squares / squares.sum(dim=1, keepdim=True))[:, :, None].mul(torch.cat(taps, dim=1)).sum(dim=1)

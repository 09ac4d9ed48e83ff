#!/usr/bin/env python3
"""Image formation, a second time: float64 NumPy written from the text of the specification alone.

Every function cites the clause of "1. Image formation" in SPEC.md that it reads like. There are no
tables, no bricks, no skipping and no single precision here: slow, plain, and independent of the Rust
code, whose renderer is compared with these pictures in crates/fovol-render/tests/numpy_reference.rs.

    python3 -m venv venv && venv/bin/pip install numpy==2.4.6
    venv/bin/python reference.py                    # recreates the committed files
    venv/bin/python reference.py --data DIR         # and the pictures of real volumes found in DIR
    venv/bin/python reference.py --check            # compares with the committed files, writes nothing

Running it recreates the committed files byte for byte (CPython 3.11 with zlib 1.2.13, NumPy 2.4.6). The
volumes use nothing but + - * / and square roots, so they are the same everywhere; another libm may move
a picture's last digit, another zlib the compressed bytes, so `--check` compares what is inside and lets
pictures differ by one level.

Files: `cases.json` describes volumes, scenes and pictures; `volume_*.gz` are voxels, x fastest, little
endian; `picture_*.gz` are u16 little endian RGB rows from the top, round(LEVELS * c).
"""

import argparse
import copy
import gzip
import json
import sys
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np

HERE = Path(__file__).resolve().parent
LEVELS = 10_000  # levels of a stored channel: off by 5e-5 at most
OPAQUE = 0.999  # "a ray ends at accumulated alpha >= 0.999"
DARK = 0.001  # "ended at T < 0.001"
DTYPES = {"u8": np.dtype("u1"), "i16": np.dtype("<i2"), "f32": np.dtype("<f4")}


# ---------------------------------------------------------------------------------------------------
# Volume, value, interpolation


class Volume:
    """Voxels shown over a range, in a box around the origin whose longest side is 1."""

    nearest = False  # "`--interpolation nearest` takes the nearest voxel before the transfer function"

    def __init__(self, raw, spacing, chosen_range=None):
        """`raw` is indexed [z, y, x]."""
        self.range = shown_range(raw, chosen_range)
        self.unit = unit_values(raw, self.range)
        self.dims = np.array(raw.shape[::-1])
        # "Volume: the box of physical extent dims x spacing, centred on the origin, scaled so that its
        # longest side is 1." Voxel i covers [i, i+1], so dims voxels fill the box.
        physical = self.dims * np.asarray(spacing, dtype=np.float64)
        self.half = 0.5 * physical / physical.max()
        self.voxel_size = 2.0 * self.half / self.dims
        # "voxel = the smallest spacing in world units"
        self.voxel = self.voxel_size.min()

    def sample(self, positions):
        """v at world positions [n, 3]. "Trilinear between voxel centres, clamped to the edge"."""
        # Voxel i "has its value at its centre": i + 1/2 in units of voxels from the box's corner.
        index = (positions + self.half) / self.voxel_size - 0.5
        index = np.clip(index, 0.0, self.dims - 1.0)
        if self.nearest:
            x, y, z = np.floor(index + 0.5).astype(np.intp).T
            return self.unit[z, y, x]
        low = np.floor(index).astype(np.intp)
        high = np.minimum(low + 1, self.dims - 1)
        fx, fy, fz = (index - low).T
        (x0, y0, z0), (x1, y1, z1) = low.T, high.T
        u = self.unit
        y0z0 = lerp(u[z0, y0, x0], u[z0, y0, x1], fx)
        y1z0 = lerp(u[z0, y1, x0], u[z0, y1, x1], fx)
        y0z1 = lerp(u[z1, y0, x0], u[z1, y0, x1], fx)
        y1z1 = lerp(u[z1, y1, x0], u[z1, y1, x1], fx)
        return lerp(lerp(y0z0, y1z0, fy), lerp(y0z1, y1z1, fy), fz)

    def display_value(self, data):
        """The display value of the data value `data`."""
        lo, hi = self.range
        return (data - lo) / (hi - lo)

    def gradient(self, positions):
        """The gradient of v: "central differences over +-1 voxel in world units"."""
        columns = []
        for axis in range(3):
            offset = np.zeros(3)
            offset[axis] = self.voxel_size[axis]
            rise = self.sample(positions + offset) - self.sample(positions - offset)
            columns.append(rise / (2.0 * self.voxel_size[axis]))
        return np.stack(columns, axis=1)

    def lengths(self):
        """A volume of the lengths of the gradients at voxels: central differences over +-1 voxel in world units, per
        mean edge of a voxel. Beyond the edge the last voxel repeats, and so does a voxel beside NaN.
        """
        here = self.unit
        squared = 0.0
        for axis in range(3):
            along = 2 - axis
            index = np.arange(here.shape[along])
            before = np.take(here, np.maximum(index - 1, 0), along)
            after = np.take(here, np.minimum(index + 1, index[-1]), along)
            before, after = (np.where(np.isnan(side), here, side) for side in (before, after))
            squared = squared + ((after - before) / (2.0 * self.voxel_size[axis])) ** 2
        lengths = copy.copy(self)
        lengths.unit = np.where(np.isnan(here), 0.0, np.sqrt(squared) * self.voxel_size.mean())
        return lengths

    def interval(self, origins, directions):
        """Where rays enter and leave the box; enter >= leave where they miss it."""
        with np.errstate(divide="ignore"):
            a = (-self.half - origins) / directions
            b = (self.half - origins) / directions
        return np.minimum(a, b).max(axis=1), np.maximum(a, b).min(axis=1)


def shown_range(raw, chosen_range):
    """lo and hi: "[lo, hi] is 0...255 for u8, and the finite data minimum...maximum for every other type, unless
    --range LO,HI."
    """
    if chosen_range is not None:
        return chosen_range
    if raw.dtype == np.uint8:
        return 0.0, 255.0
    values = raw.astype(np.float64)
    finite = np.isfinite(values)
    return values[finite].min(), values[finite].max()


def unit_values(raw, shown):
    """0...1 per voxel: "v = clamp((raw - lo)/(hi - lo), 0, 1). +-inf counts as `lo`; a sample with a NaN
    among its eight voxels takes --nan (default transparent)." NaN stays NaN here.
    """
    values = raw.astype(np.float64)
    lo, hi = shown
    values = np.where(np.isinf(values), lo, values)
    return np.clip((values - lo) / (hi - lo), 0.0, 1.0)


def lerp(a, b, f):
    return a + (b - a) * f


# ---------------------------------------------------------------------------------------------------
# Transfer function


class TransferFunction:
    """Points [v, r, g, b, a] and what lies between: "Piecewise linear RGBA over v in [0,1]". With points of length and
    factor, the factor of the extinction depends on the gradient.
    """

    def __init__(self, points, gradient=None):
        self.points = np.asarray(points, dtype=np.float64)
        self.gradient = None if gradient is None else np.asarray(gradient, dtype=np.float64)

    def alpha_at(self, volume, positions, voxels):
        """Opacity of a step `voxels` long at `positions` of `volume`: 1 - exp(-extinction x factor x voxels)."""
        v = volume.sample(positions)
        if self.gradient is None:
            return self.alpha(v, voxels)
        factor = np.interp(volume.lengths().sample(positions), self.gradient[:, 0], self.gradient[:, 1])
        return -np.expm1(-extinction(self.alpha(v, 1.0)) * factor * voxels)

    def colour(self, v):
        return np.stack([np.interp(v, self.points[:, 0], self.points[:, c]) for c in (1, 2, 3)], axis=1)

    def alpha(self, v, voxels):
        """Opacity of a step `voxels` long. "Opacity a(v) is per reference length, one voxel:
        alpha = 1 - (1 - a)^(step/voxel)".
        """
        a = np.interp(v, self.points[:, 0], self.points[:, 4])
        a = np.where(np.isnan(v), 0.0, a)  # transparent
        return 1.0 - (1.0 - a) ** voxels


# ---------------------------------------------------------------------------------------------------
# Cameras


@dataclass
class Camera:
    eye: np.ndarray
    target: np.ndarray
    fovy: float  # degrees
    orthographic: bool = False

    def rays(self, width, height):
        """Origins and unit directions [height * width, 3]. "Pinhole camera, vertical field of view in degrees, pixel
        centre (x+1/2, y+1/2), row 0 on top, right = forward x up"; "The up vector is +y".
        """
        forward = normalised(self.target - self.eye)
        right = normalised(np.cross(forward, [0.0, 1.0, 0.0]))
        up = np.cross(right, forward)
        tangent = np.tan(np.radians(self.fovy) / 2.0)
        y, x = np.mgrid[0:height, 0:width].reshape(2, -1)
        across = ((x + 0.5) / width * 2.0 - 1.0) * tangent * width / height
        upwards = (1.0 - (y + 0.5) / height * 2.0) * tangent
        sideways = across[:, None] * right + upwards[:, None] * up
        if self.orthographic:
            # "parallel rays, the picture is 2 |eye - target| tan(fovy/2) high at every depth"
            origins = self.eye + np.linalg.norm(self.target - self.eye) * sideways
            return origins, np.broadcast_to(forward, origins.shape)
        directions = normalised(forward + sideways)
        return np.broadcast_to(self.eye, directions.shape), directions


def on_sphere(azimuth, elevation, distance, fovy=35.0):
    """Looking at the centre, angles in degrees: "target 0, fovy 35, azimuth 0 at +z" (section 3)."""
    a, e = np.radians(azimuth), np.radians(elevation)
    towards = np.array([np.cos(e) * np.sin(a), np.sin(e), np.cos(e) * np.cos(a)])
    return Camera(distance * towards, np.zeros(3), fovy)


def orbit(i):
    """Frame i: "`orbit` turns 0.72 degrees of azimuth a frame at elevation 20 degrees, distance 1.9"
    (section 3).
    """
    return on_sphere(0.72 * i, 20.0, 1.9)


def flythrough(i):
    """Frame i: "`flythrough` has azimuth 0.72 i, elevation 35 sin(4 pi i/500), distance
    1.9 + 0.8 cos(6 pi i/500)" (section 3)."""
    return on_sphere(
        0.72 * i, 35.0 * np.sin(4.0 * np.pi * i / 500.0), 1.9 + 0.8 * np.cos(6.0 * np.pi * i / 500.0)
    )


def normalised(v):
    v = np.asarray(v, dtype=np.float64)
    return v / np.linalg.norm(v, axis=-1, keepdims=True)


# ---------------------------------------------------------------------------------------------------
# Light, ray, compositing


@dataclass
class Scene:
    volume: Volume
    transfer: TransferFunction
    light: np.ndarray  # "points from the scene towards it"
    ambient: float
    shadows: bool
    gradient_shading: bool
    background: np.ndarray
    step: float  # in voxels
    mode: str = "composite"
    iso: float = 0.0  # the display value of the isosurface
    planes: tuple = ()  # [x, y, z, d]
    colours: tuple = ()  # volumes of red, green and blue
    layers: tuple = ()  # further volumes and their transfer functions

    @property
    def delta(self):
        """The distance between samples: "--step x voxel"."""
        return self.step * self.volume.voxel

    def interval(self, origins, directions):
        """Where rays enter and leave what is shown. A plane "keeps n.x >= D in the world of section 1"; "Clips cut
        at their exact place", and "Cut faces are lit as if nothing were there on the other side".
        """
        enter, leave = self.volume.interval(origins, directions)
        for plane in self.planes:
            normal, distance = np.array(plane[:3]), plane[3]
            along, away = directions @ normal, distance - origins @ normal
            with np.errstate(divide="ignore", invalid="ignore"):
                crossing = away / along
            enter = np.where(along > 0.0, np.maximum(enter, crossing), enter)
            leave = np.where(along < 0.0, np.minimum(leave, crossing), leave)
            leave = np.where((along == 0.0) & (away > 0.0), -np.inf, leave)
        return enter, leave


def extinction(alpha):
    """Per step. Opaque samples count as nearly opaque, so that it stays finite."""
    return -np.log1p(-np.minimum(alpha, 1.0 - 1e-6))


def appearance(scene, positions, voxels):
    """Colours and opacities of steps `voxels` long: "opacities add as extinctions, colours weigh by their extinction"
    (section 6). Extinctions are in proportion to the steps.
    """
    colours, clear, weights = 0.0, 1.0, 0.0
    for number, (volume, transfer) in enumerate(((scene.volume, scene.transfer), *scene.layers)):
        alpha = transfer.alpha_at(volume, positions, voxels)
        colour = transfer.colour(volume.sample(positions))
        if number == 0 and scene.colours:
            colour = np.stack([channel.sample(positions) for channel in scene.colours], axis=1)
        weight = extinction(transfer.alpha_at(volume, positions, 1.0))[:, None]
        colours = colours + np.where(weight > 0.0, weight * colour, 0.0)
        weights = weights + weight
        clear = clear * (1.0 - alpha)
    return np.where(weights > 0.0, colours / np.where(weights > 0.0, weights, 1.0), 0.0), 1.0 - clear


def transmittance(scene, positions):
    """T per position: "T = product of (1 - alpha_j) along one shadow ray with steps of 4 delta, first sample
    at 2 delta from the point, alpha_j corrected for the 4 delta step, ended at T < 0.001 or at the box."
    """
    towards = np.broadcast_to(scene.light, positions.shape)
    _, leave = scene.interval(positions, towards)
    t = np.ones(len(positions))
    j = 0
    while True:
        distance = (2.0 + 4.0 * j) * scene.delta
        alive = np.flatnonzero((distance < leave) & (t >= DARK))
        if len(alive) == 0:
            return t
        _, alpha = appearance(scene, positions[alive] + distance * scene.light, 4.0 * scene.step)
        t[alive] *= 1.0 - alpha
        j += 1


def facing(scene, positions):
    """The factor of gradient shading: "multiplies the (1 - ambient) term by |n.l|, n from central differences
    [...], factor 1 where the gradient is zero."
    """
    volumes = ((scene.volume, scene.transfer), *scene.layers)
    if len(volumes) == 1:
        return facing_in(scene.volume, scene.light, positions)
    weights = [extinction(transfer.alpha_at(volume, positions, 1.0)) for volume, transfer in volumes]
    factors = [facing_in(volume, scene.light, positions) for volume, _ in volumes]
    whole = sum(weights)
    mean = sum(weight * factor for weight, factor in zip(weights, factors)) / np.where(whole > 0.0, whole, 1.0)
    return np.where(whole > 0.0, mean, 1.0)


def facing_in(volume, light, positions):
    """The factor of one volume. That of several is the mean, weighted by their extinctions."""
    gradient = volume.gradient(positions)
    length = np.linalg.norm(gradient, axis=1)
    flat = (length == 0.0) | np.isnan(length)
    cosine = np.abs(gradient @ light) / np.where(flat, 1.0, length)
    return np.where(flat, 1.0, cosine)


def lit(scene, positions, colour):
    """Lit colours: "colour x (ambient + (1 - ambient) T)"; "`--shadows off`: T = 1"."""
    direct = np.ones(len(positions))
    if scene.shadows:
        direct *= transmittance(scene, positions)
    if scene.gradient_shading:
        direct *= facing(scene, positions)
    return colour * (scene.ambient + (1.0 - scene.ambient) * direct)[:, None]


def render(scene, camera, width, height):
    """The picture, [height, width, 3], unclamped."""
    origins, directions = camera.rays(width, height)
    enter, leave = scene.interval(origins, directions)
    # "t_near = max(0, entry into the box)"; orthographic "rays start at the volume even behind the eye"
    near = enter if camera.orthographic else np.maximum(0.0, enter)
    if scene.mode != "composite":
        colours = isosurface if scene.mode == "isosurface" else projection
        return colours(scene, (origins, directions), near, leave).reshape(height, width, 3)
    colour = np.zeros((len(directions), 3))  # premultiplied
    alpha = np.zeros(len(directions))
    k = 0
    while True:
        # "Samples at t_near + (k+1/2) delta while t < t_far"; "a ray ends at accumulated alpha >= 0.999".
        t = near + (k + 0.5) * scene.delta
        alive = np.flatnonzero((t < leave) & (alpha < OPAQUE))
        if len(alive) == 0:
            break
        positions = origins[alive] + t[alive, None] * directions[alive]
        shown, a = appearance(scene, positions, scene.step)
        # What is transparent adds nothing, so its light need not be known.
        seen = a > 0.0
        alive, positions, shown, a = alive[seen], positions[seen], shown[seen], a[seen]
        # "Front to back, premultiplied"
        weight = (1.0 - alpha[alive]) * a
        colour[alive] += weight[:, None] * lit(scene, positions, shown)
        alpha[alive] += weight
        k += 1
    # "over a background"
    colour += (1.0 - alpha)[:, None] * scene.background
    return colour.reshape(height, width, 3)


def projection(scene, rays, near, leave):
    """Colours of rays: "`mip`, `minip`, `average` show the greatest, least, mean value along the ray through the transfer
    function's colours"; "opacity not corrected for length; shadows and ambient do not apply". NaN counts only where there
    is nothing else. Several volumes are projected one by one, and what they show is blended.
    """
    colours, clear, weights = 0.0, 1.0, 0.0
    for volume, transfer in ((scene.volume, scene.transfer), *scene.layers):
        alpha, colour = projected(scene, (volume, transfer), rays, near, leave)
        weight = extinction(alpha)
        colours, weights, clear = colours + weight * colour, weights + weight, clear * (1.0 - alpha)
    colour = colours / np.where(weights > 0.0, weights, 1.0)
    return (1.0 - clear) * colour + clear * scene.background


def projected(scene, shown, rays, near, leave):
    """Opacities and colours of rays through one volume."""
    volume, transfer = shown
    origins, directions = rays
    found = []
    for k in range(10_000):
        t = near + (k + 0.5) * scene.delta
        alive = t < leave
        if not alive.any():
            break
        v = volume.sample(origins + np.where(alive, t, 0.0)[:, None] * directions)
        found.append(np.where(alive, v, np.nan))
    found = np.array(found)
    some = ~np.isnan(found).all(axis=0)
    pick = {"mip": np.nanmax, "minip": np.nanmin, "average": np.nanmean}[scene.mode]
    v = np.full(len(origins), np.nan)
    v[some] = pick(found[:, some], axis=0)
    alpha = np.where(some, transfer.alpha(v, 1.0), 0.0)[:, None]
    return alpha, np.where(some[:, None], transfer.colour(np.where(some, v, 0.0)), 0.0)


def isosurface(scene, rays, near, leave):
    """Colours of rays: "`isosurface` the first crossing of V (in data values), shaded by its gradient, with shadows". A
    crossing lies between two neighbouring samples. A point is in shadow where a sample on the way to the light, at
    2 delta, 3 delta, ..., is on the other side of the surface than the sample before the crossing.
    """
    origins, directions = rays
    colour = np.tile(scene.background, (len(origins), 1))
    before = np.full(len(origins), np.nan)
    met = np.zeros(len(origins), bool)
    for k in range(10_000):
        t = near + (k + 0.5) * scene.delta
        alive = np.flatnonzero((t < leave) & ~met)
        if len(alive) == 0:
            break
        along = lambda s, rays: origins[rays] + s[:, None] * directions[rays]
        v = scene.volume.sample(along(t[alive], alive))
        known = ~np.isnan(v) & ~np.isnan(before[alive])
        above = before[alive] >= scene.iso
        crossing = known & (above != (v >= scene.iso))
        before[alive] = v
        hit, above = alive[crossing], above[crossing]
        if len(hit) == 0:
            continue
        met[hit] = True
        low, high = t[hit] - scene.delta, t[hit].copy()
        for _ in range(40):
            middle = 0.5 * (low + high)
            same = (scene.volume.sample(along(middle, hit)) >= scene.iso) == above
            low, high = np.where(same, middle, low), np.where(same, high, middle)
        positions = along(0.5 * (low + high), hit)
        direct = facing(scene, positions) * (lit_side(scene, positions, above) if scene.shadows else 1.0)
        light = scene.ambient + (1.0 - scene.ambient) * direct
        colour[hit] = scene.transfer.colour(np.full(len(hit), scene.iso)) * light[:, None]
    return colour


def lit_side(scene, positions, above):
    """1 where every sample on the way to the light is on the side `above` says, else 0."""
    towards = np.broadcast_to(scene.light, positions.shape)
    _, leave = scene.interval(positions, towards)
    lit = np.ones(len(positions))
    for j in range(10_000):
        distance = (2.0 + j) * scene.delta
        alive = np.flatnonzero(distance < leave)
        if len(alive) == 0:
            return lit
        v = scene.volume.sample(positions[alive] + distance * scene.light)
        lit[alive[~np.isnan(v) & ((v >= scene.iso) != above[alive])]] = 0.0


# ---------------------------------------------------------------------------------------------------
# Volumes by formula


def centres(dims):
    """x, y, z of voxel centres in -1...1 along each axis, broadcastable to [z, y, x]."""
    x, y, z = ((np.arange(n) + 0.5) / n * 2.0 - 1.0 for n in dims)
    return x[None, None, :], y[None, :, None], z[:, None, None]


def ct_ball(dims):
    """u8: a soft ball with a dense shell, two holes drilled through and a hollow, a dense bead in it."""
    x, y, z = centres(dims)
    r = np.sqrt(x * x + y * y + z * z)
    values = np.where(r < 0.85, 70.0 + 40.0 * x * y, 0.0)
    values = np.where((r > 0.7) & (r < 0.85), 190.0 + 30.0 * z, values)
    values = np.where(np.hypot(x - 0.2, y + 0.1) < 0.22, 12.0, values)
    values = np.where(np.hypot(y - 0.3, z + 0.25) < 0.16, 8.0, values)
    values = np.where(np.sqrt((x + 0.35) ** 2 + (y + 0.2) ** 2 + (z - 0.2) ** 2) < 0.24, 20.0, values)
    values = np.where(np.sqrt((x + 0.35) ** 2 + (y + 0.2) ** 2 + (z - 0.2) ** 2) < 0.1, 250.0, values)
    return np.rint(values).astype(np.uint8)


def simulation(dims):
    """f32: a tilted ring of high values beside a well of low ones, reaching outside the range that it is shown
    over, with a NaN, both infinities and a very large number among the voxels."""
    x, y, z = centres(dims)
    ring = np.sqrt((np.sqrt(x * x + z * z) - 0.55) ** 2 + (y - 0.25 * x) ** 2)
    field = 1.6 / (1.0 + 30.0 * ring * ring) - 0.9 / (1.0 + 12.0 * ((x - 0.3) ** 2 + y * y + (z - 0.3) ** 2))
    field = field + 0.15 * x * z - 0.1 * y
    # Rounded to 1/512: the file is half the size.
    field = (np.rint(field * 512.0) / 512.0).astype(np.float32)
    nx, ny, nz = dims
    field[nz // 2, ny // 2, nx // 4] = np.nan
    field[nz // 3, ny // 2, nx // 2] = np.inf
    field[nz // 2, ny // 3, nx // 3] = -np.inf
    field[nz // 4, ny // 2, nx // 2] = 3.0e30
    return field


def slabs(dims):
    """i16, Hounsfield-like: air, a slanted ellipsoid of tissue and three rods of bone in thick slices."""
    x, y, z = centres(dims)
    body = np.sqrt((x / 0.85) ** 2 + (y / 0.7 + 0.25 * x) ** 2 + (z / 0.9) ** 2)
    values = np.where(body < 1.0, 40.0 + 60.0 * y - 50.0 * z * x, -1000.0)
    values = np.where((body >= 0.9) & (body < 1.0), -90.0, values)
    for rod_x, rod_y, radius in ((-0.4, 0.1, 0.14), (0.1, -0.3, 0.18), (0.45, 0.15, 0.1)):
        rod = np.hypot(x - rod_x - 0.15 * z, y - rod_y)
        values = np.where((rod < radius) & (body < 0.95), 1100.0 - 2500.0 * rod, values)
    return np.rint(values).astype(np.int16)


# Without "make", a volume is a published one: voxels in the data folder, not here.
VOLUMES = {
    "ct": {"make": ct_ball, "dtype": "u8", "dims": [40, 36, 44], "spacing": [1, 1, 1], "range": None},
    "simulation": {
        "make": simulation,
        "dtype": "f32",
        "dims": [30, 24, 28],
        "spacing": [1, 1, 1],
        "range": [-0.25, 1.1],
    },
    "slices": {
        "make": slabs,
        "dtype": "i16",
        "dims": [36, 30, 14],
        "spacing": [0.7, 0.9, 2.5],
        "range": None,
    },
    "engine_256x256x128_uint8": {"dtype": "u8", "dims": [256, 256, 128], "spacing": [1, 1, 1], "range": None},
    "bi2o3_80x80x80_float32": {
        "dtype": "f32",
        "dims": [80, 80, 80],
        "spacing": [1, 1, 1],
        "range": [0.002, 0.2],
    },
    "lung_ct_115x157x129_int16": {
        "dtype": "i16",
        "dims": [115, 157, 129],
        "spacing": [1.3, 0.8, 1.7],
        "range": None,
    },
}

# [v, r, g, b, a]; each has a steep part.
TRANSFER_FUNCTIONS = {
    "ct": [
        [0.0, 0.0, 0.0, 0.0, 0.0],
        [0.15, 0.3, 0.1, 0.1, 0.0],
        [0.28, 0.8, 0.4, 0.3, 0.06],
        [0.6, 0.9, 0.6, 0.4, 0.1],
        [0.63, 1.0, 0.95, 0.8, 0.75],
        [1.0, 1.0, 1.0, 1.0, 0.9],
    ],
    "flow": [
        [0.0, 0.1, 0.2, 0.7, 0.04],
        [0.2, 0.2, 0.6, 0.9, 0.0],
        [0.5, 0.3, 0.8, 0.4, 0.02],
        [0.55, 0.95, 0.8, 0.2, 0.4],
        [0.7, 0.9, 0.3, 0.1, 0.1],
        [1.0, 0.8, 0.0, 0.1, 1.0],
    ],
    "hounsfield": [
        [0.0, 0.0, 0.0, 0.0, 0.0],
        [0.38, 0.2, 0.1, 0.1, 0.0],
        [0.42, 0.9, 0.5, 0.4, 0.12],
        [0.55, 0.8, 0.3, 0.2, 0.2],
        [0.75, 1.0, 0.9, 0.7, 0.85],
        [1.0, 1.0, 1.0, 0.95, 0.95],
    ],
    "spread": [
        [0.02, 0.2, 0.3, 0.8, 0.0],
        [0.1, 0.2, 0.7, 0.8, 0.03],
        [0.5, 0.9, 0.8, 0.3, 0.15],
        [0.54, 0.9, 0.3, 0.2, 0.5],
        [0.95, 1.0, 1.0, 1.0, 0.8],
    ],
}

PLAIN = {"light": [0.5, 1.0, 0.3], "ambient": 0.3, "background": [0.0, 0.0, 0.0]}  # section 3's defaults
WARM = {"light": [-0.6, 0.7, 0.5], "ambient": 0.2, "background": [0.15, 0.25, 0.4]}
LOW = {"light": [2.0, -0.5, 1.0], "ambient": 0.45, "background": [0.9, 0.85, 0.7]}


def picture(volume, transfer_function, camera, surroundings, **others):
    usual = {"size": [64, 48], "shadows": True, "gradient": False, "step": 0.5}
    return (
        {"volume": volume, "transfer_function": transfer_function, "camera": camera}
        | surroundings
        | usual
        | others
    )


def along(path, frame):
    return {"path": path, "frame": frame}


def still(eye, target, fovy):
    return {"eye": eye, "target": target, "fovy": fovy}


def parallel(eye, target, fovy):
    return still(eye, target, fovy) | {"projection": "orthographic"}


IN_CT = still([0.12, -0.06, 0.2], [-0.25, 0.0, -0.3], 80.0)
IN_SIMULATION = still([-0.3, 0.22, 0.38], [0.1, -0.05, -0.1], 65.0)
IN_SLICES = still([0.02, 0.16, 0.2], [0.05, -0.1, -0.4], 75.0)
# Eyes outside and inside the volume.
BESIDE = parallel([1.1, 0.9, 1.6], [0.02, -0.03, 0.01], 34.0)
AMONG = parallel([0.05, 0.02, 0.11], [-0.2, -0.13, -0.3], 85.0)
SLANTED = [[0.6, 0.3, -0.74, -0.12], [-0.2, 0.9, 0.1, -0.3]]
IN_ENGINE = still([0.1, 0.05, 0.12], [-0.3, -0.05, -0.2], 70.0)
# Layers are the volume itself, mirrored along an axis (x is 0).
LIKE_FLOW = {"mirrored": 0, "transfer_function": "flow", "interpolation": "linear"}
LIKE_SPREAD = {"mirrored": 2, "transfer_function": "spread", "interpolation": "linear"}
# Points of gradient and factor: borders alone, and less of them than of what they enclose.
BORDERS = [[0.01, 0.0], [0.06, 1.0]]
INSIDES = [[0.0, 1.0], [0.05, 0.15], [0.2, 0.4]]
LIKE_FLOW_BORDERS = LIKE_FLOW | {"gradient_opacity": BORDERS}
NEAREST = {"mirrored": 1, "transfer_function": "spread", "interpolation": "nearest"}
ENGINE, BI2O3, LUNG = list(VOLUMES)[3:]

# No picture hangs on a sample at a box face that may fall either way: a camera moved by 1e-6 changes no
# channel by more than 0.3/255. Keep it so; frame 85 of the last one would change a pixel by 11/255.
PICTURES = {
    "ct_plain": picture("ct", "ct", along("orbit", 0), PLAIN),
    "ct_shadows": picture("ct", "ct", along("orbit", 70), WARM),
    "ct_no_shadows": picture("ct", "ct", along("orbit", 70), LOW, shadows=False, step=0.8),
    "ct_gradient": picture("ct", "ct", along("orbit", 310), WARM, gradient=True),
    "ct_inside": picture("ct", "ct", IN_CT, LOW, step=0.35),
    "simulation_shadows": picture("simulation", "flow", along("orbit", 33), WARM),
    "simulation_no_shadows": picture("simulation", "flow", along("flythrough", 150), LOW, shadows=False),
    "simulation_gradient": picture(
        "simulation", "flow", along("flythrough", 401), LOW, gradient=True, step=0.7
    ),
    "simulation_inside": picture("simulation", "flow", IN_SIMULATION, WARM, gradient=True),
    "slices_shadows": picture("slices", "hounsfield", along("orbit", 455), LOW, step=0.6),
    "slices_no_shadows": picture("slices", "hounsfield", along("orbit", 210), WARM, shadows=False),
    "slices_gradient": picture("slices", "hounsfield", along("orbit", 40), WARM, gradient=True),
    "slices_inside": picture("slices", "hounsfield", IN_SLICES, LOW),
    "ct_mip": picture("ct", "ct", along("orbit", 70), WARM, mode="mip"),
    "ct_average": picture("ct", "spread", along("orbit", 310), LOW, mode="average", step=0.7),
    "ct_isosurface": picture("ct", "ct", along("orbit", 40), WARM, mode="isosurface", iso=150.0),
    "simulation_mip": picture("simulation", "flow", along("flythrough", 150), WARM, mode="mip"),
    "simulation_minip": picture("simulation", "flow", IN_SIMULATION, LOW, mode="minip"),
    "simulation_average": picture("simulation", "flow", along("orbit", 33), WARM, mode="average"),
    "simulation_isosurface": picture(
        "simulation", "flow", along("flythrough", 401), LOW, mode="isosurface", iso=0.4
    ),
    "slices_minip": picture("slices", "flow", along("orbit", 455), WARM, mode="minip"),
    "slices_isosurface": picture(
        "slices", "hounsfield", along("orbit", 210), LOW, mode="isosurface", iso=-300.0, shadows=False
    ),
    "ct_nearest": picture("ct", "ct", along("orbit", 33), WARM, interpolation="nearest"),
    "simulation_nearest": picture(
        "simulation", "flow", along("flythrough", 150), LOW, interpolation="nearest", step=0.7
    ),
    "slices_nearest": picture("slices", "hounsfield", BESIDE, WARM, interpolation="nearest", gradient=True),
    "ct_orthographic": picture("ct", "ct", BESIDE, WARM),
    "simulation_orthographic": picture("simulation", "flow", AMONG, LOW, gradient=True),
    "slices_orthographic_mip": picture("slices", "hounsfield", AMONG, WARM, mode="mip"),
    "ct_planes": picture("ct", "ct", along("orbit", 70), WARM, planes=SLANTED),
    "simulation_planes": picture("simulation", "flow", IN_SIMULATION, LOW, gradient=True, planes=SLANTED[:1]),
    "slices_planes": picture("slices", "hounsfield", BESIDE, WARM, planes=SLANTED, step=0.6),
    "ct_planes_isosurface": picture(
        "ct", "ct", along("orbit", 10), WARM, mode="isosurface", iso=40.0, planes=SLANTED
    ),
    "ct_layers": picture("ct", "ct", along("orbit", 10), WARM, layers=[LIKE_FLOW, LIKE_SPREAD]),
    "ct_layers_gradient": picture(
        "ct", "ct", BESIDE, LOW, layers=[LIKE_FLOW], gradient=True, planes=SLANTED[:1], step=0.7
    ),
    "ct_layers_nearest": picture("ct", "ct", along("orbit", 210), PLAIN, layers=[NEAREST], step=0.6),
    "ct_layers_mip": picture("ct", "ct", along("orbit", 70), WARM, layers=[LIKE_SPREAD], mode="mip"),
    "ct_colours": picture("ct", "ct", along("orbit", 310), WARM, colours=[0, 1, 2]),
    "ct_colours_layers": picture(
        "ct", "ct", IN_CT, LOW, colours=[2, 0, 1], layers=[LIKE_SPREAD], gradient=True
    ),
    "simulation_layers": picture("simulation", "flow", along("orbit", 33), WARM, layers=[LIKE_FLOW]),
    "slices_layers": picture("slices", "hounsfield", along("orbit", 40), LOW, layers=[NEAREST, LIKE_FLOW]),
    "ct_borders": picture("ct", "ct", along("orbit", 110), WARM, gradient_opacity=BORDERS),
    "ct_borders_inside": picture("ct", "ct", IN_CT, LOW, gradient_opacity=INSIDES, gradient=True, step=0.7),
    "simulation_borders": picture("simulation", "flow", along("orbit", 33), WARM, gradient_opacity=BORDERS),
    "slices_borders": picture(
        "slices", "hounsfield", along("orbit", 40), LOW, gradient_opacity=BORDERS, gradient=True
    ),
    "ct_borders_layers": picture(
        "ct", "ct", along("orbit", 250), WARM, gradient_opacity=INSIDES, layers=[LIKE_FLOW_BORDERS]
    ),
    "engine_gradient": picture(ENGINE, "ct", along("orbit", 60), WARM, gradient=True, size=[48, 36]),
    "engine_inside": picture(ENGINE, "ct", IN_ENGINE, LOW, size=[48, 36], step=0.75),
    "bi2o3_shadows": picture(BI2O3, "spread", along("orbit", 120), WARM, size=[48, 36]),
    "lung_gradient": picture(LUNG, "hounsfield", along("flythrough", 83), LOW, gradient=True, size=[48, 36]),
}


# ---------------------------------------------------------------------------------------------------
# Files


def camera_of(described):
    if "path" in described:
        return {"orbit": orbit, "flythrough": flythrough}[described["path"]](described["frame"])
    is_parallel = described.get("projection") == "orthographic"
    return Camera(np.array(described["eye"]), np.array(described["target"]), described["fovy"], is_parallel)


def scene_of(described, volume):
    volume = copy.copy(volume)
    volume.nearest = described.get("interpolation") == "nearest"
    return Scene(
        volume=volume,
        transfer=TransferFunction(
            TRANSFER_FUNCTIONS[described["transfer_function"]], described.get("gradient_opacity")
        ),
        light=normalised(described["light"]),
        ambient=described["ambient"],
        shadows=described["shadows"],
        gradient_shading=described["gradient"],
        background=np.array(described["background"]),
        step=described["step"],
        mode=described.get("mode", "composite"),
        iso=volume.display_value(described.get("iso", 0.0)),
        planes=described.get("planes", ()),
        colours=tuple(mirrored(volume, axis, False) for axis in described.get("colours", ())),
        layers=tuple(
            (
                mirrored(volume, layer["mirrored"], layer["interpolation"] == "nearest"),
                TransferFunction(
                    TRANSFER_FUNCTIONS[layer["transfer_function"]], layer.get("gradient_opacity")
                ),
            )
            for layer in described.get("layers", ())
        ),
    )


def mirrored(volume, axis, nearest):
    other = copy.copy(volume)
    other.unit = np.flip(volume.unit, 2 - axis)
    other.nearest = nearest
    return other


def raw_voxels(name, data_folder):
    """Voxels [z, y, x] by formula or from the data folder; None where that is not to be had."""
    described = VOLUMES[name]
    dtype = DTYPES[described["dtype"]]
    if "make" in described:
        return described["make"](described["dims"]).astype(dtype)
    file = data_folder / f"{name}.raw.gz" if data_folder else None
    if file is None or not file.exists():
        return None
    return np.frombuffer(gzip.decompress(file.read_bytes()), dtype).reshape(described["dims"][::-1])


def manifest():
    volumes = {
        name: {key: value for key, value in described.items() if key != "make"}
        | {"stored": "make" in described}
        for name, described in VOLUMES.items()
    }
    tables = {"volumes": volumes, "transfer_functions": TRANSFER_FUNCTIONS, "pictures": PICTURES}
    # One line per entry: readable, and changes show as lines.
    sections = [f'"levels": {LEVELS}']
    for title, table in tables.items():
        lines = ",\n".join(f"    {json.dumps(key)}: {json.dumps(value)}" for key, value in table.items())
        sections.append(f'"{title}": {{\n{lines}\n  }}')
    return ("{\n  " + ",\n  ".join(sections) + "\n}\n").encode()


class Files:
    """Writes files, or compares them with those that are there."""

    def __init__(self, check):
        self.check = check
        self.wrong = []

    def put(self, name, content, same=lambda old, new: old == new):
        packed = name.endswith(".gz")
        file = HERE / name
        if not self.check:
            file.write_bytes(gzip.compress(content, 9, mtime=0) if packed else content)
        elif not file.exists():
            self.wrong.append(f"{name} is missing")
        else:
            old = gzip.decompress(file.read_bytes()) if packed else file.read_bytes()
            if not same(old, content):
                self.wrong.append(f"{name} differs")


def within_one_level(old, new):
    a, b = (np.frombuffer(content, "<u2").astype(int) for content in (old, new))
    return a.shape == b.shape and np.abs(a - b).max() <= 1


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--data", type=Path, help="folder with the published volumes, NAME.raw.gz")
    parser.add_argument(
        "--check", action="store_true", help="compare with the committed files, write nothing"
    )
    arguments = parser.parse_args()

    files = Files(arguments.check)
    files.put("cases.json", manifest())
    volumes = {}
    for name, described in VOLUMES.items():
        raw = raw_voxels(name, arguments.data)
        if raw is not None:
            volumes[name] = Volume(raw, described["spacing"], described["range"])
            if "make" in described:
                files.put(f"volume_{name}.gz", raw.tobytes())
    for name, described in PICTURES.items():
        if described["volume"] not in volumes:
            print(f"{name:24} left as it is: its volume is not here, see --data")
            continue
        start = time.monotonic()
        image = render(
            scene_of(described, volumes[described["volume"]]),
            camera_of(described["camera"]),
            *described["size"],
        )
        stored = np.rint(np.clip(image, 0.0, 1.0) * LEVELS).astype("<u2")
        files.put(f"picture_{name}.gz", stored.tobytes(), within_one_level)
        mean = ", ".join(f"{c:.4f}" for c in image.mean(axis=(0, 1)))
        print(f"{name:24} mean {mean}   {time.monotonic() - start:.1f} s")

    for line in files.wrong:
        print(line, file=sys.stderr)
    return 1 if files.wrong else 0


if __name__ == "__main__":
    sys.exit(main())

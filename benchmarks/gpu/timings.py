"""How long things take on the GPU."""

from record import Task
from twins import DENSITIES

# Full frames of the paper's scenes cost about as much, in ms.
LIKE_THE_PAPER = 20.0, 100.0
NETWORKS = ("wnet-paper", "wnet-fast", "wnet-narrow", "deepfovea-fvn", "deepfovea-orig")
# Of these most is promised.
FOREMOST = NETWORKS[:2]
# Down to this density compaction is compared with the ideal.
LEAST_DENSITY = 0.05


def milliseconds(report):
    """The median of a report or of a row of one, and whose clock it is of."""
    if report.get("device_median_ms") is not None:
        return total(report["device_median_ms"]), "device"
    # Frames that stay on the device are timed by it.
    on_device = "device" if report.get("stays_on_device") else "host"
    return total(report["median_ms"]), report.get("clock", on_device)


def total(ms):
    """Milliseconds of a whole, which may be given in parts."""
    return ms["total"] if isinstance(ms, dict) else ms


def foremost_frames(bench):
    """The whole frame of which most is promised."""
    return list(all_frames(bench))[:1]


def all_frames(bench):
    """Whole frames of every size and volume."""
    side = bench.scale.sides[0]
    bench.volumes.begin(bench.scale.filmed, side)
    for size in bench.scale.sizes:
        for name in bench.scale.filmed:
            yield frames_task(bench, name, side, size, 0.5)


def heavy_frames(bench):
    """Whole frames of scenes that take long; of each volume until one takes longer than the paper's."""
    bench.volumes.begin({name: None for name, *_ in bench.scale.heavy}, bench.scale.sides[0])
    for name, side, size, step in bench.scale.heavy:
        lighter = bench.record.rows("speed_ups", volume=name)
        if all(row["found"]["full_ms"] <= LIKE_THE_PAPER[1] for row in lighter):
            yield frames_task(bench, name, side, size, step)


def frames_task(bench, volume, side, size, step):
    """The row of whole frames of a scene."""
    key = {"volume": volume, "side": side, "size": size, "step": step}
    return Task(key, lambda: frames_of(bench, **key), 180.0)


def frames_of(bench, volume, side, size, step):
    """Frames marched in full, and sparse ones that a network fills: times, frames a second and speed-ups.

    `ms` is the median by the clock of the device, `rate_ms` what one of many frames takes by that of the host. They
    agree where the device is what all wait for. Of the speed-ups by both the smaller one counts.
    """
    seen = ["--size", size, "--step", step, "--path", "flythrough", "--shadows", "on"]
    scene = [*bench.volumes.given(volume, side), *seen]
    count = max(bench.scale.least_frames, int(bench.scale.frames / bench.share(size)))

    def timed(*how):
        report = bench.program.json("bench", "pipeline", *scene, "--frames", count, *how, "--device", bench.device)
        ms, clock = milliseconds(report)
        rate = report["frames_per_second"]
        return {"ms": ms, "clock": clock, "rate_ms": 1e3 / rate, "frames_per_second": rate, "report": report}

    full = timed("--sampling", "full", "--reconstruct", "none")
    sparse = []
    for base, sigma in DENSITIES:
        found = timed("--pb", base, "--sigma", sigma, "--reconstruct", "wnet", "--weights", "wnet-fast")
        faster = {f"by_{name}": full[name] / found[name] for name in ("ms", "rate_ms")}
        sparse.append({"density": [base, sigma], **found, "speed_up": faster})
    return {
        "full_ms": full["rate_ms"],
        "is_like_the_paper": LIKE_THE_PAPER[0] <= full["rate_ms"] <= LIKE_THE_PAPER[1],
        **{name: sparse[0][name] for name in ("ms", "clock", "frames_per_second")},
        "speed_ups": [min(found["speed_up"].values()) for found in sparse],
        "full": full,
        "sparse": sparse,
    }


def foremost_networks(bench):
    """Networks of which most is promised, at the first size, as fast as they can be."""
    for name in FOREMOST:
        yield network_task(bench, name, "f16", bench.has_matrices(), bench.scale.sizes[0])


def all_networks(bench):
    """Every network in every precision, with and without matrices, at every size."""
    ways = [("f16", True)] if bench.has_matrices() else []
    ways += [("f16", False), ("f32", False)]
    for size in bench.scale.sizes:
        for precision, matrices in ways:
            for name in NETWORKS:
                yield network_task(bench, name, precision, matrices, size)


def network_task(bench, network, precision, matrices, size):
    """The row of a network."""
    key = {"network": network, "precision": precision, "matrices": matrices, "size": size}
    return Task(key, lambda: network_of(bench, **key))


def network_of(bench, network, precision, matrices, size):
    """The time of a network alone, its products a second, and their share of what the device can do."""
    repeats = max(2, int(bench.scale.repeats / bench.share(size)))
    chosen = ["--random-weights", network, "--precision", precision, "--size", size, "--repeats", repeats]
    report = bench.program.json("bench", "net", *chosen, "--device", bench.device, matrices=matrices)
    ms, clock = milliseconds(report)
    tflops = report["tflops"] * report["median_ms"] / ms
    multiplying = [layer for layer in report["layers"] if layer["gmacs"] > 0]
    their_ms = sum(layer["median_ms"] for layer in multiplying)
    alone = 2 * sum(layer["gmacs"] for layer in multiplying) / their_ms if their_ms else None
    most = ceiling(bench, "f16_product_tflops") if precision == "f16" else None
    return {
        "ms": ms,
        "clock": clock,
        "tflops": tflops,
        "share_of_f16_product": most and tflops / most,
        # Of the layers that multiply, without all the others.
        "multiplying_tflops": alone,
        "multiplying_share_of_f16_product": most and alone and alone / most,
        "report": report,
    }


def ceiling(bench, name):
    """What the device can do at best, where that was measured."""
    rows = bench.record.rows("ceilings")
    return rows[0]["found"].get(name) if rows else None


def compact(bench):
    """Sparse sampling at every density, with and without shadows, beside full frames."""
    first, *larger = bench.scale.sizes
    scenes = [(name, bench.scale.sides[0], first) for name in bench.scale.filmed]
    scenes += [(bench.scale.filmed[0], side, first) for side in bench.scale.sides[1:]]
    scenes += [(bench.scale.filmed[0], side, size) for side in bench.scale.sides[:2] for size in larger]
    for shadows in ("on", "off"):
        for name, side, size in scenes:
            key = {"volume": name, "side": side, "size": size, "shadows": shadows}
            yield Task(key, lambda key=key: compact_of(bench, **key))


def compact_of(bench, volume, side, size, shadows):
    """What sparse sampling costs against its share of the pixels: the worst of the densities that count, and all."""
    scene = [*bench.volumes.given(volume, side), "--size", size, "--shadows", shadows]
    repeats = max(2, int(bench.scale.repeats / bench.share(size) / 2))
    report = bench.program.json("bench", "compact", *scene, "--repeats", repeats, "--device", bench.device)
    rows = report["rows"]
    worst = max((row for row in rows if row["density"] >= LEAST_DENSITY), key=lambda row: row["compact_overhead"])
    return {
        "full_ms": rows[0]["full_ms"],
        "clock": rows[0].get("clock", "host"),
        "worst_overhead": worst["compact_overhead"],
        "at_density": worst["density"],
        "sparse_ms": {str(row["density"]): row["compact_ms"] for row in rows},
        "rows": rows,
    }


def march(bench):
    """Full frames: sizes of volumes and of frames, shadows, filtering by shader and by samplers."""
    name, sizes = bench.scale.filmed[0], bench.scale.sizes
    lit = [("on", "exact"), ("off", "exact"), ("cached", "exact"), ("on", "hardware")]
    scenes = [(name, side, sizes[0], *how) for side in bench.scale.sides for how in lit]
    scenes += [(name, side, size, *lit[0]) for size in sizes[1:] for side in bench.scale.sides[:2]]
    scenes += [(other, bench.scale.sides[0], sizes[0], *how) for other in bench.scale.filmed[1:] for how in lit[:2]]
    for volume, side, size, shadows, filtering in scenes:
        key = {"volume": volume, "side": side, "size": size, "shadows": shadows, "filtering": filtering}
        yield Task(key, lambda key=key: march_of(bench, **key))


def march_of(bench, volume, side, size, shadows, filtering):
    """A full frame, empty space left at once, and marched through."""
    scene = [*bench.volumes.given(volume, side), "--size", size, "--shadows", shadows]
    repeats = max(2, int(bench.scale.repeats / bench.share(size)))
    chosen = ["--filtering", filtering, "--device", bench.device, "--repeats", repeats]
    report = bench.program.json("bench", "march", *scene, *chosen)
    skipping, through = (next(row for row in report["rows"] if row["skip_empty"] is skips) for skips in (True, False))
    ms, clock = milliseconds(skipping)
    found = {"ms": ms, "clock": clock, "through_empty_space_ms": milliseconds(through)[0], "report": report}
    is_counted = shadows != "cached" and (side, size) == (bench.scale.sides[0], bench.scale.sizes[0])
    return found | (rate_of(bench, scene, volume, side, ms) if is_counted else {})


def rate_of(bench, scene, volume, side, ms):
    """Samples a second, counted by the processor on the same frame, and the bytes of the voxels that they weigh.

    A sample weighs eight voxels. Neighbours share most of them, and caches serve these: the bytes are those that are
    asked for, not those that memory delivers, and may be more than memory could.
    """
    report = bench.program.json("bench", "march", *scene, "--device", "cpu", "--repeats", 1)
    row = [row for row in report["rows"] if row["skip_empty"]][-1]
    samples = row["primary_samples"] + row["shadow_samples"]
    asked = samples * 8 * bench.volumes.bytes_of_a_voxel(volume, side) / ms / 1e6
    most = ceiling(bench, "copy_gb_per_s")
    return {
        "samples": samples,
        "million_samples_per_s": samples / ms / 1e3,
        "asked_gb_per_s": asked,
        "asked_share_of_copy": most and asked / most,
    }

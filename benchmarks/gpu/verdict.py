"""What has to hold on a GPU of the class of an H100, and whether it does."""

import statistics
from operator import ge, le

from timings import FOREMOST, LEAST_DENSITY, LIKE_THE_PAPER
from twins import DENSITIES, LEAST_DB, MEAN, MOST

# Of these frames times are promised.
SIZE, SIDE, VOLUME = "1280x720", 256, "head"
TIMES_PYTORCH, TIMES_PYTORCH_GOAL = 1.5, 1.0
FRAMES_A_SECOND, FRAMES_A_SECOND_GOAL = 500.0, 1000.0
OVERHEAD = 1.25
# At each density, those of the paper.
SPEED_UPS = 3.28, 2.29


class NotMeasured(Exception):
    """Why there is no figure."""


def verdict(bench):
    """A line for each thing that has to hold."""
    lines = [*twins(bench), network(bench), frame_rate(bench), compaction(bench)]
    return lines + [speed_up(bench, number) for number in range(len(DENSITIES))]


def text(line):
    """A line for the screen."""
    if line["figure"] is None:
        return f"not measured  {line['what']}: {line['why']}"
    words = {True: "held", False: "NOT HELD"}
    goal = f"; goal {line['goal']:g}: {words[line['goal_held']]}" if "goal" in line else ""
    beside = f"; {line['beside']}" if "beside" in line else ""
    return f"{words[line['held']]:12}  {line['what']}: {line['figure']:.4g}, limit {line['limit']:.4g}{goal}{beside}"


def judged(what, holds, limit, find, goal=None):
    """The line of `what`, whose figure `holds` beside its limit; `find` gives that, and what else there is to say."""
    line = {"what": what, "limit": limit, "figure": None, "held": None}
    try:
        figure, more = find()
    except NotMeasured as reason:
        return line | {"why": str(reason)}
    line |= {"figure": figure, "held": holds(figure, limit)} | more
    return line if goal is None else line | {"goal": goal, "goal_held": holds(figure, goal)}


def some(rows, of_what):
    """The rows, if there are any."""
    if not rows:
        raise NotMeasured(f"no {of_what}; see skipped and failed")
    return rows


def on_hardware(bench):
    """Times are promised of hardware."""
    gpu = bench.gpu()
    if "program" in gpu.get("kind", "program"):
        raise NotMeasured(f"{gpu.get('name', 'the GPU')} is a program on the processor")


def twins(bench):
    """Whether the GPU's pictures are those of the processor."""

    def extreme(choose, figure, what):
        rows = some(bench.record.rows("twins", what=what), f"comparison of {what}")
        return choose(row["found"][figure] for row in rows), {"compared": len(rows)}

    size, (clip, frames) = bench.scale.sizes[0], bench.scale.clip
    most = f"full frames at {size} against the processor's, largest difference"
    yield judged(most, le, MOST, lambda: extreme(max, "largest", "march"))
    yield judged("and largest mean difference", le, MEAN, lambda: extreme(max, "mean", "march"))
    yield judged("masks and lists that differ", le, 0, lambda: extreme(not_held, "held", "masks"))
    least = f"networks in f16 at {clip} after {frames} frames against the processor's f32, least dB"
    yield judged(least, ge, LEAST_DB, lambda: extreme(min, "last_db", "network"))


def not_held(comparisons):
    """How many of them found a difference."""
    return sum(not is_held for is_held in comparisons)


def network(bench):
    """The paper's network beside PyTorch."""
    of = {"network": FOREMOST[0], "size": SIZE}

    def find():
        on_hardware(bench)
        rows = some(bench.record.rows("networks", precision="f16", **of), "time of the network")
        ours = min((row["found"] for row in rows), key=lambda found: found["ms"])
        peers = [row["found"] for row in some(bench.record.rows("peers", **of), "time of PyTorch") if is_pytorch(row)]
        theirs = [found for found in peers if found.get("best_ms")]
        if not theirs:
            raise NotMeasured(next((found["missing"] for found in peers if "missing" in found), "PyTorch had no time"))
        best = min(theirs, key=lambda found: found["best_ms"])
        beside = f"{ours['ms']:.3f} ms by the {ours['clock']}'s clock, PyTorch {best['best_ms']:.3f} ms {best['best']}"
        if any(found["errors"] or "unfinished" in found for found in theirs):
            beside += "; PyTorch did not run in every way, see `errors` and `unfinished` of its rows"
        return ours["ms"] / best["best_ms"], {"beside": beside}

    what = f"{of['network']} in f16 at {SIZE}, times PyTorch's best"
    return judged(what, le, TIMES_PYTORCH, find, TIMES_PYTORCH_GOAL)


def is_pytorch(row):
    """Whether a row of peers is PyTorch's."""
    return row["of"]["peer"].startswith("PyTorch")


def frame_rate(bench):
    """Whole frames that a network of our own fills."""

    def find():
        on_hardware(bench)
        rows = bench.record.rows("frames", volume=VOLUME, side=SIDE, size=SIZE)
        found = some(rows, "time of whole frames")[0]["found"]
        beside = f"a frame takes {found['ms']:.3f} ms by the {found['clock']}'s clock"
        return found["frames_per_second"], {"beside": beside}

    what = f"frames a second with wnet-fast and shadows at {SIZE}, {VOLUME} of {SIDE}³ voxels"
    return judged(what, ge, FRAMES_A_SECOND, find, FRAMES_A_SECOND_GOAL)


def compaction(bench):
    """Sparse sampling against its share of the pixels."""

    def find():
        on_hardware(bench)
        rows = some(bench.record.rows("compact", size=SIZE, shadows="on"), "time of sparse sampling")
        each = {scene(row): row["found"]["worst_overhead"] for row in rows}
        worst = max(each, key=each.get)
        return each[worst], {"beside": f"worst: {worst}", "each": each}

    return judged(f"compaction at {SIZE} down to density {LEAST_DENSITY}, times the ideal", le, OVERHEAD, find)


def speed_up(bench, number):
    """Sparse frames that a network fills, beside full ones of scenes that cost what the paper's did."""
    density = f"({', '.join(DENSITIES[number])})"

    def find():
        on_hardware(bench)
        sections = "frames", "speed_ups"
        rows = [row for section in sections for row in bench.record.rows(section, is_like_the_paper=True)]
        costs = "whose full frame takes {:g} to {:g} ms".format(*LIKE_THE_PAPER)
        each = {scene(row): row["found"]["speed_ups"][number] for row in some(rows, f"scene {costs}")}
        worst = min(each, key=each.get)
        mean = statistics.mean(each.values())
        beside = f"least: {worst}; mean of {len(each)} scenes {mean:.2f}"
        return each[worst], {"beside": beside, "mean": mean, "each": each}

    return judged(f"speed-up over full frames at {density}, least", ge, SPEED_UPS[number], find)


def scene(row):
    """The scene of a row in a few words."""
    of = row["of"]
    step = f", step {of['step']:g}" if "step" in of else ""
    return f"{of['volume']} {of['side']}³ at {of['size']}{step}"

#!/usr/bin/env python3
"""Everything about a GPU in one run: that its pictures are right, then how fast it is, beside other programs.

    cargo build --release
    python3 benchmarks/gpu/run.py -o FILE.json [--minutes 25] [--device gpu:NAME] [--resume] [--only SECTION ...]
    python3 benchmarks/gpu/run.py -o FILE.json --quick

What matters most comes first, and each section has a share of the minutes; what has to wait for others comes again at
the end, as far as there is time. FILE is written after every row, so that whatever ends the run, all that was measured
is kept, and `--resume` goes on with what FILE lacks. What fails is listed under `failed`, what there was no time for
under `skipped`, and `verdict` says of each promise whether it holds. `--quick` is everything small, for a software
Vulkan.

Only Python 3.11 and its library are needed. PyTorch and ONNX Runtime are measured where they are installed and see the
GPU.
"""

import argparse
import signal
import sys
import tempfile
from pathlib import Path

import peers
import timings
import twins
from bench import FULL, QUICK, Bench
from program import Program, Volumes
from record import Record
from verdict import text, verdict

ROOT = Path(__file__).resolve().parents[2]
# Sections in the order of what matters: name, the most that it may take of all time at first, and its tasks.
SECTIONS = [
    ("twins", 0.25, twins.march),
    ("twins", 0.15, twins.masks),
    ("twins", 0.25, twins.networks),
    ("ceilings", 0.1, peers.ceilings),
    ("frames", 0.15, timings.foremost_frames),
    ("networks", 0.1, timings.foremost_networks),
    ("peers", 0.25, peers.foremost),
    ("speed_ups", 0.3, timings.heavy_frames),
    ("compact", 0.12, timings.compact),
    ("march", 0.12, timings.march),
    ("frames", 0.15, timings.all_frames),
    ("networks", 0.2, timings.all_networks),
    ("peers", 1.0, peers.rest),
]


def parsed():
    """What the command line asks for."""
    names = list(dict.fromkeys(name for name, *_ in SECTIONS))
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("-o", "--output", type=Path, required=True)
    parser.add_argument("--minutes", type=float, default=25.0)
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--resume", action="store_true", help="go on with what the output lacks")
    parser.add_argument("--only", nargs="+", choices=names, default=names, metavar="SECTION", help=" ".join(names))
    parser.add_argument("--device", default="gpu")
    parser.add_argument("--program", type=Path, default=ROOT / "target/release/fovolnet")
    parser.add_argument("--peers-on", choices=["cuda", "cpu"], default="cuda", help="cpu: to try the script")
    parser.add_argument("--volumes", type=Path, help="folder in which volumes are kept for the next run (5 GB)")
    return parser.parse_args()


def name_gpu(bench):
    """Notes what GPUs there are, and which of them is measured."""
    facts = bench.record.facts
    bench.record.allow(60)
    facts["devices"] = bench.program.json("info", "--devices")
    smallest = ["--dims", "8,8,8", "--size", "8x8", "--repeats", 1]
    facts["gpu"] = bench.program.json("bench", "march", "head", *smallest, "--device", bench.device)["machine"]["gpu"]
    facts["matrices"] = bench.gpu().get("matrices")


def measure(bench, only):
    """All sections: at first none may take the time of the others, then they take what is left."""
    chosen = [section for section in SECTIONS if section[0] in only]
    for is_first in (True, False):
        bench.record.forget_skipped()
        for name, share, tasks in chosen:
            left = bench.record.left_in_all()
            seconds = min(left, 60 * bench.record.facts["minutes"] * share) if is_first else left
            bench.record.take(name, tasks(bench), seconds)


def conclude(bench):
    """Writes and says what holds; the exit code: 0 if pictures are right and nothing failed."""
    facts, lines = bench.record.facts, verdict(bench)
    facts["verdict"] = lines
    bench.record.write()
    print(f"\n{facts['gpu']}: {len(facts['skipped'])} skipped, {len(facts['failed'])} failed")
    print("\n".join(map(text, lines)))
    print(bench.record.path)
    is_wrong = any(row["found"]["held"] is False for row in bench.record.rows("twins"))
    return 1 if facts["failed"] or is_wrong else 0


def main():
    given = parsed()
    # Told to end, it ends what it began.
    signal.signal(signal.SIGTERM, lambda *_: sys.exit("told to end"))
    record = Record(given.output, given.minutes, given.resume)
    program = Program(given.program, record)
    scale = QUICK if given.quick else FULL
    with tempfile.TemporaryDirectory() as folder:
        volumes = Volumes(program, given.volumes or Path(folder) / "volumes", scale.sides[0])
        bench = Bench(record, program, volumes, scale, given.device, given.peers_on, Path(folder))
        try:
            name_gpu(bench)
            measure(bench, given.only)
        finally:
            volumes.end()
    return conclude(bench)


if __name__ == "__main__":
    sys.exit(main())

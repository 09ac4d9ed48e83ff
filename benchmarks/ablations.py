#!/usr/bin/env python3
"""What each part of the paper's method gives: small networks that differ in one thing, trained on the same clips for as many steps.

    . training/environment && cargo build --release --manifest-path training/Cargo.toml
    python benchmarks/ablations.py training/configs/ablations.toml -o DIR [--steps 3000] [--only NAME ...]

Each is judged by clips of volumes that none has learned from, at 3 % of the pixels. `DIR/ablations.csv` has PSNR, SSIM and tPSNR;
`fovolnet repro ablations --ablations DIR/ablations.csv` puts them into the report. What is done already is not done again, and
what was interrupted goes on where it was.
"""

import argparse
import csv
import json
import subprocess
import sys
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]

# Part, what is done instead, and the configuration of that.
ABLATIONS = {
    "whole": ("nothing left out", {}),
    "d-alone": ("no predicted kernels", {"network": {"kernels": False}}),
    # Nothing that D predicts can come back where it predicts no picture.
    "k-on-samples": ("kernels filter the samples; no direct prediction", {"network": {"direct": False, "feedback": "none"}}),
    "no-recurrence": ("nothing goes from frame to frame", {"network": {"recurrent": False, "feedback": "none"}}),
    "no-feedback": ("decoders are recurrent, the picture does not come back", {"network": {"feedback": "none"}}),
    "eight-frames": ("two clips of 8 frames instead of one of 16", {"frames": 8, "batch": 2}),
    "blue-noise": ("samples blue in space alone", {"lesson": {"noise": {"kind": "blue"}}}),
    "white-noise": ("samples white", {"lesson": {"noise": {"kind": "uniform"}}}),
    "tile-16": ("noise in tiles of 16 pixels", {"lesson": {"noise": {"tile": 16}}}),
    "tile-64": ("noise in tiles of 64 pixels", {"lesson": {"noise": {"tile": 64}}}),
    "no-flow": ("no optical flow in the loss", {"loss": {"flow-weight": 0.0}}),
    "no-temporal": ("nothing in the loss compares frames", {"loss": {"temporal-weight": 0.0}}),
    "l1-alone": ("no perceptual measure in the loss", {"loss": {"perceptual-weight": 0.0, "l1-weight": 1.0}}),
    "squares": ("squares instead of absolute differences", {"loss": {"l1-weight": 0.0, "squares-weight": 1.0}}),
    "fake-quantised": ("int8, and trained as such", {"fake-quantised": True}),
    # One step too small to change anything: the whole as int8 would compute it.
    "quantised-after": (
        "int8, trained without",
        {"fake-quantised": True, "from": "whole/weights.safetensors", "steps": 1, "rate": 1e-30, "last-rate": 0.0},
    ),
}


def merged(base, change):
    """`base` with the leaves of `change`."""
    both = dict(base)
    for name, value in change.items():
        both[name] = merged(base.get(name, {}), value) if isinstance(value, dict) else value
    return both


def toml(value):
    """A value as TOML on one line."""
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{name} = {toml(entry)}" for name, entry in value.items()) + " }"
    if isinstance(value, list):
        return "[" + ", ".join(map(toml, value)) + "]"
    return json.dumps(value)


def configuration(path, steps):
    """The configuration in `path`, of `steps` if they are given, with paths that hold from anywhere."""
    base = tomllib.loads(path.read_text())
    if steps:
        base["steps"] = steps
    clips = base["clips"]
    clips["folder"] = str((path.parent / clips["folder"]).resolve())
    for name in ["volumes", "held-out"]:
        # A procedural volume is NAME:SIDE:SEED.
        clips[name] = [part if ":" in part else str((path.parent / part).resolve()) for part in clips[name]]
    # Only the end counts.
    base["validate-every"] = base["steps"]
    return base


def judged(folder):
    """The last judgement of the run in `folder`, and its step; nothing before there is one."""
    log = folder / "log.jsonl"
    lines = [json.loads(line) for line in log.read_text().splitlines()] if log.exists() else []
    found = [line for line in lines if "judged" in line]
    return (found[-1]["judged"]["network"], found[-1]["step"] + 1) if found else None


def train(program, config, folder, options):
    """Trains what `config` says into `folder`, from where it was."""
    folder.mkdir(parents=True, exist_ok=True)
    # Paths of a configuration are relative to it.
    file = folder.parent / f"{folder.name}.toml"
    file.write_text("".join(f"{name} = {toml(value)}\n" for name, value in config.items()))
    command = [program, "train", file, "-o", folder, "--threads", options.threads, "--device", options.device]
    command += ["--resume"] if (folder / "checkpoint.safetensors").exists() else []
    command += ["--clips-as-they-are"] if options.clips_as_they_are else []
    if subprocess.run([str(part) for part in command], check=False).returncode != 0:
        sys.exit(f"{folder.name}: training failed; see above")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("config", type=Path)
    parser.add_argument("--steps", type=int, help="instead of those of the configuration")
    parser.add_argument("--only", nargs="+", choices=ABLATIONS, default=list(ABLATIONS), metavar="NAME", help=", ".join(ABLATIONS))
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--device", default="auto")
    parser.add_argument("--clips-as-they-are", action="store_true", help="learn from the clips that are there; make none")
    parser.add_argument("--program", type=Path, default=ROOT / "training/target/release/fovolnet-train")
    parser.add_argument("-o", "--output", type=Path, required=True)
    options = parser.parse_args()
    base = configuration(options.config, options.steps)
    options.output.mkdir(parents=True, exist_ok=True)
    for name in options.only:
        config = merged(base, ABLATIONS[name][1])
        if (judged(options.output / name) or (None, 0))[1] < config["steps"]:
            train(options.program, config, options.output / name, options)
    done = {name: judged(options.output / name) for name in ABLATIONS}
    with open(options.output / "ablations.csv", "w", newline="") as file:
        rows = csv.writer(file)
        rows.writerow(["part", "instead", "steps", "psnr", "ssim", "tpsnr"])
        for name, (instead, _) in ABLATIONS.items():
            if done[name]:
                scores, steps = done[name]
                rows.writerow([name, instead, steps, *(round(scores[key], 4) for key in ["psnr", "ssim", "tpsnr"])])
    print((options.output / "ablations.csv").read_text(), end="")


if __name__ == "__main__":
    main()

#!/usr/bin/env python3
"""Everything about a GPU in one run: that its pictures are right, then how fast it is.

    cargo build --release
    python3 benchmarks/gpu/run.py [--quick] [--device gpu:NAME] -o benchmarks/results/DATE-MACHINE/gpu.json

First frames of the GPU are compared with those of the processor; if they differ, nothing is timed. Then march, compaction,
networks and whole frames are timed; beside them PyTorch and ONNX Runtime (CUDA, TensorRT) on the same networks, where they are
installed and see the GPU, with what the device can do at best. `--quick` is small, for a software Vulkan. What fails is written down and the rest goes on.
"""

import argparse
import json
import os
import platform
import subprocess
import sys
import tempfile
from itertools import product
from pathlib import Path

import onnx_peer
import torch_peer

ROOT = Path(__file__).resolve().parents[2]
# Sides of volumes, sizes of frames, repetitions.
FULL = {"sides": [256, 512, 1024], "sizes": ["1280x720", "1920x1080", "3840x2160"], "repeats": 15}
QUICK = {"sides": [32], "sizes": ["96x64"], "repeats": 2}
NETWORKS = ["wnet-paper", "wnet-narrow", "wnet-fast", "deepfovea-fvn", "deepfovea-orig"]
# Least PSNR between frames of GPU and processor, dB: pictures differ by rounding alone, networks also by halves.
LEAST = {"none": 50.0, "pull-push": 50.0, "wnet": 40.0}


class Run:
    """What is being found out."""

    def __init__(self, given):
        self.given = given
        self.scale = QUICK if given.quick else FULL
        self.found = {"machine": platform.platform(), "failed": []}

    def fovolnet(self, *arguments, matrices=True):
        """The JSON of a command of the program, which may use cooperative matrices or not."""
        command = [self.given.program, *map(str, arguments), "--json", "-"]
        environment = os.environ if matrices else {**os.environ, "FOVOLNET_GPU_MATRICES": "off"}
        done = subprocess.run(command, capture_output=True, text=True, check=False, env=environment)
        if done.returncode != 0:
            problem = f"{' '.join(map(str, arguments))}: {done.stderr.strip()}"
            print(problem, file=sys.stderr)
            self.found["failed"].append(problem)
            return None
        return json.loads(done.stdout)

    def keep(self, section, row):
        """Adds a row, and writes everything so far."""
        self.found.setdefault(section, []).append(row)
        print(section, json.dumps(row)[:160], flush=True)
        self.given.output.parent.mkdir(parents=True, exist_ok=True)
        self.given.output.write_text(json.dumps(self.found, indent=1) + "\n")

    def volumes(self):
        return [("head", side) for side in self.scale["sides"]] + [("vortices", side) for side in self.scale["sides"][:2]]

    def same_frames(self):
        """Whether frames of the GPU are those of the processor."""
        right = True
        size, side = self.scale["sizes"][0], self.scale["sides"][0]
        for how, least in LEAST.items():
            with tempfile.TemporaryDirectory() as folder:
                for device in (self.given.device, "cpu"):
                    out = Path(folder) / device.partition(":")[0]
                    self.fovolnet(
                        "render", "head", "--dims", f"{side},{side},{side}", "--size", size, "--frames", 6,
                        "--reconstruct", how, "--precision", "auto" if device != "cpu" else "f32",
                        "--device", device, "-o", out,
                    )  # fmt: skip
                gpu = Path(folder) / self.given.device.partition(":")[0]
                compared = self.fovolnet("metrics", Path(folder) / "cpu", gpu)
            psnr = compared and compared["psnr"]
            right &= psnr is None or psnr == "inf" or float(psnr) >= least
            right &= compared is not None
            self.keep("same_frames", {"reconstruct": how, "psnr": psnr, "least": least})
        return right

    def march(self):
        for volume, side in self.volumes():
            for size in self.scale["sizes"]:
                for shadows, filtering in product(("on", "off", "cached"), ("exact", "hardware")):
                    figures = self.fovolnet(
                        "bench", "march", volume, "--dims", f"{side},{side},{side}", "--size", size,
                        "--shadows", shadows, "--filtering", filtering, "--device", self.given.device,
                        "--repeats", self.scale["repeats"],
                    )  # fmt: skip
                    row = {"volume": f"{volume}:{side}", "size": size, "shadows": shadows, "filtering": filtering}
                    self.keep("march", {**row, "found": figures})

    def compact(self):
        for volume, side in self.volumes():
            figures = self.fovolnet(
                "bench", "compact", volume, "--dims", f"{side},{side},{side}", "--size", self.scale["sizes"][0],
                "--device", self.given.device, "--repeats", self.scale["repeats"],
            )  # fmt: skip
            self.keep("compact", {"volume": f"{volume}:{side}", "found": figures})

    def networks(self):
        for name in NETWORKS:
            for precision, matrices in (("f16", True), ("f16", False), ("f32", False)):
                for size in self.scale["sizes"]:
                    figures = self.fovolnet(
                        "bench", "net", "--random-weights", name, "--size", size, "--precision", precision,
                        "--device", self.given.device, "--repeats", self.scale["repeats"], matrices=matrices,
                    )  # fmt: skip
                    row = {"network": name, "precision": precision, "matrices": matrices, "size": size}
                    self.keep("networks", {**row, "found": figures})

    def frames(self):
        for volume, side in self.volumes():
            for size in self.scale["sizes"]:
                for sampling, how in [(("--pb", "0.03", "--sigma", "0.02"), "wnet"), (("--sampling", "full"), "none")]:
                    figures = self.fovolnet(
                        "bench", "pipeline", volume, "--dims", f"{side},{side},{side}", "--size", size,
                        "--path", "flythrough", *sampling, "--reconstruct", how, "--device", self.given.device,
                        "--frames", 4 * self.scale["repeats"],
                    )  # fmt: skip
                    row = {"volume": f"{volume}:{side}", "size": size, "sampling": sampling, "reconstruct": how}
                    self.keep("frames", {**row, "found": figures})

    def peers(self):
        torch = torch_peer.cuda()
        self.keep("peers", torch_peer.ceilings(torch) if torch else {"torch": "not installed, or without a GPU"})
        size = tuple(map(int, self.scale["sizes"][0].split("x")))
        for name in NETWORKS:
            by_torch = torch_peer.network(torch, name, size) if torch else {}
            by_onnx = onnx_peer.network(self.given.program, name, size)
            self.keep("peers", {"network": name, "median_ms": by_torch | by_onnx})


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", default=ROOT / "target/release/fovolnet")
    parser.add_argument("--device", default="gpu")
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("-o", "--output", type=Path, required=True)
    run = Run(parser.parse_args())
    run.found["devices"] = run.fovolnet("info", "--devices")
    if not run.same_frames():
        sys.exit("frames of the GPU are not those of the processor; nothing was timed")
    for section in (run.networks, run.peers, run.frames, run.march, run.compact):
        section()
    print(run.given.output)


if __name__ == "__main__":
    main()

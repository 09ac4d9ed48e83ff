#!/usr/bin/env python3
"""OpenVDB and NanoVDB files in many variants, read here and by the libraries that wrote them.

    apt-get install g++ libopenvdb-dev libnanovdb-dev libblosc-dev libboost-dev libboost-iostreams-dev libtbb-dev libimath-dev
    pip install numpy
    python tests/reference/vdb_files.py make FOLDER               # builds vdb_files.cpp and writes all files
    python tests/reference/vdb_files.py compare FOLDER [PROGRAM]  # PROGRAM is the built describe_volumes
    python tests/reference/vdb_files.py samples FOLDER            # writes crates/fovol-io/tests/vdb_files

Compared are size, type, spacing, the place of the first voxel, the directions of the axes and every value in the box of
active voxels. Files that are refused on purpose must give an error of one line.
"""

import gzip
import json
import subprocess
import sys
from pathlib import Path

import numpy as np

from summary import Summary

REPOSITORY = Path(__file__).resolve().parents[2]
SAMPLES = REPOSITORY / "crates/fovol-io/tests/vdb_files"
PROGRAM = ["cargo", "run", "--release", "-q", "-p", "fovol-io", "--example", "describe_volumes"]
LIBRARIES = ["-lopenvdb", "-ltbb", "-lImath-3_1", "-lblosc", "-lz", "-lboost_iostreams"]
# As many values of a sample are written down.
KEPT = 40


def make(folder):
    folder.mkdir(exist_ok=True)
    program = folder / "vdb_files"
    source = Path(__file__).with_suffix(".cpp")
    subprocess.run(["g++", "-O0", "-std=c++17", "-w", str(source), "-o", str(program), *LIBRARIES], check=True)
    with open(folder / "cases.jsonl", "w") as out:
        subprocess.run([str(program), str(folder)], stdout=out, check=True)


def cases(folder):
    return [json.loads(line) for line in open(folder / "cases.jsonl")]


def problems(case, answer, values, folder):
    if "dims" not in case:
        said = answer.get("error")
        return [] if said and "\n" not in said and "; " in said else [f"it should be refused, but {said or 'was read'}"]
    if "error" in answer:
        return [answer["error"]]
    found = []
    steps = np.array(case["steps"])
    spacing = np.linalg.norm(steps, axis=1)
    wanted = {"dims": case["dims"], "dtype": case["dtype"], "components": case["components"], "array": case["array"] or None}
    found += [f"{key} {answer[key]}, not {value}" for key, value in wanted.items() if answer[key] != value]
    for key, value in {"spacing": spacing, "origin": case["origin"], "orientation": (steps / spacing[:, None]).T}.items():
        if not np.allclose(answer[key], value, rtol=1e-9, atol=1e-9):
            found.append(f"{key} {answer[key]}, not {value}")
    expected = np.fromfile(folder / case["values"], "<f8")
    if values is None or values.shape != expected.shape or not np.array_equal(values, expected):
        found.append(f"values {values[:4] if values is not None else None}, not {expected[:4]}")
    return found


def compare(folder, program):
    all_cases, output = cases(folder), folder / "read"
    output.mkdir(exist_ok=True)
    orders = ""
    for i, case in enumerate(all_cases):
        order = {"path": str(folder / case["file"]), "values": str(output / str(i)), "component": case.get("component", 0)}
        orders += json.dumps(order | ({"array": case["array"]} if case.get("array") else {})) + "\n"
    answers = subprocess.run(program, input=orders, stdout=subprocess.PIPE, text=True, cwd=REPOSITORY, check=True).stdout
    agreed = refused = 0
    summary = Summary()
    kinds = {".vdb": ("OpenVDB", "OpenVDB"), ".nvdb": ("NanoVDB", "NanoVDB")}
    for i, (case, line) in enumerate(zip(all_cases, answers.splitlines(), strict=True)):
        path = output / str(i)
        wrong = problems(case, json.loads(line), np.fromfile(path, "<f8") if path.exists() else None, folder)
        agreed += not wrong and "dims" in case
        refused += not wrong and "dims" not in case
        path.unlink(missing_ok=True)
        summary.add(*kinds[Path(case["file"]).suffix], "differ" if wrong else "agree" if "dims" in case else "refused")
        if wrong:
            print(f"{case['file']} {case['kind']} {case.get('array')}: {'; '.join(wrong)}")
    summary.print()
    print(f"{len(all_cases)} variants: {agreed} agree, {refused} are refused as they should, {len(all_cases) - agreed - refused} differ")
    sys.exit(agreed + refused != len(all_cases))


def samples(folder):
    """The smallest files of each kind with some of their values, for the test of the crate."""
    SAMPLES.mkdir(exist_ok=True)
    for old in SAMPLES.iterdir():
        old.unlink()
    kept, counts = {}, {}
    for case in cases(folder):
        if "dims" not in case or case["kind"] in ("large tile",):
            continue
        name = f"{case['file']}.gz"
        if name not in kept:
            packed = gzip.compress((folder / case["file"]).read_bytes(), 9, mtime=0)
            counts[case["kind"]] = counts.get(case["kind"], 0) + 1
            # Some of the many variants of compression and inactive values are enough.
            limit = 120 if case["kind"] == "float" else 2
            is_kept = counts[case["kind"]] <= limit and (case["kind"] != "float" or counts["float"] % 11 == 1)
            if len(packed) > (9000 if counts[case["kind"]] == 1 else 4000) or not is_kept:
                continue
            (SAMPLES / name).write_bytes(packed)
            kept[name] = []
        values = np.fromfile(folder / case["values"], "<f8")
        step = max(1, len(values) // KEPT)
        spacing = np.linalg.norm(np.array(case["steps"]), axis=1)
        kept[name].append({
            "kind": case["kind"], "array": case["array"] or None, "component": case["component"], "dims": case["dims"],
            "spacing": [float(f"{v:.9g}") for v in spacing], "origin": [float(f"{v:.9g}") for v in case["origin"]],
            "step": step, "values": [float(f"{v:.9g}") for v in values[::step]],
        })  # fmt: skip
    lines = (f"{json.dumps(name)}: {json.dumps(found, separators=(',', ':'))}" for name, found in sorted(kept.items()))
    (SAMPLES / "values.json").write_text("{\n" + ",\n".join(lines) + "\n}\n")
    print(len(kept), "files", sum(path.stat().st_size for path in SAMPLES.iterdir()), "bytes")


if __name__ == "__main__":
    match sys.argv[1:]:
        case ["make", folder]:
            make(Path(folder).resolve())
        case ["compare", folder]:
            compare(Path(folder).resolve(), PROGRAM)
        case ["compare", folder, program]:
            compare(Path(folder).resolve(), [program])
        case ["samples", folder]:
            samples(Path(folder).resolve())
        case _:
            sys.exit(__doc__)

#!/usr/bin/env python3
"""Random volume files, read by outside libraries and by this program.

    python tests/reference/random_variations.py [--count 1000] [--seed 1] [--folder FOLDER] [--program FILE] [--only KIND]

Writes `count` files of random type, byte order, encoding, header fields, order of arrays and names, by pynrrd,
SimpleITK, nibabel, VTK and tifffile, or byte by byte where these would not write so. The example `describe_volumes` of
`fovol-io` reads each, and writes it again in a random format, which the outside libraries read back. Every voxel is
compared, with size, spacing, orientation, origin, unit and numbers of components, channels and time points. A
difference is *silent* where no note speaks of it. The exit status is 1 where there is one.
"""

import argparse
import collections
import json
import re
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

from summary import Summary
from variations import compare, metaimage, nifti, nrrd_files, raw, tiff_files, vtk_files
from variations.case import Unreadable, chance, pick

REPOSITORY = Path(__file__).resolve().parents[2]
KINDS = {"nifti": nifti, "nrrd": nrrd_files, "metaimage": metaimage, "vtk": vtk_files, "tiff": tiff_files, "raw": raw}
LIBRARIES = {
    "NIfTI": "nibabel", "NRRD": "pynrrd", "MetaImage": "SimpleITK", "VTI": "VTK", "VTK": "VTK", "TIFF": "tifffile", "raw": "NumPy",
}  # fmt: skip
WRITTEN = [".nrrd", ".nhdr", ".mha", ".mhd", ".nii", ".nii.gz", ".vti"]


def cases(folder, count, seed, kinds):
    """Random cases; files that no library reads are counted, not kept."""
    unreadable = collections.Counter()
    found = []
    for number in range(count):
        rng = np.random.default_rng([seed, number])
        kind = pick(rng, kinds)
        own = folder / f"{number:05}"
        own.mkdir(parents=True, exist_ok=True)
        try:
            found.append((KINDS[kind].make(rng, own / pick(rng, ["v", "Ärzte", "a b", "scan.1"])), rng))
        except Unreadable as reason:
            unreadable[f"{kind}: {generalised(str(reason))}"] += 1
    return found, unreadable


def generalised(text):
    """`text` without what differs from file to file."""
    text = re.sub(r"/\S+/", "", re.sub(r"(v|Ärzte|a b|scan\.1)[.\w×-]*: ", "", text))
    return re.sub(r"-?\d+(\.\d+)?(e[-+]?\d+)?", "N", text)[:150]


def answers(program, found):
    orders = []
    for case, rng in found:
        order = {"path": str(case.path), "values": str(case.path.parent / "values.f64"), **case.chosen}
        if chance(rng, 0.5):
            order["convert"] = str(case.path.parent / ("again" + pick(rng, WRITTEN)))
        orders.append(order)
    command = (
        [program] if program else ["cargo", "run", "-q", "--release", "-p", "fovol-io", "--example", "describe_volumes"]
    )
    text = "".join(json.dumps(order) + "\n" for order in orders)
    run = subprocess.run(command, cwd=REPOSITORY, input=text, stdout=subprocess.PIPE, text=True, check=True)
    return list(zip((case for case, _ in found), orders, map(json.loads, run.stdout.splitlines()), strict=True))


def main(options):
    folder = Path(options.folder or tempfile.mkdtemp(prefix="variations"))
    found, unreadable = cases(folder, options.count, options.seed, [options.only] if options.only else list(KINDS))
    tally, silent, summary = collections.Counter(), [], Summary()
    for case, order, answer in answers(options.program, found):
        said = case.how.split()[0]
        kind = f"{said}, random files", LIBRARIES[said]
        if "error" in answer:
            summary.add(*kind, "refused")
            tally[f"refused: {case.how.split()[0]}: {generalised(answer['error'])}"] += 1
            continue
        differences = compare.differences(case, order, answer)
        summary.add(*kind, "agree" if not differences else "refused" if answer["notes"] else "differ")
        noted = " | ".join(generalised(note) for note in answer["notes"])
        if not differences:
            tally["agrees, with a note" if noted else "agrees"] += 1
        elif noted:
            tally[f"noted: {case.how.split()[0]}: {generalised('; '.join(differences))}: {noted}"] += 1
        else:
            silent.append(f"SILENT {case.how}: {case.path} {case.chosen or ''}: {'; '.join(differences)}")
    print(*silent, sep="\n")
    for text, number in sorted([*tally.items(), *((f"no library: {t}", n) for t, n in unreadable.items())]):
        print(f"{number:6} {text}")
    summary.print()
    print(
        f"{len(found)} files read by a library (seed {options.seed}), {len(silent)} of them differ silently; they are in {folder}"
    )
    sys.exit(bool(silent))


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--folder", help="where files are written; a temporary folder by default")
    parser.add_argument("--program", help="describe_volumes, built; by default cargo builds it")
    parser.add_argument("--only", choices=KINDS)
    main(parser.parse_args())

"""The program that is measured, and the volumes that it is given."""

import json
import os
import signal
import subprocess
from array import array
from concurrent.futures import ThreadPoolExecutor
from concurrent.futures import TimeoutError as NotYet
from pathlib import Path

from record import OutOfTime

# Unsigned numbers of as many bytes as a voxel, by the types of NRRD.
CODES = {"uint8": "B", "int16": "H", "uint16": "H", "float": "I"}


def output_of(command, seconds, environment=None):
    """What `command` wrote, and why it did not end well, if so; it and all that it began end after `seconds`."""
    words = list(map(str, command))
    pipe = subprocess.PIPE
    child = subprocess.Popen(words, stdout=pipe, stderr=pipe, text=True, env=environment, process_group=0)
    try:
        output, complaints = child.communicate(timeout=max(seconds, 0.1))
    except subprocess.TimeoutExpired:
        os.killpg(child.pid, signal.SIGKILL)
        return child.communicate()[0], OutOfTime(f"not done after {seconds:.0f} s: {' '.join(words[1:])}")
    except BaseException:
        os.killpg(child.pid, signal.SIGKILL)
        raise
    if child.returncode != 0:
        return output, RuntimeError(f"{' '.join(words[1:])}: {complaints.strip()[-600:]}")
    return output, None


class Program:
    """The command `fovolnet`, within the time that is left to `record`."""

    def __init__(self, path, record):
        self.path, self.record = path, record

    def json(self, *arguments, matrices=True):
        """The report of a command, which may use cooperative matrices or not."""
        environment = os.environ | ({} if matrices else {"FOVOLNET_GPU_MATRICES": "off"})
        output, problem = output_of([self.path, *arguments, "--json", "-"], self.record.left(), environment)
        if problem:
            raise problem
        return json.loads(output)

    def does(self, *arguments):
        """A command without a report."""
        _, problem = output_of([self.path, *arguments], self.record.left())
        if problem:
            raise problem


class Volumes:
    """Procedural volumes as files: a file is read in no time, and made once for all commands.

    Of sides up to `largest` they are made as they are. Larger ones, which would take minutes, repeat each voxel of one
    of that side: as many voxels to march through, of less detail.
    """

    def __init__(self, program, folder, largest):
        self.program, self.folder, self.largest = program, folder, largest
        self.folder.mkdir(parents=True, exist_ok=True)
        # Each takes one thread; some are left for what is measured meanwhile.
        self.pool = ThreadPoolExecutor(max(1, (os.cpu_count() or 1) // 2))
        self.made = {}

    def begin(self, names, side):
        """Begins to make volumes."""
        side = min(side, self.largest)
        for name in names:
            if (name, side) not in self.made:
                self.made[name, side] = self.pool.submit(self._make, name, side)

    def given(self, name, side):
        """The arguments that name a volume and how it is shown, as soon as it is made."""
        self.begin([name], side)
        least = min(side, self.largest)
        try:
            path = self.made[name, least].result(timeout=max(self.program.record.left(), 0.1))
        except NotYet as error:
            raise OutOfTime(f"{name} of {least}³ voxels was not made in time") from error
        if side > least:
            path = repeated(path, side // least, self.folder / f"{name}_{side}.nhdr")
        return path, "--tf", name

    def bytes_of_a_voxel(self, name, side):
        """How many bytes a voxel has."""
        return array(CODES[header(self.given(name, side)[0])["type"]]).itemsize

    def end(self):
        """Makes no more, and waits for what is being made."""
        self.pool.shutdown(cancel_futures=True)

    def _make(self, name, side):
        path = self.folder / f"{name}_{side}.nhdr"
        if not path.exists():
            sides = f"{side},{side},{side}"
            command = [self.program.path, "data", "make", name, path, "--dims", sides]
            _, problem = output_of(command, self.program.record.left_in_all())
            if problem:
                raise problem
        return path


def header(path):
    """The fields of an NRRD header."""
    return dict(line.split(": ", 1) for line in path.read_text().splitlines() if ": " in line)


def repeated(path, times, larger):
    """The file `larger`: the volume of `path` at so many `times` the side, each voxel repeated along each axis."""
    if larger.exists():
        return larger
    fields = header(path)
    side, code = int(fields["sizes"].split()[0]), CODES[fields["type"]]
    voxels = array(code, path.with_name(fields["data file"]).read_bytes())
    with larger.with_suffix(".raw").open("wb") as out:
        for plane in range(side):
            rows = bytearray()
            for begin in range(plane * side * side, (plane + 1) * side * side, side):
                row = array(code, bytes(side * times * voxels.itemsize))
                for place in range(times):
                    row[place::times] = voxels[begin : begin + side]
                rows += row.tobytes() * times
            for _ in range(times):
                out.write(rows)
    sizes = " ".join([str(side * times)] * 3)
    text = path.read_text().replace(f"sizes: {fields['sizes']}", f"sizes: {sizes}")
    # The header last: where it is, the voxels are.
    larger.write_text(text.replace(fields["data file"], larger.with_suffix(".raw").name))
    return larger

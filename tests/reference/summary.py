"""Counts of a comparison by kind of file. `volume_info.py table` puts them into docs/formats.md."""

import re

LINE = "summary {kind} | {library} | {agree} | {refused} | {differ}"
PATTERN = re.compile(r"^summary (.+) \| (.+) \| (\d+) \| (\d+) \| (\d+)$", flags=re.M)


class Summary:
    def __init__(self):
        self.counts = {}

    def add(self, kind, library, outcome):
        """Counts a file of `kind` that `library` reads or wrote; `outcome` is `agree`, `refused` or `differ`."""
        counts = self.counts.setdefault((kind, library), {"agree": 0, "refused": 0, "differ": 0})
        counts[outcome] += 1

    def print(self):
        for (kind, library), counts in self.counts.items():
            print(LINE.format(kind=kind, library=library, **counts))


def found(text):
    """The rows that `Summary.print` printed into `text`: kind, library, and the three counts."""
    return [(kind, library, *map(int, counts)) for kind, library, *counts in PATTERN.findall(text)]

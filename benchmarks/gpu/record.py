"""What has been found out so far, as JSON that is written anew after every row, and how much time is left."""

import json
import platform
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass


class OutOfTime(Exception):
    """Something took longer than it may."""


@dataclass
class Task:
    """A row that is to be found out."""

    # What it is of; no other row of its section has the same.
    key: dict
    # Finds out what the row says.
    work: Callable[[], dict]
    # Seconds after which it is given up.
    limit: float = 120.0


class Record:
    """Rows by section, what failed, and what there was no time for."""

    # Less is not worth beginning anything.
    LEAST_SECONDS = 2.0

    def __init__(self, path, minutes, resumed):
        self.path = path
        self.end = time.monotonic() + 60 * minutes
        # When what is being done now has to be done.
        self.until = self.end
        self.facts = json.loads(path.read_text()) if resumed and path.exists() else {}
        self.facts |= {"machine": platform.platform(), "minutes": minutes, "failed": [], "skipped": [], "verdict": []}

    def allow(self, seconds):
        """Lets what is done from now on take so long in all."""
        self.until = min(self.end, time.monotonic() + seconds)

    def left(self):
        """Seconds that what is being done now may still take."""
        return self.until - time.monotonic()

    def left_in_all(self):
        """Seconds that everything may still take."""
        return self.end - time.monotonic()

    def rows(self, section, **key):
        """The rows of a section that agree with `key`."""

        def agrees(row):
            facts = row["of"] | row["found"]
            return all(facts.get(name) == value for name, value in key.items())

        return list(filter(agrees, self.facts.get(section, [])))

    def take(self, section, tasks, seconds):
        """Does the tasks that were not done yet, as long as there is time: `seconds` at most."""
        end = min(self.end, time.monotonic() + seconds)
        try:
            for task in tasks:
                if not self._is_settled(section, task, end):
                    self._attempt(section, task, end)
        except Exception as error:  # What makes the tasks may fail as well, and the next section goes on.
            self._note("failed", section, {}, _text(error))
        self.until = self.end

    def write(self):
        """Writes everything so far."""
        self.path.parent.mkdir(parents=True, exist_ok=True)
        beside = self.path.with_name(self.path.name + ".part")
        beside.write_text(json.dumps(self.facts, indent=1) + "\n")
        beside.replace(self.path)

    def forget_skipped(self):
        """Lets what there was no time for be tried again."""
        self.facts["skipped"] = []

    def _is_settled(self, section, task, end):
        """Whether a task failed, or was done, in full or in much of the time that there is for it now."""
        if any((entry["section"], entry["of"]) == (section, task.key) for entry in self.facts["failed"]):
            return True
        seconds = min(task.limit, end - time.monotonic())
        rows = [row for row in self.facts.get(section, []) if row["of"] == task.key]
        return any(not row["found"].get("unfinished") or seconds < 1.5 * row["seconds"] for row in rows)

    def _attempt(self, section, task, end):
        begin = time.monotonic()
        if end - begin < self.LEAST_SECONDS:
            self._note("skipped", section, task.key, "no time was left")
            return
        self.until = min(end, begin + task.limit)
        try:
            found = task.work()
        except OutOfTime as error:
            is_own_limit = self.until < end
            self._note("failed" if is_own_limit else "skipped", section, task.key, _text(error))
        except Exception as error:  # Whatever is wrong with one row, the others are found out.
            self._note("failed", section, task.key, _text(error))
        else:
            self._keep(section, {"of": task.key, "found": found, "seconds": round(time.monotonic() - begin, 1)})

    def _keep(self, section, row):
        others = [other for other in self.facts.get(section, []) if other["of"] != row["of"]]
        self.facts[section] = [*others, row]
        print(f"{section}: {_short(row['of'])}: {_short(row['found'])}", flush=True)
        self.write()

    def _note(self, where, section, key, why):
        self.facts[where].append({"section": section, "of": key, "why": why})
        if where == "failed":
            print(f"failed: {section}: {_short(key)}: {why}", file=sys.stderr, flush=True)
        self.write()


def _short(values):
    """Those values that take a word or two."""
    words = []
    for name, value in values.items():
        if value is not None and not isinstance(value, dict | list):
            words.append(f"{name} {value:.4g}" if isinstance(value, float) else f"{name} {value}")
    return ", ".join(words)


def _text(error):
    """An error in a few lines."""
    return f"{type(error).__name__}: {error}"[:1000]

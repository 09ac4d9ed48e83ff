"""Settings as the text that the native part reads."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any


def settings_json(settings: Mapping[str, Any]) -> str:
    """Settings with the names of flags, ``_`` for ``-``, as JSON. Those that are None are left out."""
    given = {name.replace("_", "-"): plain(value) for name, value in settings.items() if value is not None}
    if isinstance(given.get("size"), str):
        given["size"] = [int(side) for side in given["size"].split("x")]
    gaze = given.get("gaze")
    if isinstance(gaze, list) and len(gaze) == 2:
        given["gaze"] = f"{float(gaze[0])},{float(gaze[1])}"
    return json.dumps(given)


def plain(value: Any) -> Any:
    """Lists and numbers of Python instead of tuples and numbers of NumPy."""
    if hasattr(value, "tolist"):
        return value.tolist()
    if isinstance(value, (tuple, list)):
        return [plain(part) for part in value]
    return value

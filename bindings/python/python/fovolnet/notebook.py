"""What notebooks can show."""

from __future__ import annotations

import sys
from importlib.util import find_spec


def has_widgets() -> bool:
    """Whether this is a kernel of a notebook, with anywidget installed."""
    ipython = sys.modules.get("IPython")
    shell = ipython.get_ipython() if ipython is not None else None
    return getattr(shell, "kernel", None) is not None and find_spec("anywidget") is not None

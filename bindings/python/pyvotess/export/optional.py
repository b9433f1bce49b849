"""Packages that are needed for one thing only."""

from __future__ import annotations

import importlib
from typing import Any


def imported(module: str, caller: str, install: str = "") -> Any:
    """This module; ImportError, which names ``caller`` and what to install, when there is none."""
    try:
        return importlib.import_module(module)
    except ImportError as error:
        raise ImportError(f"{caller} needs {module}: pip install {install or module}") from error

"""Import of optional packages."""

from __future__ import annotations

import importlib
from typing import Any


def imported(module: str, caller: str, install: str = "") -> Any:
    """Returns the module. Raises ImportError, which names ``caller`` and the package to install."""
    try:
        return importlib.import_module(module)
    except ImportError as error:
        raise ImportError(f"{caller} needs {module}: pip install {install or module}") from error

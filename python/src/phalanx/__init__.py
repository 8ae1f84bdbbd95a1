"""Phalanx in Python: take part in a run, start runs, and look at their logs.

Everything is loaded when it is first asked for, so that a controller need not wait for the tools of the analysis.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from . import plot
    from .log import Log, Topic, open
    from .metrics import Assertion, Fault, Metric, compare
    from .participant import Participant, Participants, PhalanxError, Step
    from .running import LogError, ProgramError, ScenarioError, find_program, run

# Where each public name lives.
_HOMES = {
    "Assertion": "metrics",
    "Fault": "metrics",
    "Log": "log",
    "LogError": "running",
    "Metric": "metrics",
    "Participant": "participant",
    "Participants": "participant",
    "PhalanxError": "participant",
    "ProgramError": "running",
    "ScenarioError": "running",
    "Step": "participant",
    "Topic": "log",
    "compare": "metrics",
    "find_program": "running",
    "open": "log",
    "plot": "",
    "run": "running",
}

__all__ = sorted(_HOMES)
__version__ = "0.1.0"


def __getattr__(name: str) -> Any:
    home = _HOMES.get(name)
    if home is None:
        raise AttributeError(f"module `phalanx` has no `{name}`, only {', '.join(__all__)}")
    # A module of the package is shown as it is.
    value = getattr(import_module(f"{__name__}.{home}"), name) if home else import_module(f"{__name__}.{name}")
    # A function may be called like the module that it comes from; the function is what the package shows.
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted([*globals(), *__all__])

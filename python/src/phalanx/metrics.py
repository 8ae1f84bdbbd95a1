"""What came out of a run, beside what should have come out."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import pandas

    from .log import Log

__all__ = ["Assertion", "Fault", "Judgement", "Metric", "compare", "from_json"]


@dataclass(frozen=True)
class Metric:
    """One number of a run."""

    value: float
    """What was measured; NaN if it does not exist, such as the time of something that never happened."""
    low: float | None = None
    """Lower end of its regression range."""
    high: float | None = None
    """Upper end of its regression range."""
    in_range: bool | None = None
    """Whether it is in its regression range, that is, what the reference implementation gives; ``None`` without a range."""
    thesis: str | None = None
    """What the thesis states about it."""
    against_thesis: str = "not stated"
    """That statement is "met", "not met", "qualitative" (in words) or "not stated"."""
    ratio: float | None = None
    """The value relative to the printed number, if there is one."""
    reason: str | None = None
    """Why the statement is not met."""
    symbol: str | None = None
    unit: str | None = None
    description: str | None = None
    """What it means, in one sentence."""

    def __float__(self) -> float:
        return self.value


@dataclass(frozen=True)
class Assertion:
    """What became of an assertion of the scenario."""

    name: str
    signal: str
    """The signal or metric that it is about."""
    severity: str
    """"fail", or "warn" if a violation does not fail the run."""
    ok: bool
    """Whether no value was beyond a bound."""
    checked: int
    """How many values were compared; 0 if its time was not reached."""
    violations: int
    """How many of them were beyond."""
    min: float | None = None
    max: float | None = None
    first: dict[str, Any] | None = None
    """The first violation: agent, time, value."""
    worst: dict[str, Any] | None = None
    """The value that came closest to a bound, or was farthest beyond."""


@dataclass(frozen=True)
class Fault:
    """What went wrong in a run, or in its log."""

    text: str
    participant: str = ""
    """The participant that it is about; empty if none."""
    step: int | None = None
    time: float | None = None
    """Simulated time, s."""

    def __str__(self) -> str:
        place = f" at step {self.step}" if self.step is not None else ""
        return f"{self.participant}{place}: {self.text}" if self.participant else self.text


@dataclass
class Judgement:
    """What was found about a run."""

    ok: bool = False
    metrics: dict[str, Metric] = field(default_factory=dict)
    assertions: dict[str, Assertion] = field(default_factory=dict)
    faults: list[Fault] = field(default_factory=list)

    @classmethod
    def of(cls, summary: Mapping[str, Any]) -> Judgement:
        """From what ``phalanx check --json`` or ``phalanx run --json`` prints."""
        known = {entry.name for entry in fields(Assertion)}
        found = [Assertion(**{key: value for key, value in one.items() if key in known}) for one in summary["assertions"] or []]
        return cls(bool(summary["ok"]), from_json(summary["metrics"] or {}), {one.name: one for one in found})


def from_json(metrics: Mapping[str, Mapping[str, Any]]) -> dict[str, Metric]:
    """Metrics as ``phalanx check --json`` and ``phalanx run --json`` print them."""

    known = {one.name for one in fields(Metric)} - {"value", "low", "high"}

    def metric(entry: Mapping[str, Any]) -> Metric:
        # JSON has no NaN.
        value = math.nan if entry["value"] is None else float(entry["value"])
        rest = {key: entry[key] for key in known if entry.get(key) is not None}
        return Metric(value, entry.get("lo"), entry.get("hi"), **rest)

    return {name: metric(entry) for name, entry in metrics.items()}


def compare(logs: Mapping[str, Log]) -> pandas.DataFrame:
    """The metrics of several runs side by side: a row per metric, a column per run.

    >>> phalanx.compare({"CFC": clipped, "LPBCFC": regulated}).loc[["De", "Du"]]
    """
    import pandas

    columns = {name: {key: metric.value for key, metric in log.metrics.items()} for name, log in logs.items()}
    return pandas.DataFrame(columns)

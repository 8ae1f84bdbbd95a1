"""What came out of a run, beside what should have come out."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import pandas

    from .log import Log

__all__ = ["Metric", "compare", "from_json"]


@dataclass(frozen=True)
class Metric:
    """One number of a run."""

    value: float
    """What was measured; NaN if it does not exist, such as the time of something that never happened."""
    low: float | None = None
    """Lower end of its band."""
    high: float | None = None
    """Upper end of its band."""
    thesis: str | None = None
    """What the thesis says about it."""
    ok: bool | None = None
    """Whether it lies in its band; ``None`` without a band."""

    def __float__(self) -> float:
        return self.value


def from_json(metrics: Mapping[str, Mapping[str, Any]]) -> dict[str, Metric]:
    """Metrics as ``phalanx check --json`` and ``phalanx run --json`` print them."""

    def metric(entry: Mapping[str, Any]) -> Metric:
        # JSON has no NaN.
        value = math.nan if entry["value"] is None else float(entry["value"])
        return Metric(value, entry.get("lo"), entry.get("hi"), entry.get("thesis"), entry.get("ok"))

    return {name: metric(entry) for name, entry in metrics.items()}


def compare(logs: Mapping[str, Log]) -> pandas.DataFrame:
    """The metrics of several runs side by side: a row per metric, a column per run.

    >>> phalanx.compare({"CFC": clipped, "LPBCFC": regulated}).loc[["De", "Du"]]
    """
    import pandas

    columns = {name: {key: metric.value for key, metric in log.metrics.items()} for name, log in logs.items()}
    return pandas.DataFrame(columns)

"""Plots of logs with Matplotlib: a few lines from a run to a figure, colours that the colour-blind tell apart.

Every function draws into ``ax`` (the current axes by default) and returns it, so that all of Matplotlib stays at hand.

>>> phalanx.plot.paths(log)
>>> phalanx.plot.signal(log, "agent_*/command/input", norm=True)
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from .log import Log

__all__ = ["COLOURS", "DASHES", "compare", "errors", "paths", "signal", "style"]

#: Okabe and Ito's colours, ordered so that neighbours differ in lightness too.
COLOURS = ["#0072B2", "#E69F00", "#000000", "#56B4E9", "#D55E00", "#009E73", "#CC79A7", "#8A7F00"]
#: Dashes that go with them: together they tell 24 curves apart, in grey too.
DASHES: list[Any] = ["-", (0, (7, 2.5)), (0, (2, 2)), (0, (8, 2.5, 2, 2.5)), (0, (12, 3)), (0, (5, 2, 1.5, 2, 1.5, 2))]


def style(index: int) -> dict[str, Any]:
    """Colour, dashes and width of the ``index``-th curve, from 0, as keywords for ``ax.plot``."""
    return {"color": COLOURS[index % len(COLOURS)], "linestyle": DASHES[index % len(DASHES)], "linewidth": 1.2}


def paths(log: Log, ax: Axes | None = None) -> Axes:
    """The ways of all agents: from above for robots on the ground, in space for drones; drones from above, too, if ``ax`` has two
    dimensions. A ring where each starts, a disc where it ends; obstacles in grey."""
    positions = {agent: log[f"agent_{agent}/state"].position for agent in log.agents}
    flies = log.scenario.get("vehicle", {}).get("kind") == "quadcopter"
    if ax is None:
        import matplotlib.pyplot as plt

        ax = plt.gcf().add_subplot(projection="3d" if flies else None)
    is_spatial = ax.name == "3d"
    coordinates = 3 if flies and is_spatial else 2
    for index, (agent, position) in enumerate(positions.items()):
        curve, colour = position[:, :coordinates].T, COLOURS[index % len(COLOURS)]
        ax.plot(*curve, **style(index), label=f"agent {agent}")
        ax.plot(*curve[:, :1], "o", color=colour, markerfacecolor="none")
        ax.plot(*curve[:, -1:], "o", color=colour)
    obstacles = log.scenario.get("obstacles", {})
    if not flies:
        for centre, radius in zip(obstacles.get("p_obs", []), obstacles.get("r_obs", []), strict=True):
            angle = np.linspace(0, 2 * np.pi, 73)
            ax.fill(centre[0] + radius * np.cos(angle), centre[1] + radius * np.sin(angle), color="#999999")
    ax.set(xlabel="x (m)", ylabel="y (m)")
    if is_spatial:
        ax.set(zlabel="z (m)")
    else:
        ax.set_aspect("equal", "datalim")
    ax.legend(fontsize="small")
    return ax


def errors(log: Log, ax: Axes | None = None) -> Axes:
    """The distance of every agent from its reference over time, over the coordinates that both have."""
    ax = _axes(ax)
    for index, agent in enumerate(log.agents):
        position, target = log[f"agent_{agent}/state"].position, log[f"agent_{agent}/reference"].position
        width = min(position.shape[1], target.shape[1])
        error = np.linalg.norm(position[:, :width] - target[:, :width], axis=1)
        ax.semilogy(log.t, error, **style(index), label=f"agent {agent}")
    ax.set(xlabel="t (s)", ylabel="tracking error")
    ax.legend(fontsize="small", ncols=2)
    return ax


def signal(log: Log, pattern: str, *, norm: bool = False, ax: Axes | None = None) -> Axes:
    """Signals by name over time, ``"agent_*/command/input[0]"``; vectors component by component, or their ``norm``.

    Raises `KeyError` if there is no such signal.
    """
    ax = _axes(ax)
    curves = {}
    for name, array in log.signals(pattern).items():
        if array.ndim == 1:
            curves[name] = array
        elif norm:
            curves[f"|{name}|"] = np.linalg.norm(array, axis=1)
        else:
            curves.update({f"{name}[{index}]": array[:, index] for index in range(array.shape[1])})
    for index, (name, array) in enumerate(curves.items()):
        ax.plot(log.t, array, **style(index), label=name)
    field = pattern.rpartition("/")[2]
    units = {_unit(log, name) for name in log.signals(pattern)}
    unit = units.pop() if len(units) == 1 else ""
    ax.set(xlabel="t (s)", ylabel=f"{field} ({unit})" if unit else field)
    ax.legend(fontsize="small")
    return ax


def compare(curves: Mapping[str, tuple[Any, Any]], *, ylabel: str = "", log_scale: bool = True, ax: Axes | None = None) -> Axes:
    """Curves of several runs in one plot: name to times and values."""
    ax = _axes(ax)
    for index, (name, (time, values)) in enumerate(curves.items()):
        ax.plot(time, values, **style(index), label=name)
    if log_scale:
        ax.set_yscale("log")
    ax.set(xlabel="t (s)", ylabel=ylabel)
    ax.legend(fontsize="small")
    return ax


def _unit(log: Log, name: str) -> str:
    """The unit of a signal, ``agent_1/state/position[2]``."""
    topic, _, field = name.rpartition("/")
    return log[topic].units[field.partition("[")[0]]


def _axes(ax: Axes | None) -> Axes:
    if ax is not None:
        return ax
    import matplotlib.pyplot as plt

    return plt.gca()

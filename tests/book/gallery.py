"""Draws the pictures of the gallery, docs/images/gallery/NAME.webp, one for every scenario that the program lists and for every system
in examples/own-systems.

    pip install "./python[plot]"
    python3 tests/book/gallery.py            # or only some: gallery.py uav rca

Every scenario is run as it stands, in one process, and what its log holds is drawn: the paths of all agents, where they start
(ring) and where they end (disc of their true size, with the heading of robots on the ground), their formation at a few times, obstacles.
Drones are drawn in space. Systems without a place are drawn as a signal over time.
"""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
import phalanx

ROOT = Path(__file__).resolve().parents[2]
FOLDER = ROOT / "docs" / "images" / "gallery"
SYSTEMS = ROOT / "examples" / "own-systems"
#: Systems whose position is no place: the signal that is drawn, its number, and what it is called.
SIGNALS = {
    "oscillators": ("state/phase", None, "phase (rad)"),
    "attitude": ("command/misalignment", None, "misalignment"),
    "pendulum": ("state/position", 0, "first joint (rad)"),
}
#: Seconds that are drawn, of those whose whole run would hide its beginning.
DRAWN = {"compensated": 45, "compensated-experiment": 45, "limited-information": 40, "dsm-cnn": 20, "dsm-ftdo": 25, "lp-regulation": 40, "cida": 60, "rca": 40}
#: Largest size of a picture, bytes.
LARGEST = 60_000


def draw(log: phalanx.Log, seconds: float) -> plt.Figure:
    """The paths of the agents up to a time."""
    steps = int(np.searchsorted(log.t, seconds, side="right"))
    positions = [log[f"agent_{agent}/state"].position[:steps] for agent in log.agents]
    vehicle = log.scenario.get("vehicle", {})
    # A robot among drones is on the ground.
    flies = vehicle.get("kind") == "quadcopter" or vehicle.get("kind") not in ("omni", "integrator") and any(p.shape[1] == 3 for p in positions)
    if flies:
        positions = [np.pad(position, ((0, 0), (0, max(0, 3 - position.shape[1])))) for position in positions]
    figure = plt.figure(figsize=(6.4, 4.8), dpi=100)
    axes = figure.add_subplot(projection="3d" if flies else None)
    count = 3 if flies else 2
    # The formation at a few times: the agents in their order, closed to a ring.
    for moment in np.linspace(0, steps - 1, 6).astype(int)[1:]:
        corners = np.array([position[moment, :count] for position in [*positions, positions[0]]])
        axes.plot(*corners.T, color="#b0b0b0", linewidth=0.9, zorder=1)
    for index, (position, agent) in enumerate(zip(positions, log.scenario["agents"], strict=True)):
        colour = phalanx.plot.COLOURS[index % len(phalanx.plot.COLOURS)]
        axes.plot(*position[:, :count].T, color=colour, linewidth=1.4, label=f"agent {index + 1}")
        axes.plot(*position[:1, :count].T, "o", color=colour, markerfacecolor="white", markersize=6)
        if flies:
            axes.plot(*position[-1:, :3].T, "o", color=colour, markersize=8)
            continue
        x, y = position[-1, :2]
        state = log[f"agent_{index + 1}/state"]
        heading = position[-1, 2] if position.shape[1] > 2 else state.theta[steps - 1] if "theta" in state.fields else None
        radius = agent.get("R", 0.25 if position.shape[1] > 2 else 0.06)
        axes.add_patch(plt.Circle((x, y), radius, color=colour, alpha=0.85, linewidth=0, zorder=3))
        if heading is None:
            continue
        axes.plot([x, x + radius * np.cos(heading)], [y, y + radius * np.sin(heading)], color="white", linewidth=1.6, zorder=4)
    obstacles = log.scenario.get("obstacles", {})
    for centre, radius in zip(obstacles.get("p_obs", []), obstacles.get("r_obs", []), strict=True):
        axes.add_patch(plt.Circle(centre, radius, color="#777777", zorder=2))
    axes.set(xlabel="x (m)", ylabel="y (m)")
    if flies:
        axes.set(zlabel="z (m)")
        axes.view_init(elev=22, azim=-60)
        axes.set_box_aspect((4, 4, 4.6), zoom=1.05)
    else:
        axes.set_aspect("equal", "datalim")
        axes.grid(color="#eeeeee")
    axes.set_title(f"{log.name}, 0 to {min(seconds, log.t[-1]):g} s", fontsize=11)
    figure.tight_layout()
    return figure


def draw_signal(log: phalanx.Log, topic: str, number: int | None, label: str) -> plt.Figure:
    """A signal of all agents over time."""
    figure, axes = plt.subplots(figsize=(6.4, 4.8), dpi=100)
    role, field = topic.split("/")
    for index, agent in enumerate(log.agents):
        values = getattr(log[f"agent_{agent}/{role}"], field)
        colour = phalanx.plot.COLOURS[index % len(phalanx.plot.COLOURS)]
        axes.plot(log.t, values if number is None else values[:, number], color=colour, linewidth=1.4, label=f"agent {index + 1}")
    axes.set(xlabel="t (s)", ylabel=label)
    axes.grid(color="#eeeeee")
    axes.legend(frameon=False)
    axes.set_title(f"{log.name}, 0 to {log.t[-1]:g} s", fontsize=11)
    figure.tight_layout()
    return figure


def main() -> None:
    names = sys.argv[1:]
    if not names:
        listed = subprocess.run([phalanx.find_program(), "list", "--json"], capture_output=True, check=True, text=True)
        names = [scenario["name"] for scenario in json.loads(listed.stdout)]
        names += sorted(path.stem for path in SYSTEMS.glob("*.toml"))
    FOLDER.mkdir(parents=True, exist_ok=True)
    for name in names:
        with tempfile.TemporaryDirectory() as folder:
            file = SYSTEMS / f"{name}.toml"
            log = phalanx.run(file if file.is_file() else name, out=Path(folder) / "run.mcap")
            signal = SIGNALS.get(name)
            figure = draw_signal(log, *signal) if signal else draw(log, DRAWN.get(name, np.inf))
        picture = FOLDER / f"{name}.webp"
        figure.savefig(picture, pil_kwargs={"quality": 82, "method": 6})
        plt.close(figure)
        size = picture.stat().st_size
        print(f"{picture}: {size} bytes")
        if size > LARGEST:
            sys.exit(f"{picture} is larger than {LARGEST} bytes")


if __name__ == "__main__":
    main()

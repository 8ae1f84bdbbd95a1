"""Draws the pictures of the gallery, docs/images/gallery/NAME.webp, one for every scenario that the program lists.

    pip install "./python[plot]"
    python3 tests/book/gallery.py            # or only some: gallery.py uav rca

Every scenario is run as it stands, in one process, and what its log holds is drawn: the paths of all agents, where they start
(ring) and where they end (disc of their true size, with the heading of robots on the ground), their formation at a few times, obstacles.
Drones are drawn in space.
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

FOLDER = Path(__file__).resolve().parents[2] / "docs" / "images" / "gallery"
#: Seconds that are drawn, of those whose whole run would hide its beginning.
DRAWN = {"compensated": 45, "compensated-experiment": 45, "limited-information": 40, "dsm-cnn": 20, "dsm-ftdo": 25, "lp-regulation": 40, "cida": 60, "rca": 40}
#: Largest size of a picture, bytes.
LARGEST = 60_000


def draw(log: phalanx.Log, seconds: float) -> plt.Figure:
    """The paths of the agents up to a time."""
    steps = int(np.searchsorted(log.t, seconds, side="right"))
    positions = [log[f"agent_{agent}/state"].position[:steps] for agent in log.agents]
    flies = log.scenario["vehicle"]["kind"] == "quadcopter"
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
        x, y, heading = position[-1, :3]
        radius = agent.get("R", 0.25)
        axes.add_patch(plt.Circle((x, y), radius, color=colour, alpha=0.85, linewidth=0, zorder=3))
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


def main() -> None:
    names = sys.argv[1:]
    if not names:
        listed = subprocess.run([phalanx.find_program(), "list", "--json"], capture_output=True, check=True, text=True)
        names = [scenario["name"] for scenario in json.loads(listed.stdout)]
    FOLDER.mkdir(parents=True, exist_ok=True)
    for name in names:
        with tempfile.TemporaryDirectory() as folder:
            log = phalanx.run(name, out=Path(folder) / "run.mcap")
            figure = draw(log, DRAWN.get(name, np.inf))
        picture = FOLDER / f"{name}.webp"
        figure.savefig(picture, pil_kwargs={"quality": 82, "method": 6})
        plt.close(figure)
        size = picture.stat().st_size
        print(f"{picture}: {size} bytes")
        if size > LARGEST:
            sys.exit(f"{picture} is larger than {LARGEST} bytes")


if __name__ == "__main__":
    main()

"""Opens a log of `phalanx run` in Rerun: the formation in space, plots of its signals, its journal.

    python3 THIS.py [LOG.mcap] [--save RECORDING.rrd]

`phalanx layout --for rerun` wrote this file. It needs the packages rerun-sdk and phalanx.
"""

import argparse

import numpy as np
import phalanx
import rerun as rr
import rerun.blueprint as rrb

LOG = "@LOG@"
# What is plotted: title, field, topics.
PLOTS = "@PLOTS@"
COLOURS = ["#0072b2", "#e69f00", "#999999", "#56b4e9", "#d55e00", "#009e73", "#cc79a7", "#f0e442"]


def colour(index):
    return [int(COLOURS[index % len(COLOURS)][place : place + 2], 16) for place in (1, 3, 5)]


def places(log, agent):
    """Positions of an agent in space; robots on the ground have none above it."""
    position = log[f"agent_{agent}/state"].position[:, :3].copy()
    if log.scenario.get("vehicle", {}).get("kind") != "quadcopter":
        position[:, 2] = 0
    return position


def send_formation(log, time):
    for index, agent in enumerate(log.agents):
        row = log.scenario["agents"][agent - 1]
        path = places(log, agent)
        rr.log(f"formation/trails/{agent}", rr.LineStrips3D([path[::10]], colors=colour(index), radii=0.01), static=True)
        rr.log(
            f"formation/agents/{agent}",
            rr.Points3D.from_fields(radii=row.get("R", 0.25), colors=colour(index), labels=str(agent)),
            static=True,
        )
        rr.send_columns(f"formation/agents/{agent}", [time], rr.Points3D.columns(positions=path))
    obstacles = log.scenario.get("obstacles", {})
    centres, radii = obstacles.get("p_obs", []), obstacles.get("r_obs", [])
    if centres:
        sizes = [[radius, radius, 0.15] for radius in radii]
        centres = [[x, y, 0.15] for x, y in centres]
        rr.log("formation/obstacles", rr.Ellipsoids3D(centers=centres, half_sizes=sizes, fill_mode="solid"), static=True)


def send_plots(log, time):
    """Sends all curves, and returns a view for every component of every quantity."""
    tabs = []
    for title, field, topics in PLOTS:
        views = []
        width = 1 if log[topics[0]][field].ndim == 1 else log[topics[0]][field].shape[1]
        for component in range(width):
            entity = f"plots/{title.replace(' ', '_')}/{component}"
            for topic in topics:
                values = np.atleast_2d(log[topic][field].T)[component]
                agent = int(topic.split("/")[0].split("_")[1])
                name = f"{entity}/{topic.split('/')[0]}"
                rr.log(name, rr.SeriesLines(colors=colour(log.agents.index(agent)), names=f"agent {agent}"), static=True)
                rr.send_columns(name, [time], rr.Scalars.columns(scalars=values))
            views.append(rrb.TimeSeriesView(origin=entity, name=f"{title}[{component}]" if width > 1 else title))
        tabs.append(rrb.Vertical(*views, name=title))
    return rrb.Tabs(*tabs)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("log", nargs="?", default=LOG)
    parser.add_argument("--save", metavar="RECORDING.rrd", help="write a recording instead of opening the viewer")
    arguments = parser.parse_args()
    log = phalanx.open(arguments.log)
    rr.init(f"phalanx {log.name}")
    rr.save(arguments.save) if arguments.save else rr.spawn()
    time = rr.TimeColumn("time", duration=log.t)
    send_formation(log, time)
    plots = send_plots(log, time)
    formation = rrb.Spatial3DView(origin="formation", name="formation")
    rr.send_blueprint(rrb.Blueprint(rrb.Horizontal(formation, plots), collapse_panels=True))


if __name__ == "__main__":
    main()

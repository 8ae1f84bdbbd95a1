"""Reads a Phalanx log with Rerun's own reader, and says what Rerun makes of it.

    read_rerun.py run.mcap

Prints, for every topic, how many messages Rerun read and as what it understands them: `Transform3D` and `TextLog` are drawn by
themselves, `message` is a structure whose numbers can be plotted. Exit code 1 if the place of agent 1 at the end is not that of its
signal.
"""

import sys

import numpy
from rerun.chunk import McapReader


def state_column(columns):
    """The column of the state, whose type ends in the digest of its definition."""
    return next(name for name in columns if name.startswith("phalanx_msgs.msg.State") and name.endswith(":message"))


def main():
    rows, kinds, places, states = {}, {}, {}, {}
    for chunk in McapReader(sys.argv[1]).stream():
        batch = chunk.to_record_batch()
        names = [name for name in batch.schema.names if ":" in name and not name.startswith("Mcap")]
        if not names or chunk.entity_path.startswith("/__"):
            continue
        topic = chunk.entity_path
        rows[topic] = rows.get(topic, 0) + chunk.num_rows
        kinds.setdefault(topic, set()).update(name.split(":")[0 if name.split(":")[0][0].isupper() else 1] for name in names)
        if topic not in ("/tf", "/agent_1/state"):
            continue
        columns = {name: batch.column(name).to_pylist() for name in batch.schema.names}
        for index, time in enumerate(columns["message_log_time"]):
            if topic == "/agent_1/state":
                states[time] = columns[state_column(columns)][index][0]["position"]
            elif columns["Transform3D:child_frame"][index][0] in ("agent_1", "tf#/agent_1"):
                places[time] = columns["Transform3D:translation"][index][0]
    last = max(places)
    expected = states[last][:2]
    # Rerun keeps places with single precision.
    if not numpy.allclose(places[last][:2], expected, rtol=0, atol=1e-5):
        sys.exit(f"agent 1 at the end: Rerun says {places[last]}, its signal {expected}")
    for topic in sorted(rows):
        print(topic, rows[topic], *sorted(kinds[topic]))


main()

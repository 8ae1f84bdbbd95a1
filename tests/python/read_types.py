"""Opens logs of Phalanx together, with the stock reader `rosbags`, and checks what ROS 2 asks of their channels.

    read_types.py first.mcap second.mcap ...

Every pair of logs is opened as one bag, and every message of it is decoded; the hash in `topic_type_hash` of every channel has to
be the one that `rosbags` computes of the type, and `offered_qos_profiles` has to say what a publisher of it offers. Prints a line per
pair: its names, and how many messages were decoded.
"""

import itertools
import sys
from pathlib import Path

from mcap.reader import make_reader
from rosbags.highlevel import AnyReader
from rosbags.rosbag2.metadata import parse_qos


def channels(path):
    """Topic, type and metadata of every channel."""
    with open(path, "rb") as stream:
        summary = make_reader(stream).get_summary()
    for channel in summary.channels.values():
        yield channel.topic, summary.schemas[channel.schema_id].name, channel.metadata


def is_lasting(topic):
    """Whether a reader that comes late is to get the last message."""
    return topic.startswith("/scene/") or topic in ("/rosout", "/phalanx/assertions", "/phalanx/events")


def check_channels(path):
    with AnyReader([path]) as reader:
        for topic, kind, metadata in channels(path):
            expected = reader.typestore.hash_rihs01(kind)
            if metadata["topic_type_hash"] != expected:
                sys.exit(f"{path}: {topic}: {metadata['topic_type_hash']} is not {expected}")
            (profile,) = parse_qos(metadata["offered_qos_profiles"])
            found = profile.reliability.name, profile.durability.name, profile.history.name
            wanted = "RELIABLE", "TRANSIENT_LOCAL" if is_lasting(topic) else "VOLATILE", "KEEP_LAST"
            if found != wanted:
                sys.exit(f"{path}: {topic} offers {found}, expected {wanted}")


def check_pair(pair):
    count = 0
    with AnyReader(list(pair)) as reader:
        for connection, _, raw in reader.messages():
            reader.deserialize(raw, connection.msgtype)
            count += 1
    print(*(path.name for path in pair), count)


def main():
    paths = [Path(argument) for argument in sys.argv[1:]]
    for path in paths:
        check_channels(path)
    for pair in itertools.combinations(paths, 2):
        check_pair(pair)


main()

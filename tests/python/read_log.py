"""Reads a Phalanx log with the two stock Python readers of ROS 2 logs, which know nothing of Phalanx.

    read_log.py run.mcap --summary
    read_log.py run.mcap --topic /agent_1/state --field position --time 0.01

Prints `reader value value ...` for each reader, with 17 significant digits; exit code 1 if they disagree, and 2 if there
is no such sample.
"""

import argparse
import sys
from pathlib import Path

from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from rosbags.highlevel import AnyReader


def numbers(value):
    """A scalar or a sequence as a list of floats."""
    return [float(item) for item in value] if hasattr(value, "__len__") else [float(value)]


def with_mcap(path, topic, field, time_ns):
    with open(path, "rb") as stream:
        reader = make_reader(stream, decoder_factories=[DecoderFactory()])
        for _, _, _, decoded in reader.iter_decoded_messages([topic], starting_at=time_ns, ending_at=time_ns):
            return numbers(getattr(decoded, field))
    return None


def with_rosbags(path, topic, field, time_ns):
    with AnyReader([path]) as reader:
        connections = [connection for connection in reader.connections if connection.topic == topic]
        if not connections:
            # An empty list would mean all of them.
            return None
        for connection, _, raw in reader.messages(connections=connections, start=time_ns, stop=time_ns + 1):
            return numbers(getattr(reader.deserialize(raw, connection.msgtype), field))
    return None


def summary_with_mcap(path):
    with open(path, "rb") as stream:
        summary = make_reader(stream).get_summary()
    counts = summary.statistics.channel_message_counts
    return {channel.topic: counts.get(number, 0) for number, channel in summary.channels.items()}


def summary_with_rosbags(path):
    with AnyReader([path]) as reader:
        return {connection.topic: connection.msgcount for connection in reader.connections}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("log", type=Path)
    parser.add_argument("--summary", action="store_true", help="list topics and numbers of messages")
    parser.add_argument("--topic")
    parser.add_argument("--field", help="a field of the layout, or step, agent, status")
    parser.add_argument("--time", type=float, help="simulated time, seconds")
    arguments = parser.parse_args()

    if arguments.summary:
        topics = summary_with_mcap(arguments.log)
        for topic in sorted(topics):
            print(topic, topics[topic])
        if topics != summary_with_rosbags(arguments.log):
            sys.exit("the readers disagree on the topics")
        return 0
    if arguments.topic is None or arguments.field is None or arguments.time is None:
        parser.error("give --summary, or --topic, --field and --time")
    wanted = arguments.topic, arguments.field, round(arguments.time * 1e9)
    found = {"mcap": with_mcap(arguments.log, *wanted), "rosbags": with_rosbags(arguments.log, *wanted)}
    if None in found.values():
        print(f"no sample of {arguments.topic} at {arguments.time} s: {found}", file=sys.stderr)
        return 2
    for reader, values in found.items():
        print(reader, *(f"{value:.17g}" for value in values))
    if found["mcap"] != found["rosbags"]:
        print("the readers disagree", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())

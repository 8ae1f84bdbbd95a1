"""Reads what viewers draw from a Phalanx log, with the stock readers `mcap-ros2-support` and `rosbags`, and compares it with the
signals that it was made of.

    read_scene.py run.mcap

Prints, for both readers, how many messages of which topic were decoded; exit code 1 if a message does not say what the signals say,
or if the readers disagree.
"""

import sys
from pathlib import Path

import numpy
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from rosbags.highlevel import AnyReader

TOPICS = ["/tf", "/rosout", "/scene/bodies", "/scene/links", "/scene/trails", "/scene/poses", "/scene/targets", "/scene/obstacles"]


def with_mcap(path, topics):
    """Topic, time in ns and message."""
    with open(path, "rb") as stream:
        reader = make_reader(stream, decoder_factories=[DecoderFactory()])
        for _, channel, message, decoded in reader.iter_decoded_messages(topics):
            yield channel.topic, message.log_time, decoded


def with_rosbags(path, topics):
    with AnyReader([Path(path)]) as reader:
        connections = [connection for connection in reader.connections if connection.topic in topics]
        for connection, time, raw in reader.messages(connections=connections):
            yield connection.topic, time, reader.deserialize(raw, connection.msgtype)


def vector(value):
    return [getattr(value, name) for name in "xyzw" if hasattr(value, name)]


def rotated(quaternion):
    """The rotation matrix of a quaternion x, y, z, w."""
    x, y, z, w = quaternion
    return numpy.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )


def expected_rotation(position):
    """Of x, y, heading or of x, y, z, roll, pitch, yaw."""
    angles = [0, 0, position[2]] if len(position) == 3 else position[3:6]
    (cr, sr), (cp, sp), (cy, sy) = ((numpy.cos(angle), numpy.sin(angle)) for angle in angles)
    about_x = numpy.array([[1, 0, 0], [0, cr, -sr], [0, sr, cr]])
    about_y = numpy.array([[cp, 0, sp], [0, 1, 0], [-sp, 0, cp]])
    about_z = numpy.array([[cy, -sy, 0], [sy, cy, 0], [0, 0, 1]])
    return about_z @ about_y @ about_x


def place(position):
    return [*position[:2], 0.0] if len(position) == 3 else list(position[:3])


def near(actual, expected, what):
    if not numpy.allclose(actual, expected, rtol=0, atol=1e-12):
        sys.exit(f"{what}: found {actual}, expected {expected}")


def check(read, path):
    """Numbers of messages by topic, after all of them were held against the signals."""
    positions = {}
    state = [f"/agent_{agent}/state" for agent in range(1, 100)]
    for topic, time, message in read(path, state):
        positions[topic.split("/")[1], time] = list(message.position)
    agents = sorted({frame for frame, _ in positions}, key=lambda frame: int(frame.split("_")[1]))
    counts, texts = dict.fromkeys(TOPICS, 0), []
    for topic, time, message in read(path, TOPICS):
        counts[topic] += 1
        match topic:
            case "/tf":
                if [transform.child_frame_id for transform in message.transforms] != agents:
                    sys.exit(f"frames: {[transform.child_frame_id for transform in message.transforms]}")
                for transform in message.transforms:
                    position = positions[transform.child_frame_id, time]
                    stamp = transform.header.stamp
                    near(stamp.sec * 10**9 + stamp.nanosec, time, "stamp")
                    near(vector(transform.transform.translation), place(position), "translation")
                    near(rotated(vector(transform.transform.rotation)), expected_rotation(position), "rotation")
            case "/scene/poses":
                for agent, pose in zip(agents, message.poses, strict=True):
                    near(vector(pose.position), place(positions[agent, time]), "pose")
            case "/scene/links":
                ends = [vector(point) for marker in message.markers for point in marker.points]
                known = [place(positions[agent, time]) for agent in agents]
                if not all(end in known for end in ends) or any(m.type != 5 for m in message.markers):
                    sys.exit("a link ends where no agent is")
            case "/scene/bodies":
                if {marker.header.frame_id for marker in message.markers} != set(agents):
                    sys.exit("a body is in the frame of no agent")
                labels = [marker.text for marker in message.markers if marker.type == 9]
                if labels != [agent.split("_")[1] for agent in agents]:
                    sys.exit(f"labels: {labels}")
            case "/scene/trails":
                for agent, marker in zip(agents, message.markers, strict=True):
                    if time % 500_000_000 == 0:
                        end = numpy.float32(place(positions[agent, time]))
                        near(vector(marker.points[-1]), end, "end of a trail")
            case "/rosout":
                texts.append((message.level, message.name, message.msg))
    return counts, texts


def main():
    path = sys.argv[1]
    found = {name: check(read, path) for name, read in (("mcap-ros2-support", with_mcap), ("rosbags", with_rosbags))}
    for name, (counts, texts) in found.items():
        print(name, *(f"{topic}={count}" for topic, count in counts.items() if count))
        for text in texts:
            print(name, *text, sep="|")
    if len({repr(result) for result in found.values()}) > 1:
        sys.exit("the readers disagree")


main()

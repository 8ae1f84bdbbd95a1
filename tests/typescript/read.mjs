// Reads a log with the packages that Foxglove and Lichtblick read it with, every message of every topic:
//   npm ci && node read.mjs run.mcap
// Prints a line per topic: its name, its type, how many messages were decoded, and the last one as JSON.

import { open } from "node:fs/promises";
import { parse } from "@foxglove/rosmsg";
import { MessageReader } from "@foxglove/rosmsg2-serialization";
import { McapIndexedReader } from "@mcap/core";
import { decompress } from "fzstd";

const [path] = process.argv.slice(2);
if (!path) throw new Error("usage: node read.mjs LOG.mcap");

const file = await open(path);
const size = (await file.stat()).size;
const readable = {
  size: async () => BigInt(size),
  read: async (offset, length) => {
    const bytes = new Uint8Array(Number(length));
    await file.read(bytes, 0, bytes.length, Number(offset));
    return bytes;
  },
};
const reader = await McapIndexedReader.Initialize({
  readable,
  decompressHandlers: { zstd: (bytes, length) => decompress(bytes, new Uint8Array(Number(length))) },
});

const decoders = new Map();
const topics = new Map();
for await (const message of reader.readMessages()) {
  const channel = reader.channelsById.get(message.channelId);
  const schema = reader.schemasById.get(channel.schemaId);
  if (!decoders.has(schema.id)) {
    const text = new TextDecoder().decode(schema.data);
    decoders.set(schema.id, new MessageReader(parse(text, { ros2: true })));
  }
  const topic = topics.get(channel.topic) ?? { type: schema.name, count: 0 };
  topic.count += 1;
  topic.last = decoders.get(schema.id).readMessage(message.data);
  topics.set(channel.topic, topic);
}
await file.close();

// Typed arrays as lists, 64-bit integers as numbers.
const plain = (_, value) => (ArrayBuffer.isView(value) ? Array.from(value) : typeof value === "bigint" ? Number(value) : value);
for (const [name, { type, count, last }] of topics) console.log(name, type, count, JSON.stringify(last, plain));

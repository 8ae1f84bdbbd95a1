#!/usr/bin/env bash
# What it costs a run that somebody looks on: pairs of runs of `uav`, recorded, as fast as possible, without and with
# `phalanx watch --web`, whose frames are read by curl. Prints steps/s of every pair, the frames, and the ratio of the medians.
#   benches/watch_cost.sh [PAIRS]
set -euo pipefail
cd "$(dirname "$0")/.."
phalanx="$PWD/target/release/phalanx"
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

speed() {
    "$phalanx" run uav --set metrics= --json -q --out "$folder/run.mcap" 2>/dev/null |
        sed 's/.*"steps_per_s":\([0-9]*\).*/\1/'
}

for _ in $(seq "${1:-9}"); do
    without=$(speed)
    "$phalanx" watch --web --no-open uav >"$folder/watch.txt" 2>&1 &
    watch=$!
    # The address is known once the run goes on.
    (
        until grep -q http: "$folder/watch.txt"; do sleep 0.02; done
        exec curl -sN "$(grep -o 'http://[^ ]*' "$folder/watch.txt")events"
    ) >"$folder/frames.txt" &
    reader=$!
    sleep 0.3
    with=$(speed)
    wait "$watch"
    kill "$reader" 2>/dev/null || true
    echo "$without $with"
    echo "without $without steps/s, with $with, $(grep -c '^data' "$folder/frames.txt") frames" >&2
done | awk '
    function median(list, count) { return count % 2 ? list[(count + 1) / 2] : (list[count / 2] + list[count / 2 + 1]) / 2 }
    function sort(list, count,   i, j, x) {
        for (i = 2; i <= count; i++) { x = list[i]; for (j = i - 1; j > 0 && list[j] > x; j--) list[j + 1] = list[j]; list[j + 1] = x }
    }
    { a[NR] = $1 + 0; b[NR] = $2 + 0 }
    END { sort(a, NR); sort(b, NR); x = median(a, NR); y = median(b, NR)
          printf "medians: %d steps/s without, %d with; ratio %.3f\n", x, y, y / x }'

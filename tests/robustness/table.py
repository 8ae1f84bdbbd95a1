"""How much delay, loss, noise and sampling each scheme of the thesis bears: docs/robustness.md.

    python3 tests/robustness/table.py target/release/phalanx > docs/robustness.md

A number is the largest one that was found at which the run goes to its end and every statement of the thesis that holds without it still
holds, with each of three seeds where numbers are random. It is found by bisection on a logarithmic scale, so it takes for granted
that more is worse.
"""

import json
import os
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor

SEEDS = (1, 2, 3)
STEPS = 7


class Kind:
    """What is varied: its name with its unit, the overrides for a number, the range, and whether it is random."""

    def __init__(self, title, overrides, low, high, random):
        self.title, self.overrides, self.low, self.high, self.random = title, overrides, low, high, random


def of_sensors(field, transform=lambda number: number):
    return lambda number, signals: [f"sensors.{signal}.{field}={transform(number):.6g}" for signal in signals]


KINDS = [
    Kind("delay of measurements, s", of_sensors("delay"), 1e-3, 1.0, False),
    Kind("period of measurements, s", of_sensors("rate_hz", lambda period: 1 / period), 1e-3, 1.0, False),
    Kind("noise of positions, m", lambda number, _: [f"sensors.position.noise={number:.6g}"], 1e-6, 1.0, True),
    Kind("delay of links, s", lambda number, _: [f"links.delay={number:.6g}"], 1e-3, 1.0, False),
    Kind("loss of links", lambda number, _: [f"links.loss={number:.6g}"], 1e-3, 0.9, True),
]


class Scheme:
    """A variant of a scenario."""

    def __init__(self, program, scenario, variant):
        self.program, self.scenario, self.variant = program, scenario, variant
        nominal = self.run([])
        self.met = [name for name, metric in nominal["metrics"].items() if metric["against_thesis"] == "met"]
        channels = json.loads(self.call("graph", ["links.delay=0.001"], "--json") or "{}").get("channels", [])
        self.has_links = any("/from_" in channel.get("topic", channel.get("name", "")) for channel in channels)
        fields = {field["name"] for channel in channels[:1] for field in channel["fields"]}
        self.signals = [signal for signal in ("position", "velocity") if signal in fields]

    def call(self, command, overrides, *more):
        words = [self.program, command, self.scenario, *(["--variant", self.variant] if self.variant else [])]
        for override in overrides:
            words += ["--set", override]
        return subprocess.run([*words, *more], capture_output=True, text=True, check=False).stdout

    def run(self, overrides):
        with tempfile.TemporaryDirectory(dir="/dev/shm") as folder:
            out = os.path.join(folder, "run.mcap")
            text = self.call("run", overrides, "--placement", "single", "--strict", "-q", "--json", "--out", out)
        return json.loads(text) if text.strip() else {"ending": "refused", "metrics": {}}

    def holds(self, kind, number):
        for seed in SEEDS if kind.random else SEEDS[:1]:
            seeds = [f"seed={seed}"] if kind.random else []
            outcome = self.run(kind.overrides(number, self.signals) + seeds)
            verdicts = outcome["metrics"]
            if outcome["ending"] != "complete" or any(
                verdicts.get(name, {}).get("against_thesis") != "met" for name in self.met
            ):
                return False
        return True

    def limit(self, kind):
        if not self.met:
            return "-"
        if "links" in kind.title and not self.has_links:
            return "any"
        if not self.holds(kind, kind.low):
            return f"< {kind.low:g}"
        if self.holds(kind, kind.high):
            return f">= {kind.high:g}"
        low, high = kind.low, kind.high
        for _ in range(STEPS):
            middle = (low * high) ** 0.5
            low, high = (middle, high) if self.holds(kind, middle) else (low, middle)
        return f"{low:.2g}"


def row(program, scenario, variant):
    scheme = Scheme(program, scenario, variant)
    label = f"{scenario} {variant}".strip()
    print(label, file=sys.stderr)
    return [label, str(len(scheme.met)), *(scheme.limit(kind) for kind in KINDS)]


def main():
    program = os.path.abspath(sys.argv[1])
    listed = json.loads(subprocess.run([program, "list", "--json"], capture_output=True, text=True, check=True).stdout)
    jobs = [(one["name"], variant) for one in listed if one.get("thesis") for variant in (one.get("variants") or [""])]
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        rows = list(pool.map(lambda job: row(program, *job), jobs))
    rows = [one for one in rows if one[1] != "0"]
    head = ["scheme", "statements", *(kind.title for kind in KINDS)]
    print(PAGE + "\n".join("| " + " | ".join(cells) + " |" for cells in [head, ["---"] * len(head), *rows]))


PAGE = """# Robustness of the schemes

The thesis assumes that every agent knows the states of its neighbours exactly, at once and in every step. This table tells how much each
scheme bears until the first of the statements of the thesis that its run meets (`statements`) is not met any more. All measurements of
positions and velocities are delayed or sampled alike; noise is white, of positions only; links lose or delay what an agent reads of
others, and `any` means that the controllers read nothing of others. A delay counts in steps of the scenario, 1 to 10 ms, and a period below
a step is a step. Statements such as "the estimate grows without bound" hold whatever happens.

How to read it: what a scheme claims to a micrometre is lost with a micrometre of noise, while the formation may fly on. `uav` and `mixed` plan all
virtual agents in one place, so that the links between the vehicles carry nothing: that is what their hierarchy means for a network.

`python3 tests/robustness/table.py target/release/phalanx > docs/robustness.md` makes this page. Each number is the largest one found by bisection
(seven halvings on a logarithmic scale; about half an hour on two cores), random ones with three seeds, all of which must hold.

"""

if __name__ == "__main__":
    main()

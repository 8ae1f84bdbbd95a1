"""What a step of a program in the place of controller 3 of the drones takes, beside the controller that it replaces.

    python3 benches/own_programs.py [NAME=COMMAND ...]

`compute` is the time from the start of the controller to its arrival: fetching what it reads, computing, publishing; `ratio` is that
beside ours. `step` is the whole step of all 15 processes. Without arguments: the controllers of the examples in Rust, C++ and Python
as far as they can be built or found, and one in Python that reads and writes all signals and computes nothing, which is what the
interface costs. Python is that of this script, which needs the package (`pip install ./python`).
"""

from __future__ import annotations

import os
import re
import shutil
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

REPOSITORY = Path(__file__).resolve().parents[1]
PROGRAM = os.environ.get("PHALANX") or str(REPOSITORY / "target/release/phalanx")
# 2000 steps of 1 ms: a drone that nobody steers is not far yet. Of this many runs the median counts.
FLIGHT, RUNS = ["--dt", "0.001", "--duration", "2"], 7
BOUND = 50.0

INTERFACE_ONLY = """
import phalanx
with phalanx.Participant() as me:
    inputs = [me.state(name, 6) for name in ("position", "velocity")] + [me.estimate("disturbance", 6)]
    inputs += [me.reference(name, 3) for name in ("position", "velocity", "acceleration")]
    command = me.output("input", 4)
    shown = [me.output(name, 3) for name in ("attitude_reference", "xi1", "xi2", "sliding_position", "sliding_attitude")]
    for step in me:
        values = [signal.value for signal in inputs]
        command.value[:] = 20.0
        for output in shown:
            output.value[:] = values[3]
"""


def measure(command: str | None) -> tuple[float, float]:
    """Microseconds of controller 3, and of the whole step."""
    # A drone that nobody steers tilts; nobody minds here.
    words = [PROGRAM, "run", "uav", *FLIGHT, "-q", "--no-log", "--profile", os.devnull, "--set", "assert=[]"]
    words += ["--swap", f"controller.3={command}"] if command else []
    done = subprocess.run(words, capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"{' '.join(words)}\n{done.stderr}")
    compute = re.search(r"^controller_3 +([\d.]+) us", done.stdout, re.MULTILINE)
    step = re.search(r"^per step: ([\d.]+) us", done.stdout, re.MULTILINE)
    if not compute or not step:
        sys.exit(f"no profile in the output of {PROGRAM}:\n{done.stdout}")
    return float(compute[1]), float(step[1])


def examples(folder: Path) -> dict[str, str]:
    """The controllers of the examples that are not in Python, as far as there is a compiler and a library."""
    programs: dict[str, str] = {}
    release = REPOSITORY / "target/release"
    if (rust := release / "examples/controller-rust").exists():
        programs["Rust, the same law"] = f"'{rust}'"
    if shutil.which("c++") and (release / "libphalanx.so").exists():
        source, program = REPOSITORY / "examples/controller-cpp/controller.cpp", folder / "controller"
        flags = ["-std=c++17", "-O2", "-ffp-contract=off", f"-I{REPOSITORY / 'capi/include'}"]
        library = [f"-L{release}", "-lphalanx", f"-Wl,-rpath,{release}"]
        subprocess.run(["c++", *flags, str(source), "-o", str(program), *library], check=True)
        programs["C++, the same law"] = f"'{program}'"
    return programs


def main() -> None:
    with tempfile.TemporaryDirectory() as folder:
        script = Path(folder) / "interface_only.py"
        script.write_text(INTERFACE_ONLY)
        programs: dict[str, str | None] = {"ours (Rust)": None}
        example = REPOSITORY / "examples/controller-python/uav_controller.py"
        if len(sys.argv) > 1:
            programs |= dict(argument.split("=", 1) for argument in sys.argv[1:])
        else:
            programs |= examples(Path(folder))
            programs["Python, nothing computed"] = f"'{sys.executable}' '{script}'"
            programs["Python, the same law"] = f"'{sys.executable}' '{example}'"
        figures: dict[str, list[tuple[float, float]]] = {name: [] for name in programs}
        # In turns, so that what else the machine does meets all of them.
        for _ in range(RUNS):
            for name, command in programs.items():
                figures[name].append(measure(command))
    print(f"{'controller 3':<28}{'compute':>12}{'ratio':>9}{'step':>12}")
    ours = statistics.median(compute for compute, _ in figures["ours (Rust)"])
    for name, pairs in figures.items():
        compute, step = (statistics.median(values) for values in zip(*pairs))
        print(f"{name:<28}{compute:>9.1f} us{compute / ours:>9.2f}{step:>9.1f} us")
    print(f"bound for the step overhead of a controller in Python: {BOUND:.0f} us")


if __name__ == "__main__":
    main()

"""Participants in Python in real runs."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

REPOSITORY = Path(__file__).resolve().parents[2]
EXAMPLE = REPOSITORY / "examples/controller-python/uav_controller.py"

# A controller that only tells what it finds; what it prints goes to the stderr of the run.
TELLING = """
import gc, sys
import numpy as np
import phalanx

me = phalanx.Participant()
position, before = me.state("position", 6), me.state("position", 6)
command = me.output("input", 4)
print("me", me.name, me.agent, me.agents, me.dt, me.steps, file=sys.stderr)
print("values", me.number("controller.c_p"), me.text("controller.intro"), me.length("agents"), file=sys.stderr)
print("values", me.has("controller.nothing"), me.model("m"), me.model("R", agent=2), len(command), file=sys.stderr)
kept = []
for step in me:
    view = position.value
    assert not view.flags.owndata and not view.flags.writeable and view.shape == (6,)
    assert np.shares_memory(view, before.value) and position.value is view
    command.value[:] = [20.0, 0.0, 0.0, 0.0]
    assert np.array_equal(command.value, [20.0, 0.0, 0.0, 0.0]) and not command.value.flags.owndata
    kept = [view, command.value]
print("last", step.index, step.time, file=sys.stderr)
del me, position, before, command
gc.collect()
print("kept", all(np.isfinite(view).all() for view in kept), file=sys.stderr)
"""


@pytest.mark.parametrize(("variant", "node"), [("TSC", "controller.3"), ("TOC", "controller_6"), ("multirate", "controller.1")])
def test_the_example_gives_the_log_of_the_controller_that_it_replaces(run, variant: str, node: str) -> None:
    flight = ("run", "uav", "--variant", variant, "--duration", "3", "-q", "--json")
    run(*flight, "--out", "ours.mcap")
    swap = f"{node}='{sys.executable}' '{EXAMPLE}'"
    run(*flight, "--out", "theirs.mcap", "--swap", swap)
    # The log names the program that played; the samples are the same.
    assert run("verify", "ours.mcap", "theirs.mcap", "--json").json["equal"]


@pytest.mark.parametrize("page", ["python/README.md", "docs/adding-a-controller.md", "docs/coming-from.md"])
def test_the_controllers_of_the_documentation_fly(run, tmp_path: Path, page: str) -> None:
    shown = [block.split("```")[0] for block in (REPOSITORY / page).read_text().split("```python\n")[1:]]
    shown = [program for program in shown if "phalanx.Participant" in program]
    assert len(shown) == 1
    script = tmp_path / "my_controller.py"
    script.write_text(shown[0])
    done = run("run", "triangle", "-q", "--swap", f"controller.3='{sys.executable}' '{script}'")
    assert done.code == 0, done.stdout + done.stderr


def test_a_participant_knows_where_it_is_and_its_views_outlive_it(swapped) -> None:
    done = swapped(TELLING)
    assert done.has_flown, done.stderr
    for line in (
        "me controller_3 3 6 0.01 51",
        "values 2.0 logistic 6",
        "values False 2.11 0.31 4",
        "last 50 0.5",
        "kept True",
    ):
        assert line in done.stderr


# An observer that knows nothing.
BLIND = """
import phalanx
with phalanx.Participant("observer") as me:
    names = {"disturbance": 6, "weight_norm": 1, "velocity": 6, "position": 6}
    outputs = [me.output(name, length) for name, length in names.items()]
    for step in me:
        for output in outputs:
            output.value = [0.25] * len(output)
"""


def test_an_observer_can_be_replaced_too(run, swapped) -> None:
    done = swapped(BLIND, node="observer.2")
    assert done.has_flown, done.stderr
    last = run("echo", "mine.mcap", "agent_2/estimate", "disturbance", "--at", "0.5").stdout.split()
    assert last.count("0.25") == 6, last


def test_who_serves_all_agents_names_one(swapped) -> None:
    source = "import phalanx\nme = phalanx.Participant('planner')\nassert me.agent == 0\nme.output('position', 3)"
    done = swapped(source, node="planner")
    assert done.code == 3 and "serves all agents; name one" in done.stderr, done.stderr


# A controller that asks for what there is and what there is not, and flies on.
ASKING = """
import sys
import numpy as np
import phalanx

def say(*words):
    print(*words, file=sys.stderr, flush=True)

with phalanx.Participant() as me:
    say("graph", me.weight(1, 3), me.weight(1, 2), me.b(2), me.neighbours(), me.neighbours(1))
    say("numbers", me.number("agents.2.position.3"), me.number("topology.A.1.3"), me.number("topology.b.1"), me.number("agents.1.m"))
    say("disturbance", me.disturbance(2, np.pi / 2, np.zeros(3)).tolist(), me.mismatched(2, 1.0, [0, 0, 0]).tolist())
    command = me.output("input", 3)
    for attempt in (
        lambda: me.number("controller.k_q"),
        lambda: me.state("positon", 3),
        lambda: me.weight(1, 7),
        lambda: me.text("timing.dt"),
        lambda: me.length("timing.dt"),
        lambda: me.output("inptu", 3),
        lambda: command.value,
    ):
        try:
            attempt()
        except phalanx.PhalanxError as error:
            assert "phalanx_" not in str(error), error
            say("caught", error)
    own, speed, target = me.state("position", 3), me.state("velocity", 3), me.reference("position", 3)
    for step in me:
        command.value = 4 * (target.value - own.value) - 4 * speed.value
        try:
            me.number("controller.k_q")
        except phalanx.PhalanxError:
            pass
"""


def test_what_is_caught_stays_caught(run, tmp_path: Path) -> None:
    script = tmp_path / "asking.py"
    script.write_text(ASKING)
    swap = f"controller.2='{sys.executable}' '{script}'"
    done = run("run", "triangle", "--duration", "1", "-q", "--set", "assert=[]", "--swap", swap)
    assert done.code == 0, done.stderr
    for line in (
        "graph 1.0 0.0 1.0 [1] [3]",
        "numbers 1.5707963267948966 1.0 1.0 1.0",
        "disturbance [0.1, 6.123233995736766e-18, 0.0] [0.0, 0.0, 0.0]",
        "caught the scenario has no number called `controller.k_q`; did you mean `controller.k_v`?",
        "caught there is no agent 7; the scenario has 3, counted from 1",
        "caught `timing.dt` of the scenario is not a text, but the number 0.01",
        "it declares input (3), error (3)",
        "caught `input`.value is there within a step only, in `for step in participant:`",
    ):
        assert line in done.stderr, done.stderr


START = """
import phalanx
with phalanx.Participant() as me:
    position, command = me.state("position", 6), me.output("input", 4)
"""
LOOP = """
    for step in me:
        command.value = [20.0, 0.0, 0.0, 0.0]
        if step.index == 7:
"""

MISTAKES = {
    "signal": (START + "    me.state('postion', 6)", ["`postion`", "agent 3", "position"]),
    "length": (START + "    me.state('position', 3)", ["`position` (3 values)", "position (6"]),
    "unread": (START + "    me.state('position', 6, agent=5)", ["agent 5", "does not read"]),
    "channel": (START + "    me.input('sttae', 'position', 6)", ["sttae", "state"]),
    "output": (START + "    me.output('inputs', 4)", ["inputs"]),
    "number": (START + "    me.number('controller.c_q')", ["controller.c_q"]),
    "model": (START + "    me.model('mass')", ["mass"]),
    "role": ("import phalanx\nphalanx.Participant('observer')", ["controller_3", "observer"]),
    "early": (START + "    position.value", ["`position`.value is there within a step only"]),
    "late": (START + LOOP + "            me.state('velocity', 6)", ["step"]),
    "fail": (START + LOOP + "            me.fail('the target is out of reach')", ["the target is out of reach", "step 7"]),
    "nan": (START + LOOP + "            command.value[2] = float('nan')", ["input[2] is NaN", "step 7"]),
    "shape": (START + LOOP + "            command.value = [1.0]", ["`input` takes 4 numbers", "(1,)", "mine.py", "step 7"]),
    "bug": (START + LOOP + "            1 / 0", ["ZeroDivisionError", "line 9 of", "mine.py", "step 7"]),
    "readonly": (START + LOOP + "            position.value[0] = 1", ["read-only", "mine.py", "step 7"]),
    "unwritten": (START + "    for step in me:\n        pass", ["`input` was not written", "step 0"]),
    "syntax": ("import phalanx\nwith phalanx.Participant( as me:", ["SyntaxError"]),
}


@pytest.mark.parametrize("mistake", MISTAKES)
def test_a_mistake_ends_the_run_in_words(swapped, mistake: str) -> None:
    source, words = MISTAKES[mistake]
    done = swapped(source)
    assert done.code == 3, done.stderr
    assert "controller_3" in done.stderr
    if mistake != "syntax":
        assert "Traceback" in done.stderr, "the program was not told"
    said = done.stderr.split("error: ")[-1]
    for word in words:
        assert word in said, done.stderr

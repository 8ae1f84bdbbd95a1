"""Results of runs, however they end, and runs side by side."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
import threading
import time
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from pathlib import Path

import phalanx
import pytest

CRASHING = """
import phalanx
with phalanx.Participant() as me:
    command = me.output("input", 3)
    for step in me:
        command.value = [0, 0, 0]
        if step.index == 20:
            raise ValueError("out of fuel")
"""


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_a_violated_assertion_is_a_result() -> None:
    gap = {"name": "gap", "metric": "gap", "min": 5, "severity": "fail"}
    log = phalanx.run("triangle", duration=2, set={"assert": [gap]})
    assert (log.ok, log.ending) == (False, "violated")
    assert not log.assertions["gap"].ok and log.assertions["gap"].first["time"] == 0
    # The default set: the scenario names none.
    assert log.metrics["gap_min"].value < 5 and log.metrics["tracking_end"].unit == "m"
    assert log.log["agent_1/state"].position.shape == (201, 3)
    again = phalanx.open(log)
    assert not again.ok and again.assertions == log.assertions and again.metrics == log.metrics


def test_a_participant_that_fails_is_a_result(folder: Path) -> None:
    (folder / "crashing.py").write_text(CRASHING)
    log = phalanx.run("triangle", swap={"controller.2": f"'{sys.executable}' crashing.py"})
    assert (log.ok, log.ending) == (False, "failed")
    assert "out of fuel" in log.faults[-1].text and "controller_2" in log.faults[-1].text
    assert 0 < len(log.t) <= 21
    assert not phalanx.open(log).ok


def test_an_interrupted_run_is_a_result(folder: Path) -> None:
    found = []
    run = threading.Thread(target=lambda: found.append(phalanx.run("triangle", duration=1000, options=["--realtime"])))
    run.start()
    me = str(os.getpid())
    for _ in range(3000):
        children = subprocess.run(["pgrep", "-P", me, "-x", "phalanx"], capture_output=True, text=True).stdout.split()
        if children and list(folder.glob("runs/triangle-*.mcap")):
            break
        time.sleep(0.01)
    time.sleep(0.5)
    os.kill(int(children[0]), signal.SIGTERM)
    run.join()
    (log,) = found
    assert (log.ok, log.ending) == (False, "interrupted")
    assert "interrupted" in log.faults[-1].text


def test_a_damaged_log_gives_what_can_be_read(folder: Path) -> None:
    whole = phalanx.run("triangle", out="whole.mcap", options=["--no-scene"])
    data = bytearray(Path("whole.mcap").read_bytes())
    middle = len(data) // 2
    data[middle : middle + 64] = bytes(64)
    Path("damaged.mcap").write_bytes(data)
    log = phalanx.open("damaged.mcap")
    assert not log.complete and len(log.t) < len(whole.t)
    assert not log.ok and log.faults and isinstance(log.metrics, dict) and isinstance(log.assertions, dict)


def test_fields_of_some_variants_only() -> None:
    changes = {"controller.limit_estimate": False, "controller.k": 4}
    runs = {
        name: phalanx.run("cida", name, duration=0.1, set_if_present=changes, out=f"{name}.mcap")
        for name in ("OBFC", "RCTFC")
    }
    found = {name: log.scenario["controller"] for name, log in runs.items()}
    assert (found["OBFC"]["k"], found["RCTFC"]["k"]) == (4, 4)
    assert "limit_estimate" not in found["OBFC"] and found["RCTFC"]["limit_estimate"] is False
    with pytest.raises(phalanx.ScenarioError):
        phalanx.run("cida", set_if_present={"controller.limit_estimat": False})


def test_what_is_not_run_raises() -> None:
    for arguments in ({"variant": "X"}, {"duration": -1}, {"swap": {"controller.1": "./nothing"}}, {"controller__k_q": 1}):
        with pytest.raises(phalanx.ScenarioError):
            phalanx.run("triangle", **arguments)


def test_scenarios_that_swap_run(folder: Path) -> None:
    repository = Path(__file__).resolve().parents[2]
    text = (repository / "scenarios/triangle.toml").read_text()
    (folder / "sub").mkdir()
    page = (repository / "python/README.md").read_text()
    (folder / "sub/mine.py").write_text(page.split("```python\n")[1].split("```")[0])
    (folder / "sub/mine.toml").write_text(f"{text}\n[swap]\n\"controller.2\" = \"'{sys.executable}' mine.py\"\n")
    assert phalanx.run("sub/mine.toml").ok


def test_the_sweep_of_the_documentation_prints_what_it_says(capsys: pytest.CaptureFixture[str]) -> None:
    page = (Path(__file__).resolve().parents[2] / "docs/coming-from.md").read_text()
    programs = [block.split("```")[0] for block in page.split("```python\n")[1:]]
    (program,) = [program for program in programs if "phalanx.run" in program]
    exec(compile(program, "coming-from.md", "exec"), {})
    errors = [f"{float(line.split()[1]):.3f}" for line in capsys.readouterr().out.splitlines()]
    assert "prints {}, {}, {} and {}:".format(*errors) in page


def fly(number: int) -> tuple[bool, float]:
    log = phalanx.run("triangle", duration=12, k_x=2 + number / 10, out=f"runs/{number}.mcap")
    return log.ok, float(log["agent_1/state"].position[-1, 0])


@pytest.mark.parametrize("pool", [ThreadPoolExecutor, ProcessPoolExecutor])
def test_runs_side_by_side(pool) -> None:
    with pool(8) as executor:
        found = list(executor.map(fly, range(32)))
    assert all(ok for ok, _ in found)
    assert len({position for _, position in found}) == 32
    shutil.rmtree("runs")


def results(number: int) -> phalanx.Log:
    return phalanx.run("triangle", duration=12, out=f"runs/{number}.mcap")


def test_results_pass_between_processes() -> None:
    with ProcessPoolExecutor(2) as executor:
        logs = list(executor.map(results, range(2)))
    assert all(log.ok and log["agent_1/state"].position.shape == (1201, 3) for log in logs)

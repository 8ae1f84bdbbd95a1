"""Logs as arrays, held against the golden values of the drones."""

import math
import shutil

import numpy as np
import phalanx
import pytest


@pytest.fixture(scope="module")
def log(tmp_path_factory):
    return phalanx.run("uav", duration=1, out=tmp_path_factory.mktemp("run") / "uav.mcap")


def test_signals_are_arrays_by_name(log):
    state = log["agent_1/state"]
    assert state.position.shape == (101, 6)
    assert state.t[0] == 0 and state.t[100] == 1
    np.testing.assert_allclose(state.position[100, :3], [3.96730214, 1.03446941, 0.191294759], atol=1e-7)
    np.testing.assert_allclose(log["/agent_1/command"].input[0, :3], [20.8208, 1.03310569, -1.02504533], atol=1e-7)
    assert log["agent_1/estimate"].weight_norm.shape == (101,)
    np.testing.assert_array_equal(state["position[2]"], state.position[:, 2])
    assert state.units["position"].startswith("m")
    assert list(state.step[:3]) == [0, 1, 2] and not state.status.any()
    assert not state.position.flags.writeable


def test_messages_for_viewers_are_no_signals(log):
    assert len(log) == 24 and log.agents == [1, 2, 3, 4, 5, 6]
    assert log.stack("state", "position").shape == (6, 101, 6)


def test_patterns_find_fields_and_components(log):
    assert list(log.signals("agent_[12]/state/position")) == ["agent_1/state/position", "agent_2/state/position"]
    assert list(log.signals("agent_3/command/input[3]")) == ["agent_3/command/input[3]"]
    with pytest.raises(KeyError, match="TOPIC/FIELD"):
        log.signals("agent_1/state/speed")


def test_what_is_not_there_is_named(log):
    with pytest.raises(KeyError, match="agent_9/state"):
        log["agent_9/state"]
    with pytest.raises(KeyError, match="position, velocity, disturbance"):
        log["agent_1/state"]["speed"]
    with pytest.raises(AttributeError, match="speed"):
        log["agent_1/state"].speed  # noqa: B018
    with pytest.raises(KeyError):
        log["agent_1/state"]["position[6]"]


def test_data_frames(log):
    frame = log["agent_2/state"].to_pandas()
    assert frame.shape == (101, 18) and frame.index.name == "t"
    np.testing.assert_array_equal(frame["velocity[1]"], log["agent_2/state"].velocity[:, 1])
    assert "agent_1/state/position[0]" in log.to_pandas(["agent_1/*"]).columns


def test_scenario_and_metrics(log):
    assert log.scenario["timing"] == {"dt": 0.01, "duration": 1}
    assert (log.name, log.complete) == ("uav-TSC", True)
    # One second is too short for what must come out of eighty: the ranges are missed, and not held against this run.
    assert any(metric.in_range is False for metric in log.metrics.values())
    assert log.ok and math.isfinite(log.metrics["peak_u_bar"].value)
    again = phalanx.open(log.path).metrics
    assert again["peak_u_bar"] == log.metrics["peak_u_bar"]
    assert float(again["peak_u_bar"]) <= 0.2
    assert phalanx.compare({"a": log}).loc["peak_u_bar", "a"] == again["peak_u_bar"].value


def test_a_cut_log_gives_what_reached_it(log, tmp_path):
    cut = tmp_path / "cut.mcap"
    longer = phalanx.run("uav", duration=3, out=tmp_path / "long.mcap", options=["--no-scene"])
    cut.write_bytes(longer.path.read_bytes()[: longer.path.stat().st_size // 2])
    part = phalanx.open(cut)
    assert not part.complete and 0 < len(part.t) < len(longer.t)
    np.testing.assert_array_equal(part["agent_6/state"].position, longer["agent_6/state"].position[: len(part.t)])


def test_other_files_are_refused(tmp_path):
    (tmp_path / "text").write_text("no log")
    with pytest.raises(ValueError, match="not an MCAP file"):
        phalanx.open(tmp_path / "text")
    with pytest.raises(FileNotFoundError):
        phalanx.open(tmp_path / "nothing")


def test_plots_draw(log, tmp_path):
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    assert len(phalanx.plot.paths(log).get_lines()) == 18
    plt.close("all")
    # From above, where there are two dimensions only.
    assert len(phalanx.plot.paths(log, plt.gca()).get_lines()) == 18
    plt.figure()
    assert len(phalanx.plot.errors(log).get_lines()) == 6
    plt.figure()
    assert len(phalanx.plot.signal(log, "agent_1/command/input").get_lines()) == 4
    plt.figure()
    axes = phalanx.plot.signal(log, "agent_*/state/position[2]")
    assert len(axes.get_lines()) == 6
    plt.figure()
    assert len(phalanx.plot.signal(log, "agent_*/state/velocity", norm=True).get_lines()) == 6
    plt.savefig(tmp_path / "plot.svg")


@pytest.mark.skipif(shutil.which("sh") is None, reason="needs a shell")
def test_errors_of_the_program_are_exceptions(tmp_path, monkeypatch):
    with pytest.raises(phalanx.ScenarioError, match="did you mean `TOC`") as caught:
        phalanx.run("uav", variant="TOX")
    assert caught.value.code == 2
    with pytest.raises(phalanx.ScenarioError, match="unknown field"):
        phalanx.run("uav", controller__c_x=3)
    dead = phalanx.run("uav", duration=1, out=tmp_path / "dead.mcap", swap={"controller.3": "false"})
    assert not dead.ok and dead.ending == "failed" and not dead.log and dead.metrics == {}
    assert "controller_3" in dead.faults[-1].text
    monkeypatch.setenv("PHALANX", "no-such-program")
    with pytest.raises(phalanx.ProgramError, match="no-such-program"):
        phalanx.run("uav")


def test_overrides_reach_the_scenario(tmp_path):
    out = tmp_path / "a.mcap"
    log = phalanx.run("uav", "TOC", duration=0.1, out=out, phase=0.5, set={"agents.2.position": np.array([1, 2, 0])})
    assert log.metadata["variant"] == "TOC" and log.path == out
    assert log.scenario["parameters"]["phase"] == 0.5
    np.testing.assert_array_equal(log["agent_2/state"].position[0, :3], [1, 2, 0])

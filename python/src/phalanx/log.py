"""Logs of runs as NumPy arrays.

>>> log = phalanx.open("runs/uav-TSC.mcap")
>>> log["agent_3/state"].position[:, 2]        # height of the third drone over time, m
>>> log["agent_3/state"].t                     # simulated time, s
>>> log.metrics["x_til"].value
"""

from __future__ import annotations

import functools
import os
import re
import sys
from collections.abc import Iterator, Mapping, Sequence
from fnmatch import fnmatchcase
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from ._chunks import Content, Raw, read
from .metrics import Assertion, Fault, Judgement, Metric

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

if TYPE_CHECKING:
    import pandas

__all__ = ["Log", "Topic", "open"]

#: Opening brackets and what is between them: ``[2]`` in ``position[2]``.
_COMPONENT = re.compile(r"\[(\d+)\]$")


class Topic:
    """The samples of one topic: an array for every field, a row for every step.

    Fields are attributes and items: ``topic.position`` and ``topic["position"]`` are the same array, of shape ``(steps,)`` for a
    number and ``(steps, n)`` for a vector of ``n``. Arrays are views into one block of memory, and read-only.
    """

    name: str
    """Its name, without the slash in front."""
    fields: tuple[str, ...]
    """Names of its fields, in the order of the log."""
    units: dict[str, str]
    """The unit of every field as the log says it, ``"m, m, rad"``; empty for pure numbers."""
    t: npt.NDArray[np.float64]
    """Simulated time of every row, s."""
    step: npt.NDArray[np.uint64]
    """The step that computed each row: that of an earlier row where a slow participant's last sample stands."""
    status: npt.NDArray[np.uint32]
    """0: computed in its step; 1: held from an earlier one; others: see ``lockstep::Status``."""

    def __init__(self, raw: Raw) -> None:
        self.name = raw.topic.lstrip("/")
        self.fields = tuple(field.name for field in raw.fields)
        self.units = {field.name: field.unit for field in raw.fields}
        self.t, self.step, self.status = raw.times / 1e9, raw.samples["step"], raw.samples["status"]
        words, offset = raw.samples["words"], 0
        self._arrays: dict[str, npt.NDArray[np.float64]] = {}
        for field in raw.fields:
            columns = words[:, offset : offset + field.width]
            self._arrays[field.name] = columns[:, 0] if field.scalar else columns
            offset += field.width

    def __getitem__(self, field: str) -> npt.NDArray[np.float64]:
        """A field, or a component of one: ``topic["position[2]"]``."""
        if field in self._arrays:
            return self._arrays[field]
        component = _COMPONENT.search(field)
        if component and field[: component.start()] in self._arrays:
            array, index = self._arrays[field[: component.start()]], int(component[1])
            if array.ndim == 2 and index < array.shape[1]:
                return array[:, index]
        raise KeyError(f"{self.name} has no field {field}; it has {', '.join(self.fields)}")

    def __getattr__(self, field: str) -> npt.NDArray[np.float64]:
        try:
            return self.__dict__["_arrays"][field]
        except KeyError:
            raise AttributeError(f"no field {field}; there are {', '.join(self.__dict__.get('fields', ()))}") from None

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *self.fields]

    def __len__(self) -> int:
        return len(self.t)

    def __repr__(self) -> str:
        shapes = (f"{name}{list(self._arrays[name].shape[1:]) or ''}" for name in self.fields)
        return f"<{self.name}: {len(self)} samples of {', '.join(shapes)}>"

    def columns(self) -> dict[str, npt.NDArray[np.float64]]:
        """All numbers by name, a vector as ``position[0]``, ``position[1]``, ..."""
        columns: dict[str, npt.NDArray[np.float64]] = {}
        for name, array in self._arrays.items():
            if array.ndim == 1:
                columns[name] = array
            else:
                columns.update({f"{name}[{index}]": array[:, index] for index in range(array.shape[1])})
        return columns

    def to_pandas(self) -> pandas.DataFrame:
        """A data frame with a column per number, over the time in s."""
        import pandas

        return pandas.DataFrame(self.columns(), index=pandas.Index(self.t, name="t"))


class Log(Mapping[str, Topic]):
    """A recorded run, in memory: topics by name, with or without the slash in front."""

    path: Path
    """The file."""
    complete: bool
    """Whether the file was closed and is whole; if not, the run was killed, or the file is damaged."""
    ending: str
    """How the run ended, if `phalanx.run` carried it out: "complete", "violated", "failed" or "interrupted"; else ""."""
    metadata: dict[str, str]
    """What the recorder was told: scenario, variant, overrides, versions."""
    players: list[dict[str, str]]
    """What played in the place of Phalanx, as the log has it: ``participant``, ``kind``, ``command``, ``from_step``, and ``file.1``,
    ``sha256.1``, ... of its files; empty if Phalanx played alone."""
    scenario: dict[str, Any]
    """The scenario that was run, with variant and overrides applied: ``log.scenario["timing"]["dt"]``."""

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self.path = Path(path)
        content = read(self.path)
        self._take(content)

    def _take(self, content: Content) -> None:
        self.complete, self.metadata, self.ending = content.complete, content.metadata, ""
        self.players = content.players
        try:
            self.scenario = tomllib.loads(content.scenario)
        except tomllib.TOMLDecodeError:
            self.scenario = {}
        self._topics = {raw.topic.lstrip("/"): Topic(raw) for raw in content.channels}
        self._faults = [Fault(event.text, event.participant, event.step, event.time) for event in content.events]
        if content.damage:
            self._faults.append(Fault(content.damage))

    @classmethod
    def nothing(cls, path: str | os.PathLike[str]) -> Log:
        """The log of a run that recorded nothing: no topics."""
        log = cls.__new__(cls)
        log.path = Path(path)
        log._take(Content())
        return log

    def __fspath__(self) -> str:
        return os.fspath(self.path)

    @property
    def log(self) -> Log:
        """This log; without topics if nothing was recorded."""
        return self

    def __getitem__(self, name: str) -> Topic:
        try:
            return self._topics[name.lstrip("/")]
        except KeyError:
            raise KeyError(f"no topic {name} in {self.path}; it has {', '.join(self._topics)}") from None

    def __iter__(self) -> Iterator[str]:
        return iter(self._topics)

    def __len__(self) -> int:
        return len(self._topics)

    def __repr__(self) -> str:
        name = " ".join(filter(None, (self.metadata.get("scenario"), self.metadata.get("variant"))))
        return f"<Log {self.path}: {name}, {len(self)} topics, {len(self.t)} steps>"

    @property
    def name(self) -> str:
        """Scenario and variant, ``uav-TSC``."""
        return "-".join(filter(None, (self.metadata.get("scenario"), self.metadata.get("variant"))))

    @property
    def t(self) -> npt.NDArray[np.float64]:
        """Simulated time of every step, s."""
        return next(iter(self.values())).t if self._topics else np.empty(0)

    @property
    def agents(self) -> list[int]:
        """Numbers of the agents."""
        numbers = (re.match(r"agent_(\d+)/", name) for name in self)
        return sorted({int(number[1]) for number in numbers if number})

    def signals(self, pattern: str) -> dict[str, npt.NDArray[np.float64]]:
        """The fields that a pattern names: ``log.signals("agent_*/command/input[0]")``; ``*`` stands for anything.

        Raises `KeyError` if there is none.
        """
        topic, _, field = pattern.lstrip("/").rpartition("/")
        found: dict[str, npt.NDArray[np.float64]] = {}
        for name in (name for name in self if fnmatchcase(name, topic)):
            columns = {known: self[name][known] for known in self[name].fields} | self[name].columns()
            # Brackets mean components here, and not sets of letters.
            wanted = field.replace("[", "[[]")
            found.update({f"{name}/{known}": array for known, array in columns.items() if fnmatchcase(known, wanted)})
        if not found:
            raise KeyError(f"no signal of {self.path} is called {pattern}; signals are TOPIC/FIELD or TOPIC/FIELD[K]")
        return found

    def stack(self, role: str, field: str) -> npt.NDArray[np.float64]:
        """A field of all agents in one array: ``log.stack("state", "position")`` has the shape ``(agents, steps, n)``."""
        return np.stack([self[f"agent_{agent}/{role}"][field] for agent in self.agents])

    def to_pandas(self, topics: Sequence[str] = ("*",)) -> pandas.DataFrame:
        """All numbers of the topics that match, ``agent_1/state/position[0]``, over the time in s."""
        import pandas

        chosen = (topic for topic in self if any(fnmatchcase(topic, name.lstrip("/")) for name in topics))
        columns = {f"{name}/{column}": array for name in chosen for column, array in self[name].columns().items()}
        return pandas.DataFrame(columns, index=pandas.Index(self.t, name="t"))

    @functools.cached_property
    def judgement(self) -> Judgement:
        """What `phalanx check` finds; of a log that cannot be judged, nothing, and the reason among `faults`.

        Raises `phalanx.ProgramError` if the program is not found.
        """
        from .running import judge

        return judge(self)

    @property
    def metrics(self) -> dict[str, Metric]:
        """All metrics of the run, against their regression ranges and the thesis; empty if they cannot be computed."""
        return self.judgement.metrics

    @property
    def assertions(self) -> dict[str, Assertion]:
        """What became of the assertions of the scenario, by name."""
        return self.judgement.assertions

    @property
    def faults(self) -> list[Fault]:
        """What happened to participants, why the run ended early, and what is wrong with the log; empty if all went well."""
        return [*self._faults, *self.judgement.faults]

    @property
    def ok(self) -> bool:
        """Whether the run came to its end, with every metric in its regression range and no assertion violated."""
        return self.judgement.ok


def open(path: str | os.PathLike[str]) -> Log:
    """Reads a log that ``phalanx run`` recorded; of a run that was killed, or a damaged file, all that can be read.

    What the run found is in the log, whatever it was: `Log.ok`, `Log.assertions`, `Log.metrics`, `Log.faults`. Raises `FileNotFoundError`, or `ValueError` if it is no such log.
    """
    return Log(path)

"""Runs from Python: the program ``phalanx`` does the work, what it says comes back as values and exceptions."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from .log import Log
from .metrics import from_json

__all__ = ["LogError", "ProgramError", "RunError", "ScenarioError", "find_program", "run"]

#: Environment variable that names the program.
PROGRAM = "PHALANX"


class ProgramError(RuntimeError):
    """The program did not do what it was asked for; the text is what it said."""

    code: int | None
    """Its exit code, see ``phalanx --help``; ``None`` if it did not even start."""
    log: Path | None
    """The log of a run that started, readable up to where it stopped."""

    def __init__(self, message: str, code: int | None = None, log: Path | None = None) -> None:
        super().__init__(message)
        self.code, self.log = code, log


class ScenarioError(ProgramError):
    """The scenario, or what was changed about it, is not valid; nothing was started."""


class RunError(ProgramError):
    """The run stopped early: a participant failed, hung or died."""


class LogError(ProgramError):
    """A log cannot be written or read, or lacks what was asked for."""


_ERRORS: dict[int, type[ProgramError]] = {2: ScenarioError, 3: RunError, 4: LogError}
#: Exit code of a run that was interrupted.
_INTERRUPTED = 130


def find_program() -> Path:
    """The program: ``$PHALANX``, else ``phalanx`` on the path, else ``target/release/phalanx`` here or in a folder above.

    Raises `ProgramError` if there is none.
    """
    if named := os.environ.get(PROGRAM):
        if found := shutil.which(named):
            return Path(found)
        raise ProgramError(f"${PROGRAM} names {named}, which is no program")
    if found := shutil.which("phalanx"):
        return Path(found)
    here = Path.cwd()
    sources = Path(__file__).resolve().parent
    for folder in [here, *here.parents, *sources.parents]:
        program = folder / "target" / "release" / "phalanx"
        if program.is_file():
            return program
    raise ProgramError(
        f"the program phalanx was not found: build it with `cargo build --release`, and put it on the path or name it in ${PROGRAM}"
    )


def call(*arguments: str, accept: Iterable[int] = (0,)) -> str:
    """Calls the program and returns what it printed.

    Raises `ProgramError`, or the class that belongs to its exit code, with its message.
    """
    done = _start(arguments)
    if done.returncode in accept:
        return done.stdout
    raise _failure(done, arguments[0])


def _start(arguments: Iterable[str]) -> subprocess.CompletedProcess[str]:
    program = find_program()
    return subprocess.run([program, *arguments], capture_output=True, text=True, stdin=subprocess.DEVNULL, check=False)


def _failure(done: subprocess.CompletedProcess[str], command: str) -> BaseException:
    if done.returncode == _INTERRUPTED:
        return KeyboardInterrupt()
    # Warnings may stand in front of it.
    _, _, message = done.stderr.rpartition("error: ")
    message = message.strip() or f"phalanx {command} ended with {done.returncode} and said nothing"
    return _ERRORS.get(done.returncode, ProgramError)(message, done.returncode)


def run(
    scenario: str | os.PathLike[str],
    variant: str | None = None,
    *,
    duration: float | None = None,
    dt: float | None = None,
    seed: int | None = None,
    out: str | os.PathLike[str] | None = None,
    placement: str = "single",
    swap: Mapping[str, str] | None = None,
    set: Mapping[str, Any] | None = None,
    options: Iterable[str] = (),
    **overrides: Any,
) -> Log:
    """Runs a scenario and returns its log, metrics included.

    >>> log = phalanx.run("uav", variant="TOC", duration=20, phase=0.5, controller__c_p=3)
    >>> log = phalanx.run("uav", set={"agents.2.position": [1, 2, 0]}, swap={"controller.3": "python3 mine.py"})

    ``overrides`` change fields of the scenario; ``__`` stands for the dot that a Python name cannot have, and ``set`` takes the
    names as they are. ``out`` is the log, by default ``runs/<scenario>-<variant>.mcap``, which replaces that of an earlier run.
    All participants run in one process unless ``placement`` says otherwise (``"processes"``, the default with ``swap``): the
    result is the same, bit by bit. ``options`` are further options of ``phalanx run``.

    Metrics outside their bands are no error, see `Log.ok`. Raises `ScenarioError`, `RunError` (the log is in its ``log``),
    `LogError` or `ProgramError` with the message of the program.
    """
    if swap and placement == "single":
        placement = "processes"
    arguments = ["run", os.fspath(scenario), "--json", "--quiet", "--placement", placement]
    given = {"--variant": variant, "--duration": duration, "--dt": dt, "--seed": seed, "--out": out}
    for name, value in given.items():
        if value is not None:
            arguments += [name, os.fspath(value) if isinstance(value, os.PathLike) else str(value)]
    changes = {name.replace("__", "."): value for name, value in overrides.items()} | dict(set or {})
    for name, value in changes.items():
        arguments += ["--set", f"{name}={toml(value)}"]
    for node, command in (swap or {}).items():
        arguments += ["--swap", f"{node}={command}"]
    done = _start([*arguments, *options])
    lines = done.stdout.splitlines()
    summary = json.loads(lines[-1]) if lines else {}
    if done.returncode not in (0, 1):
        error = _failure(done, "run")
        if isinstance(error, ProgramError) and summary.get("log"):
            error.log = Path(summary["log"])
        raise error
    log = Log(summary["log"])
    log.metrics = from_json(summary["metrics"] or {})
    return log


def toml(value: Any) -> str:
    """A value as TOML writes it."""
    if hasattr(value, "tolist"):
        # NumPy's numbers and arrays.
        value = value.tolist()
    match value:
        case bool():
            return str(value).lower()
        case int() | float():
            return repr(value)
        case str():
            return json.dumps(value, ensure_ascii=False)
        case Mapping():
            return "{ " + ", ".join(f"{name} = {toml(entry)}" for name, entry in value.items()) + " }"
        case Iterable():
            return "[" + ", ".join(map(toml, value)) + "]"
    raise TypeError(f"a scenario cannot hold {value!r}; give a number, a text, a list or a mapping")

"""Runs from Python: the program ``phalanx`` does the work, what it says comes back as values and exceptions."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
from collections.abc import Iterable, Mapping
from functools import cache
from importlib import metadata
from pathlib import Path
from typing import Any

from .log import Log
from .metrics import Fault, Judgement

__all__ = ["LogError", "ProgramError", "ScenarioError", "find_program", "judge", "run"]

#: Environment variable that names the program.
PROGRAM = "PHALANX"


class ProgramError(RuntimeError):
    """The program did not do what it was asked for; the text is what it said."""

    code: int | None
    """Its exit code, see ``phalanx --help``; ``None`` if it did not even start."""

    def __init__(self, message: str, code: int | None = None) -> None:
        super().__init__(message)
        self.code = code


class ScenarioError(ProgramError):
    """The scenario, or what was changed about it, is not valid; nothing was started."""


class LogError(ProgramError):
    """A log cannot be written or read, or lacks what was asked for."""


_ERRORS: dict[int, type[ProgramError]] = {2: ScenarioError, 4: LogError}
#: How a run ended, by exit code. Other codes: it was not carried out.
_ENDINGS = {0: "complete", 1: "complete", 3: "failed", 6: "violated", 130: "interrupted"}


def find_program() -> Path:
    """The program: ``$PHALANX``, else the one that was installed with this package, else ``phalanx`` on the path, else
    ``target/release/phalanx`` here or in a folder above.

    Raises `ProgramError` if there is none.
    """
    if named := os.environ.get(PROGRAM):
        if found := shutil.which(named):
            return Path(found)
        raise ProgramError(f"${PROGRAM} names {named}, which is no program")
    if installed := _installed_program():
        return installed
    if found := shutil.which("phalanx"):
        return Path(found)
    here = Path.cwd()
    sources = Path(__file__).resolve().parent
    for folder in [here, *here.parents, *sources.parents]:
        program = folder / "target" / "release" / "phalanx"
        if program.is_file():
            return program
    raise ProgramError(
        "the program phalanx was not found: install the wheel, which has it, or build it with `cargo build --release`, and put it "
        f"on the path or name it in ${PROGRAM}"
    )


@cache
def _installed_program() -> Path | None:
    """The program among the files of this package, wherever the installer has put scripts."""
    try:
        distribution = metadata.distribution("phalanx")
    except metadata.PackageNotFoundError:
        return None
    # Completions and the folder of the package have this name, too.
    files = [Path(str(distribution.locate_file(file))) for file in distribution.files or [] if file.name == "phalanx"]
    return next((file.resolve() for file in files if file.is_file() and os.access(file, os.X_OK)), None)


def judge(log: Log) -> Judgement:
    """What ``phalanx check`` finds in a log. A log that it cannot judge has that as its fault.

    Raises `ProgramError` if the program is not found.
    """
    if not log:
        return Judgement(faults=[] if log.ending else [Fault(f"{log.path} holds no samples")])
    done = _start(["check", os.fspath(log), "--json"])
    summary = _summary(done)
    if summary is None:
        return Judgement(faults=[Fault(_message(done, "check"))])
    return Judgement.of(summary)


def _start(arguments: Iterable[str]) -> subprocess.CompletedProcess[str]:
    program = find_program()
    command = [os.fspath(program), *arguments]
    with subprocess.Popen(
        command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, encoding="utf-8", errors="replace"
    ) as process:
        try:
            stdout, stderr = process.communicate()
        except KeyboardInterrupt:
            # The terminal has interrupted the program too; it closes its log first.
            process.wait()
            raise
    return subprocess.CompletedProcess(command, process.returncode, stdout, stderr)


def _summary(done: subprocess.CompletedProcess[str]) -> dict[str, Any] | None:
    """The last line that it printed, if that is JSON."""
    lines = done.stdout.splitlines()
    try:
        return dict(json.loads(lines[-1])) if lines else None
    except ValueError:
        return None


def _message(done: subprocess.CompletedProcess[str], command: str) -> str:
    # Warnings may stand in front of it.
    _, _, message = done.stderr.rpartition("error: ")
    return message.strip() or f"phalanx {command} ended with {done.returncode} and printed no reason"


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
    set_if_present: Mapping[str, Any] | None = None,
    options: Iterable[str] = (),
    **overrides: Any,
) -> Log:
    """Runs a scenario and returns its log, with all that the run found, whatever it was.

    >>> log = phalanx.run("uav", variant="TOC", duration=20, phase=0.5, controller__c_p=3)
    >>> log = phalanx.run("uav", set={"agents.2.position": [1, 2, 0]}, swap={"controller.3": "python3 mine.py"})

    ``overrides`` change fields of the scenario; ``__`` stands for the dot that a Python name cannot have, and ``set`` takes the
    names as they are. ``set_if_present`` changes fields that only some variants have; in the others it does nothing. ``out`` is the log, by default ``runs/<scenario>-<variant>.mcap``, which replaces that of an earlier run.
    All participants run in one process unless ``placement`` says otherwise, and each that is swapped, here or in the scenario, in a
    process beside it: the result is the same, bit by bit. ``options`` are further options of ``phalanx run``.

    A run that misses a regression range, violates an assertion, is halted, loses a participant or is interrupted is a result: see `Log.ok`,
    `Log.ending`, `Log.metrics`, `Log.assertions` and `Log.faults`. Raises only if nothing was run: `ScenarioError` if an argument or
    the scenario is not valid, `LogError` if the log cannot be written, `ProgramError` otherwise, with the message of the program.
    """
    arguments = ["run", os.fspath(scenario), "--json", "--quiet", "--placement", placement]
    given = {"--variant": variant, "--duration": duration, "--dt": dt, "--seed": seed, "--out": out}
    for name, value in given.items():
        if value is not None:
            arguments += [name, os.fspath(value) if isinstance(value, os.PathLike) else str(value)]
    changes = {name.replace("__", "."): value for name, value in overrides.items()} | dict(set or {})
    for name, value in changes.items():
        arguments += ["--set", f"{name}={toml(value)}"]
    for name, value in (set_if_present or {}).items():
        arguments += ["--set-if-present", f"{name}={toml(value)}"]
    for node, command in (swap or {}).items():
        arguments += ["--swap", f"{node}={command}"]
    done = _start([*arguments, *options])
    ending, summary = _ENDINGS.get(done.returncode), _summary(done)
    if ending is None and summary is None:
        raise _ERRORS.get(done.returncode, ProgramError)(_message(done, "run"), done.returncode)
    return _result(done, ending or "failed", summary or {})


def _result(done: subprocess.CompletedProcess[str], ending: str, summary: Mapping[str, Any]) -> Log:
    """The log of a run that was started, with what was found."""
    path = summary.get("log") or ""
    try:
        log = Log(path) if path else Log.nothing("")
    except (OSError, ValueError):
        # It ended before its first step.
        log = Log.nothing(path)
    log.ending = ending
    log.judgement = Judgement.of(summary) if summary else Judgement()
    if ending in ("failed", "interrupted"):
        log.judgement.ok = False
        log.judgement.faults.append(Fault(_message(done, "run")))
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

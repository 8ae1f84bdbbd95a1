"""The program `phalanx`, for tests that need a run: $PHALANX, else that of this repository."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import pytest

REPOSITORY = Path(__file__).resolve().parents[2]


@dataclass
class Finished:
    """What a finished program left."""

    code: int
    stdout: str
    stderr: str

    @property
    def has_flown(self) -> bool:
        """Whether the run came to its end; the regression ranges, which are for a whole flight, need not be met (1)."""
        return self.code in (0, 1)

    @property
    def json(self) -> dict:
        """The last line of stdout."""
        assert self.has_flown, self.stderr
        return json.loads(self.stdout.splitlines()[-1])


@pytest.fixture
def phalanx_program() -> Path:
    """Path of the program; without it the test is skipped."""
    program = Path(os.environ.get("PHALANX") or REPOSITORY / "target/release/phalanx")
    if not program.is_file():
        pytest.skip(f"no program {program}: `cargo build --release` builds it, or PHALANX names another one")
    return program


@pytest.fixture
def run(phalanx_program: Path, tmp_path: Path) -> Callable[..., Finished]:
    """Runs the program with these arguments in an empty folder."""

    def run(*arguments: str) -> Finished:
        done = subprocess.run([phalanx_program, *arguments], cwd=tmp_path, capture_output=True, text=True, timeout=300)
        return Finished(done.returncode, done.stdout, done.stderr)

    return run


@pytest.fixture
def swapped(run: Callable[..., Finished], tmp_path: Path) -> Callable[..., Finished]:
    """A short flight of the drones in which the given Python source plays controller 3."""

    def swapped(source: str, *arguments: str, node: str = "controller.3") -> Finished:
        script = tmp_path / "mine.py"
        script.write_text(source)
        command = f"{node}='{sys.executable}' '{script}'"
        return run("run", "uav", "--duration", "0.5", "-q", "--out", "mine.mcap", "--swap", command, *arguments)

    return swapped

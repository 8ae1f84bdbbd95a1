"""Builds the shared library of the participants with Cargo and puts it beside the package.

The library is one of the crates of the repository (`capi`), so it can be built only from there. Where there is no Cargo, or no
repository around this folder, the package is installed without it: logs can be read all the same, and who wants to take part in
a run is told how to name a library (see `phalanx/_library.py`).
"""

import shutil
import subprocess
import sys
from pathlib import Path

from setuptools import Distribution, setup
from setuptools.command.bdist_wheel import bdist_wheel
from setuptools.command.build_py import build_py

REPOSITORY = Path(__file__).resolve().parent.parent
LIBRARY = "libphalanx.so"


class BuildWithLibrary(build_py):
    """Copies the modules, then builds the library and copies it too."""

    def run(self) -> None:
        super().run()
        # An installation that points back here (`pip install -e`) finds the library in the folder `target`.
        if self.editable_mode:
            return
        if not (REPOSITORY / "capi" / "Cargo.toml").is_file():
            self.warn(f"no crate capi in {REPOSITORY}: installed without {LIBRARY}")
        elif shutil.which("cargo") is None:
            self.warn(f"no cargo in PATH: installed without {LIBRARY}")
        else:
            shutil.copy2(built_library(), Path(self.build_lib) / "phalanx" / LIBRARY)


def built_library() -> Path:
    """Runs Cargo and returns the path of the library, which Cargo itself tells."""
    # JSON of every artifact goes to stdout, progress and errors to stderr.
    command = ["cargo", "rustc", "--release", "--package", "capi", "--lib", "--message-format=json-render-diagnostics"]
    command += ["--crate-type", "cdylib"]
    finished = subprocess.run(command, cwd=REPOSITORY, stdout=subprocess.PIPE, text=True)
    if finished.returncode != 0:
        sys.exit(f"cargo could not build {LIBRARY}; try `cargo build --release --package capi` in {REPOSITORY}")
    import json

    artifacts = (json.loads(line) for line in finished.stdout.splitlines() if line.startswith("{"))
    files = [Path(file) for artifact in artifacts for file in artifact.get("filenames", [])]
    return next(file for file in reversed(files) if file.name == LIBRARY)


class PlatformWheel(bdist_wheel):
    """A wheel for any Python 3 of this platform: the library is no extension module."""

    def get_tag(self) -> tuple[str, str, str]:
        _, _, platform = super().get_tag()
        return "py3", "none", platform


class WithLibrary(Distribution):
    """Makes setuptools put the package where platform-dependent ones go."""

    def has_ext_modules(self) -> bool:
        return True


setup(cmdclass={"build_py": BuildWithLibrary, "bdist_wheel": PlatformWheel}, distclass=WithLibrary)

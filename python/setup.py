"""Builds the wheel: the package, the program, its library with the header, manual pages and completions.

Program and library are crates of the repository (`phalanx` and `capi`), so they can be built only from there. `PHALANX_BUILT`
names a folder that has both already, such as `target/release`; otherwise Cargo builds them. Where there is neither Cargo nor a
repository, the package is installed without them: logs can be read all the same, and a participant reports how to name a library
(see `phalanx/_library.py`).
"""

import atexit
import json
import os
import shutil
import subprocess
import sys
import tempfile
from functools import cache
from pathlib import Path

from setuptools import Distribution, setup
from setuptools.command.bdist_wheel import bdist_wheel
from setuptools.command.build_py import build_py
from setuptools.command.install_scripts import install_scripts

# Setuptools brings this one; it has to be imported first.
from distutils.command.install_data import install_data  # isort: skip

REPOSITORY = Path(__file__).resolve().parent.parent
PROGRAM, LIBRARY = "phalanx", "libphalanx.so"
#: Environment variable that names the folder of a finished build.
BUILT = "PHALANX_BUILT"
#: What programs in C and C++ are compiled with: folders of an installation, and of the package.
INTERFACE = {"include": "include", "lib/cmake/Phalanx": "cmake"}


@cache
def artefacts() -> dict[str, Path]:
    """The paths of program and library by name; empty if they cannot be built here."""
    if built := os.environ.get(BUILT):
        # After the tests of the whole workspace, the newest library is in `deps`.
        found = {name: newest([Path(built, name), Path(built, "deps", name)]) for name in (PROGRAM, LIBRARY)}
        if lacking := [name for name, path in found.items() if path is None]:
            sys.exit(f"{BUILT} names {built}, which has no {' and no '.join(lacking)}")
        return found
    if not (REPOSITORY / "capi" / "Cargo.toml").is_file():
        print(f"warning: no crate capi in {REPOSITORY}: installed without program and library", file=sys.stderr)
        return {}
    if shutil.which("cargo") is None:
        print("warning: no cargo in PATH: installed without program and library", file=sys.stderr)
        return {}
    # JSON of every artefact goes to stdout, progress and errors to stderr.
    command = "cargo build --release --locked --package phalanx --package capi --message-format=json-render-diagnostics"
    finished = subprocess.run(command.split(), cwd=REPOSITORY, stdout=subprocess.PIPE, text=True)
    if finished.returncode != 0:
        sys.exit(f"cargo could not build Phalanx; try `cargo build --release -p phalanx -p capi` in {REPOSITORY}")
    messages = (json.loads(line) for line in finished.stdout.splitlines() if line.startswith("{"))
    files = [Path(file) for message in messages for file in message.get("filenames", [])]
    return {name: next(file for file in reversed(files) if file.name == name) for name in (PROGRAM, LIBRARY)}


def newest(paths: list[Path]) -> Path | None:
    """The file that was written last, of those that exist."""
    return max((path for path in paths if path.is_file()), key=lambda path: path.stat().st_mtime, default=None)


@cache
def staged() -> Path | None:
    """A folder with all files of an installation, as every other artefact has them; none without a program."""
    found = artefacts()
    if not found:
        return None
    folder = Path(tempfile.mkdtemp(prefix="phalanx-stage-"))
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    subprocess.run([REPOSITORY / "release/stage", found[PROGRAM], found[LIBRARY], folder], check=True)
    return folder


class BuildWithLibrary(build_py):
    """Copies the modules, then the library and what programs in C and C++ are compiled with."""

    def run(self) -> None:
        super().run()
        # An installation that points back here (`pip install -e`) finds all of it in the repository.
        if self.editable_mode:
            return
        package = Path(self.build_lib) / "phalanx"
        # An earlier build in this folder may have left one, which would not fit.
        (package / LIBRARY).unlink(missing_ok=True)
        if stage := staged():
            shutil.copy2(artefacts()[LIBRARY], package / LIBRARY)
            for source, target in INTERFACE.items():
                shutil.copytree(stage / source, package / target, dirs_exist_ok=True)


class InstallProgram(install_scripts):
    """Puts the program among the scripts of the environment. It is not a text that Python could adapt."""

    def run(self) -> None:
        self.outfiles = []
        if stage := None if is_editable(self.distribution) else staged():
            target = Path(self.install_dir) / PROGRAM
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(stage / "bin" / PROGRAM, target)
            self.outfiles = [str(target)]


class InstallDocuments(install_data):
    """Manual pages, completions, licences, examples and scenarios, where an environment keeps them."""

    def run(self) -> None:
        self.outfiles = []
        if stage := None if is_editable(self.distribution) else staged():
            target = Path(self.install_dir) / "share"
            shutil.copytree(stage / "share", target, dirs_exist_ok=True)
            self.outfiles = [str(path) for path in target.rglob("*") if path.is_file()]


def is_editable(distribution: Distribution) -> bool:
    """Whether the installation points back to the repository, whose program it takes then."""
    return bool(distribution.get_command_obj("build_py").editable_mode)


class PlatformWheel(bdist_wheel):
    """A wheel for any Python 3 of this platform: the library is no extension module."""

    def get_tag(self) -> tuple[str, str, str]:
        _, _, platform = super().get_tag()
        return "py3", "none", platform


class WithProgram(Distribution):
    """Makes setuptools put the package where platform-dependent ones go, and install program and documents."""

    def has_ext_modules(self) -> bool:
        return True

    def has_scripts(self) -> bool:
        return True

    def has_data_files(self) -> bool:
        return True


setup(
    cmdclass={
        "bdist_wheel": PlatformWheel,
        "build_py": BuildWithLibrary,
        "install_data": InstallDocuments,
        "install_scripts": InstallProgram,
    },
    distclass=WithProgram,
    # Not absent, or a source distribution could not be made.
    data_files=[],
    scripts=[],
)

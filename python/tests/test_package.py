"""What is installed: one version everywhere, and every file in its place."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
import sys
from pathlib import Path

import phalanx
import pytest
from phalanx import running

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

REPOSITORY = Path(__file__).resolve().parents[2]

#: Does what `release/stage` asks a program for.
PROGRAM = """#!/bin/sh
case "$1" in
    --version) echo "phalanx 1.2.3" ;;
    man) echo page >"$2/phalanx.1"; echo page >"$2/phalanx-run.1" ;;
    completions) echo "$2" ;;
esac
"""


def manifest(name: str) -> dict:
    return tomllib.loads((REPOSITORY / name).read_text())


@pytest.fixture(scope="module")
def stage(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """An installation that `release/stage` has laid out."""
    if shutil.which("cargo") is None:
        pytest.skip("no cargo, which lists the crates of others")
    folder = tmp_path_factory.mktemp("stage")
    program, library = folder / "program", folder / "library"
    program.write_text(PROGRAM)
    program.chmod(0o755)
    library.write_text("library")
    subprocess.run([REPOSITORY / "release/stage", program, library, folder / "prefix"], check=True)
    return folder / "prefix"


def test_the_version_is_the_same_everywhere() -> None:
    version = manifest("Cargo.toml")["workspace"]["package"]["version"]
    assert manifest("python/pyproject.toml")["project"]["version"] == version
    assert phalanx.__version__ == version
    assert f"\nVersion: {version}\n" in (REPOSITORY / "capi/phalanx.pc").read_text()
    # The newest release of the changelog; its date has the form of a date.
    heading = re.search(r"^## (\d\S*) - \d{4}-\d\d-\d\d$", (REPOSITORY / "CHANGELOG.md").read_text(), re.MULTILINE)
    assert heading and heading[1] == version


@pytest.mark.parametrize("crate", ["phalanx", "capi"])
def test_what_is_installed_is_described(crate: str) -> None:
    package = manifest(f"{crate}/Cargo.toml")["package"]
    assert package["description"] and package["categories"] and 1 <= len(package["keywords"]) <= 5
    assert (REPOSITORY / crate / package["readme"]).is_file()


def test_the_library_has_the_names_that_programs_look_for(stage: Path) -> None:
    names = {path.name: path.readlink() if path.is_symlink() else None for path in (stage / "lib").glob("lib*")}
    assert names == {
        "libphalanx.so": Path("libphalanx.so.0"),
        "libphalanx.so.0": Path("libphalanx.so.1.2.3"),
        "libphalanx.so.1.2.3": None,
    }


def test_every_file_of_an_installation_is_in_the_debian_package(stage: Path) -> None:
    assets = manifest("phalanx/Cargo.toml")["package"]["metadata"]["deb"]["assets"]
    patterns = [source.removeprefix("../target/package/stage/") for source, _, _ in assets]
    packed = [set(stage.glob(pattern)) for pattern in patterns]
    assert all(packed), "a pattern that finds no file"
    files = {path for path in stage.rglob("*") if path.is_file()}
    assert files == {path for path in set().union(*packed) if path.is_file()}


def test_pkg_config_finds_the_installation_where_it_is(stage: Path) -> None:
    if shutil.which("pkg-config") is None:
        pytest.skip("no pkg-config")
    command = ["pkg-config", "--cflags", "--libs", "phalanx"]
    flags = subprocess.run(
        command, env={"PKG_CONFIG_PATH": str(stage / "lib/pkgconfig"), "PATH": "/usr/bin:/bin"}, capture_output=True, text=True, check=True
    )
    include, folder, library = flags.stdout.split()
    assert Path(include.removeprefix("-I"), "phalanx.h").is_file()
    assert Path(folder.removeprefix("-L"), "libphalanx.so").is_symlink() and library == "-lphalanx"


def test_licences_of_linked_crates_come_along(stage: Path) -> None:
    text = (stage / "share/doc/phalanx/THIRD-PARTY-LICENSES").read_text()
    # One that is linked, and its C sources; one that only tests use.
    assert "  zstd-sys " in text and "Zstandard" in text and "Apache License" in text
    assert "  proptest " not in text


def test_the_program_of_the_package_comes_before_others(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    other = tmp_path / "phalanx"
    other.write_text(PROGRAM)
    other.chmod(0o755)
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.delenv("PHALANX", raising=False)
    installed = running._installed_program()
    assert running.find_program() == (installed or other)
    monkeypatch.setattr(running, "_installed_program", lambda: None)
    assert running.find_program() == other
    monkeypatch.setenv("PHALANX", str(other))
    assert running.find_program() == other


def test_the_bill_of_materials_names_every_crate_with_its_checksum(tmp_path: Path) -> None:
    if shutil.which("cargo") is None or sys.version_info < (3, 11):
        pytest.skip("no cargo, or a Python without tomllib")
    subprocess.run([sys.executable, REPOSITORY / "release/bill.py", tmp_path / "bill.json"], check=True)
    text = (tmp_path / "bill.json").read_text()
    bill = json.loads(text)
    assert str(REPOSITORY) not in text and "file://" not in text
    assert bill["metadata"]["component"]["name"] == "phalanx"
    own = {path.parent.name for path in REPOSITORY.glob("*/Cargo.toml")}
    crates = {one["name"]: one for one in bill["components"]}
    assert {"capi", "iceoryx2", "orchestrator", "zstd-sys"} <= set(crates) and "proptest" not in crates
    assert [name for name, one in crates.items() if "hashes" not in one and name not in own] == []
    assert [name for name, one in crates.items() if "licenses" not in one] == []
    references = {one["bom-ref"] for one in [*bill["components"], bill["metadata"]["component"]]}
    assert references == {one["ref"] for one in bill["dependencies"]}
    assert references >= {other for one in bill["dependencies"] for other in one["dependsOn"]}

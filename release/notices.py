"""Writes the licences of all crates that are linked into the program and its library: `python3 release/notices.py FILE`.

The texts are those that the crates bring along. A crate without one is listed with the licence that it declares.
"""

import json
import subprocess
import sys
import textwrap
from pathlib import Path

REPOSITORY = Path(__file__).resolve().parent.parent
#: Beginnings of file names that hold a licence or what it asks to pass on.
NAMES = ("licen", "copying", "notice", "copyright", "unlicense")
TARGET = "x86_64-unknown-linux-gnu"


def linked() -> tuple[dict[str, dict], dict[str, list[str]]]:
    """The packages that end up in the artefacts, and what each needs, both by Cargo's identity of a package."""
    command = ["cargo", "metadata", "--format-version=1", "--locked", "--filter-platform", TARGET]
    metadata = json.loads(subprocess.run(command, cwd=REPOSITORY, stdout=subprocess.PIPE, check=True).stdout)
    packages = {package["id"]: package for package in metadata["packages"]}
    # Not what only tests and build scripts use.
    needs = {
        node["id"]: [one["pkg"] for one in node["deps"] if any(kind["kind"] is None for kind in one["dep_kinds"])]
        for node in metadata["resolve"]["nodes"]
    }
    waiting = [identity for identity, one in packages.items() if one["name"] in ("phalanx", "capi") and not one["source"]]
    seen: dict[str, dict] = {}
    while waiting:
        identity = waiting.pop()
        if identity not in seen:
            seen[identity] = packages[identity]
            waiting += needs[identity]
    return seen, needs


def texts(package: dict) -> list[str]:
    """The licences in the folder of a package, and of what it has in separate folders (the C sources of zstd)."""
    folder = Path(package["manifest_path"]).parent
    files = sorted(path for path in [*folder.glob("*"), *folder.glob("*/*")] if path.name.lower().startswith(NAMES))
    return [path.read_text(encoding="utf-8", errors="replace").strip() for path in files if path.is_file()]


def main() -> None:
    found, _ = linked()
    packages = sorted((one for one in found.values() if one["source"]), key=lambda one: (one["name"], one["version"]))
    # Many crates have the same text.
    crates: dict[str, list[str]] = {}
    for package in packages:
        for text in dict.fromkeys(texts(package)):
            crates.setdefault(text, []).append(f"{package['name']} {package['version']}")
    lines = [f"Phalanx contains {len(packages)} crates of other authors, under these licences:", ""]
    for package in packages:
        without = "" if texts(package) else " (no text in the crate)"
        lines.append(f"  {package['name']} {package['version']}: {package['license'] or 'see below'}{without}")
    for text, names in crates.items():
        lines += ["", "=" * 80, textwrap.fill(", ".join(names), 80), "-" * 80, "", text]
    Path(sys.argv[1]).write_text("\n".join(lines) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()

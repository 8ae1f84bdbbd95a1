"""Writes the bill of materials of program and library, CycloneDX 1.5 as JSON: `python3 release/bill.py FILE`.

It lists the crates that are linked, each with version, licence, source archive and its SHA-256 (from Cargo.lock), and which crate depends on which.
"""

import json
import os
import re
import sys
import tomllib
import uuid
from datetime import datetime, timezone
from pathlib import Path

from notices import REPOSITORY, linked


def reference(package: dict) -> str:
    """How the bill calls a crate."""
    return f"pkg:cargo/{package['name']}@{package['version']}"


def component(package: dict, checksums: dict[tuple[str, str], str]) -> dict:
    """The entry of a crate."""
    entry = {
        "type": "library",
        "bom-ref": reference(package),
        "name": package["name"],
        "version": package["version"],
        "purl": reference(package),
    }
    if package["description"]:
        entry["description"] = " ".join(package["description"].split())
    if package["license"]:
        # Cargo still takes the old form "MIT/Apache-2.0".
        entry["licenses"] = [{"expression": re.sub(r"\s*/\s*", " OR ", package["license"])}]
    if digest := checksums.get((package["name"], package["version"])):
        entry["hashes"] = [{"alg": "SHA-256", "content": digest}]
    if package["repository"]:
        entry["externalReferences"] = [{"type": "vcs", "url": package["repository"]}]
    return entry


def bill() -> dict:
    """The whole document."""
    packages, dependencies = linked()
    lock = tomllib.loads((REPOSITORY / "Cargo.lock").read_text())
    checksums = {(one["name"], one["version"]): one["checksum"] for one in lock["package"] if "checksum" in one}
    root = next(package for package in packages.values() if package["name"] == "phalanx" and not package["source"])
    parts = sorted((one for one in packages.values() if one is not root), key=reference)
    # The time and the serial number follow from the commit, so that the same commit gives the same bill.
    time = datetime.fromtimestamp(int(os.environ.get("SOURCE_DATE_EPOCH", "0")), timezone.utc)
    document = {
        "bomFormat": "CycloneDX",
        "specVersion": "1.5",
        "version": 1,
        "metadata": {
            "timestamp": time.strftime("%Y-%m-%dT%H:%M:%SZ"),
            "component": component(root, checksums) | {"type": "application"},
        },
        "components": [component(package, checksums) for package in parts],
        "dependencies": [
            {
                "ref": reference(package),
                "dependsOn": sorted(reference(packages[other]) for other in dependencies[identity] if other in packages),
            }
            for identity, package in sorted(packages.items(), key=lambda item: reference(item[1]))
        ],
    }
    serial = uuid.uuid5(uuid.NAMESPACE_OID, json.dumps(document, sort_keys=True))
    return {"serialNumber": f"urn:uuid:{serial}"} | document


if __name__ == "__main__":
    Path(sys.argv[1]).write_text(json.dumps(bill(), indent=1) + "\n", encoding="utf-8")

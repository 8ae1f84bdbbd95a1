"""Finding the library, and its mathematics."""

from __future__ import annotations

import _ctypes
import math
from pathlib import Path

import phalanx
import pytest
from phalanx import _library, libm

SAMPLES = [-2.5, -1.0, -0.3, -0.0, 1e-300, 0.1, 0.7, 1.0, 3.0]


def fresh_library() -> _library.Library:
    """The library as if it had not been loaded yet."""
    return _library.library.__wrapped__()


def test_a_named_library_that_is_not_there_is_an_error_that_says_what_to_do(monkeypatch, tmp_path: Path) -> None:
    monkeypatch.setenv("PHALANX_LIBRARY", str(tmp_path / "none.so"))
    with pytest.raises(phalanx.PhalanxError, match=r"none\.so.*cargo build --release --package capi"):
        fresh_library()


def test_a_file_that_is_no_library_is_named(monkeypatch, tmp_path: Path) -> None:
    wrong = tmp_path / "wrong.so"
    wrong.write_text("no library")
    monkeypatch.setenv("PHALANX_LIBRARY", str(wrong))
    with pytest.raises(phalanx.PhalanxError, match=r"wrong\.so cannot be loaded"):
        fresh_library()


def test_another_library_is_refused(monkeypatch) -> None:
    monkeypatch.setenv("PHALANX_LIBRARY", _ctypes.__file__)
    with pytest.raises(phalanx.PhalanxError, match="has no function `phalanx_abi_version`"):
        fresh_library()


def test_another_version_of_the_interface_is_refused(monkeypatch) -> None:
    monkeypatch.setattr(_library, "ABI_VERSION", 99)
    with pytest.raises(phalanx.PhalanxError, match="version 2 of the interface, this package needs 99"):
        fresh_library()


def test_every_function_of_the_header_is_bound() -> None:
    header = Path(__file__).resolve().parents[2] / "capi/include/phalanx.h"
    words = header.read_text().replace("(", " ( ").split()
    declared = {name.lstrip("*") for name, after in zip(words, words[1:]) if after == "(" and "phalanx_" in name}
    assert declared == set(_library._SIGNATURES)


@pytest.mark.parametrize("name", "sin cos tan atan sinh cosh tanh exp".split())
def test_functions_of_one_number(name: str) -> None:
    for x in SAMPLES:
        assert getattr(libm, name)(x) == pytest.approx(getattr(math, name)(x), rel=1e-15, abs=0)


def test_functions_of_a_part_of_the_numbers_and_of_two() -> None:
    assert libm.asin(0.3) == pytest.approx(math.asin(0.3), rel=1e-15)
    assert libm.acos(0.3) == pytest.approx(math.acos(0.3), rel=1e-15)
    assert libm.log(0.3) == pytest.approx(math.log(0.3), rel=1e-15)
    assert libm.pow(0.3, 1.7) == pytest.approx(math.pow(0.3, 1.7), rel=1e-15)
    assert libm.atan2(-0.3, -1.7) == pytest.approx(math.atan2(-0.3, -1.7), rel=1e-15)
    assert libm.hypot(0.3, 1.7) == pytest.approx(math.hypot(0.3, 1.7), rel=1e-15)


def test_outside_of_a_run_there_is_no_place(monkeypatch) -> None:
    for variable in ("PHALANX_RUN_DIR", "PHALANX_WORKER", "PHALANX_PAGE_FD"):
        monkeypatch.delenv(variable, raising=False)
    with pytest.raises(phalanx.PhalanxError, match="PHALANX_RUN_DIR"):
        phalanx.Participant()


def test_the_package_names_what_it_has() -> None:
    assert "Participant" in dir(phalanx)
    with pytest.raises(AttributeError, match="`Particpant`, only .*Participant"):
        phalanx.Particpant

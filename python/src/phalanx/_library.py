"""Finds and loads the shared library of the participants."""

from __future__ import annotations

import ctypes
import os
from ctypes import c_char_p, c_double, c_int, c_uint32, c_uint64, c_void_p
from functools import cache
from pathlib import Path
from typing import Any

NAME = "libphalanx.so"
VARIABLE = "PHALANX_LIBRARY"
# The version of the interface that this package is written for: PHALANX_ABI_VERSION in phalanx.h.
ABI_VERSION = 2


class PhalanxError(Exception):
    """What is wrong. A program that catches it continues; otherwise the run ends with the same words."""

    # What a traceback calls it.
    __module__ = "phalanx"


# What each function returns and takes, as in phalanx.h.
_SIGNATURES = {
    "phalanx_abi_version": (c_uint32, []),
    "phalanx_open": (c_void_p, [c_char_p]),
    "phalanx_error": (c_char_p, [c_void_p]),
    "phalanx_close": (c_int, [c_void_p]),
    "phalanx_count": (c_int, [c_void_p]),
    "phalanx_select": (c_int, [c_void_p, c_int]),
    "phalanx_selected": (c_int, [c_void_p]),
    "phalanx_agent": (c_int, [c_void_p]),
    "phalanx_served": (c_int, [c_void_p, c_void_p, c_int]),
    "phalanx_agents": (c_int, [c_void_p]),
    "phalanx_name": (c_char_p, [c_void_p]),
    "phalanx_dt": (c_double, [c_void_p]),
    "phalanx_steps": (c_uint64, [c_void_p]),
    "phalanx_has": (c_int, [c_void_p, c_char_p]),
    "phalanx_number": (c_double, [c_void_p, c_char_p]),
    "phalanx_text": (c_char_p, [c_void_p, c_char_p]),
    "phalanx_parameter": (c_char_p, [c_void_p, c_int, c_char_p]),
    "phalanx_path": (c_char_p, [c_void_p, c_char_p]),
    "phalanx_length": (c_int, [c_void_p, c_char_p]),
    "phalanx_model": (c_double, [c_void_p, c_int, c_char_p]),
    "phalanx_clear": (None, [c_void_p]),
    "phalanx_weight": (c_double, [c_void_p, c_int, c_int]),
    "phalanx_weight_at": (c_double, [c_void_p, c_int, c_int, c_double]),
    "phalanx_b": (c_double, [c_void_p, c_int]),
    "phalanx_neighbours": (c_int, [c_void_p, c_int, c_void_p, c_int]),
    "phalanx_disturbance": (c_int, [c_void_p, c_int, c_double, c_void_p, c_void_p, c_void_p]),
    "phalanx_mismatched": (c_int, [c_void_p, c_int, c_double, c_void_p, c_void_p, c_void_p]),
    "phalanx_input": (c_int, [c_void_p, c_char_p, c_int, c_char_p, c_int]),
    "phalanx_output": (c_int, [c_void_p, c_int, c_char_p, c_int]),
    "phalanx_signal": (c_int, [c_void_p, c_char_p, c_int, c_char_p, c_int, c_int]),
    "phalanx_size": (c_int, [c_void_p, c_char_p, c_int, c_char_p]),
    "phalanx_next": (c_int, [c_void_p]),
    "phalanx_step": (c_uint64, [c_void_p]),
    "phalanx_time": (c_double, [c_void_p]),
    "phalanx_read": (c_void_p, [c_void_p, c_int]),
    "phalanx_write": (c_void_p, [c_void_p, c_int]),
    "phalanx_done": (c_int, [c_void_p]),
    "phalanx_fail": (None, [c_void_p, c_char_p]),
}
for _one in "sin cos tan asin acos atan sinh cosh tanh exp log".split():
    _SIGNATURES[f"phalanx_{_one}"] = (c_double, [c_double])
for _two in "atan2 pow hypot".split():
    _SIGNATURES[f"phalanx_{_two}"] = (c_double, [c_double, c_double])

# These wait for other processes, and let the other threads of Python run meanwhile. All others are so short that letting go of
# the interpreter would take longer than they do.
_WAITING = ("phalanx_open", "phalanx_next")


def candidates() -> list[Path]:
    """Where the library is looked for, first to last: what the variable PHALANX_LIBRARY names, and nothing else if it is set;
    beside this file, where an installation puts it; `target/release` of the repository that this file lies in."""
    named = os.environ.get(VARIABLE)
    if named:
        return [Path(named)]
    here = Path(__file__).resolve()
    repositories = [folder for folder in here.parents if (folder / "capi" / "Cargo.toml").is_file()]
    return [here.with_name(NAME), *(folder / "target" / "release" / NAME for folder in repositories)]


class Library:
    """The functions of phalanx.h, as attributes without `phalanx_` in front."""

    def __getattr__(self, name: str) -> Any:
        # Only what `__init__` has not set comes here.
        raise AttributeError(f"phalanx.h has no function `phalanx_{name}`")

    def __init__(self, path: Path) -> None:
        try:
            quick, waiting = ctypes.PyDLL(str(path)), ctypes.CDLL(str(path))
        except OSError as error:
            raise PhalanxError(f"{path} cannot be loaded: {error}") from None
        for name, (result, arguments) in _SIGNATURES.items():
            try:
                function = getattr(waiting if name in _WAITING else quick, name)
            except AttributeError:
                raise PhalanxError(f"{path} has no function `{name}`: it is no {NAME}, or that of another version") from None
            function.restype, function.argtypes = result, arguments
            setattr(self, name.removeprefix("phalanx_"), function)
            if name == "phalanx_abi_version" and (found := function()) != ABI_VERSION:
                raise PhalanxError(
                    f"{path} has version {found} of the interface, this package needs {ABI_VERSION}: "
                    "install both from the same sources (`pip install ./python`)"
                )


@cache
def library() -> Library:
    """The library, loaded once.

    Raises PhalanxError if there is none, or one that does not fit.
    """
    places = candidates()
    found = next((place for place in places if place.is_file()), None)
    if found is None:
        looked = " or ".join(str(place) for place in places)
        raise PhalanxError(
            f"the shared library of Phalanx is not there: looked for {looked}. The wheel has it; in the repository, build it "
            f"with `cargo build --release --package capi` and name it: {VARIABLE}=.../target/release/{NAME}"
        )
    return Library(found)

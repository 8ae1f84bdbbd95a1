"""The elementary functions that Phalanx itself uses, with the same bits on every machine.

`math.sin` of Python is that of the C library of the machine, which may round the last bit differently; a controller that is to
give the same log as one in Rust or C++ uses these. They take and return floats. (`math.sqrt` is exact everywhere.)
"""

from __future__ import annotations

from typing import Callable

from ._library import library as _library

_functions = _library()

sin: Callable[[float], float] = _functions.sin
cos: Callable[[float], float] = _functions.cos
tan: Callable[[float], float] = _functions.tan
asin: Callable[[float], float] = _functions.asin
acos: Callable[[float], float] = _functions.acos
atan: Callable[[float], float] = _functions.atan
atan2: Callable[[float, float], float] = _functions.atan2
sinh: Callable[[float], float] = _functions.sinh
cosh: Callable[[float], float] = _functions.cosh
tanh: Callable[[float], float] = _functions.tanh
exp: Callable[[float], float] = _functions.exp
log: Callable[[float], float] = _functions.log
pow: Callable[[float, float], float] = _functions.pow
hypot: Callable[[float, float], float] = _functions.hypot

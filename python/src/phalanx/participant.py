"""A program in Python in the place of a participant of a run.

    import phalanx

    with phalanx.Participant() as me:
        position, target = me.state("position", 3), me.reference("position", 3)
        command = me.output("input", 3)
        gain = me.number("controller.k_x")
        for step in me:
            command.value = gain * (target.value - position.value)

and then: phalanx run SCENARIO --swap "controller.3=python3 my_controller.py"
"""

from __future__ import annotations

import ctypes
import math
import traceback
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import Any, Iterator

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._library import Library, PhalanxError, library

__all__ = ["Input", "Output", "Participant", "Participants", "PhalanxError", "Step"]


#: Which role publishes on a channel.
_WRITERS = {"state": "plant", "reference": "planner", "estimate": "observer", "command": "controller"}


@dataclass(slots=True)
class Step:
    """Where the run stands."""

    #: Number of the step, from 0.
    index: int
    #: Simulated time at the start of the step, in s.
    time: float


class _Handle:
    """The participant on the side of the library. It lives as long as anything that looks at its memory."""

    def __init__(self, functions: Library, role: str) -> None:
        self.functions = functions
        # NULL, which phalanx_close takes too, if there is no opening it.
        self.pointer: int | None = None
        #: Whether a step is in progress.
        self.in_step = False
        self.pointer = functions.open(role.encode())

    def error(self) -> str:
        """What went wrong; empty if nothing has."""
        return str(self.functions.error(self.pointer).decode(errors="replace"))

    def take_error(self) -> str:
        """The same. From here on it belongs to the caller, who raises it: caught, it does not end the run."""
        message = self.error()
        if message:
            self.functions.clear(self.pointer)
        return message

    def __del__(self) -> None:
        self.functions.close(self.pointer)


class _Signal:
    """A signal of the run: views onto the two places between which its samples alternate."""

    def __init__(self, handle: _Handle, number: int, name: str, length: int) -> None:
        self._handle, self._number, self._length = handle, number, length
        self._views: dict[int, NDArray[np.float64]] = {}
        #: What the signal is called, `position`.
        self.name = name

    def __len__(self) -> int:
        return self._length

    def _out_of_step(self) -> PhalanxError:
        return PhalanxError(f"`{self.name}`.value is there within a step only, in `for step in participant:`")

    def _view(self, address: int | None, writeable: bool) -> NDArray[np.float64]:
        if not address:
            raise PhalanxError(self._handle.take_error() or f"`{self.name}` has a value only within a step")
        memory = (ctypes.c_double * self._length).from_address(address)
        memory.handle = self._handle  # type: ignore[attr-defined]  # The view keeps the memory, and that its owner.
        view: NDArray[np.float64] = np.frombuffer(memory, dtype=np.float64)  # type: ignore[call-overload]
        view.flags.writeable = writeable
        self._views[address] = view
        return view


class Input(_Signal):
    """A signal that the participant reads."""

    @property
    def value(self) -> NDArray[np.float64]:
        """The numbers of this step: a view without a copy that cannot be written to. Copy what is to outlast the step."""
        if not self._handle.in_step:
            raise self._out_of_step()
        address = self._handle.functions.read(self._handle.pointer, self._number)
        view = self._views.get(address)
        return view if view is not None else self._view(address, writeable=False)


class Output(_Signal):
    """A signal that the participant writes, in every step."""

    def __init__(self, handle: _Handle, number: int, name: str, length: int) -> None:
        super().__init__(handle, number, name, length)
        self._touched = False

    @property
    def value(self) -> NDArray[np.float64]:
        """The place of the numbers of this step, to be filled: `output.value[:] = ...` or `output.value = ...`; a single one may be bare."""
        if not self._handle.in_step:
            raise self._out_of_step()
        self._touched = True
        address = self._handle.functions.write(self._handle.pointer, self._number)
        view = self._views.get(address)
        return view if view is not None else self._view(address, writeable=True)

    @value.setter
    def value(self, numbers: ArrayLike) -> None:
        numbers = np.asarray(numbers, dtype=np.float64)
        if self._length == 1 and not numbers.shape:
            numbers = numbers.reshape(1)
        if numbers.shape != (self._length,):
            raise ValueError(f"output `{self.name}` takes {self._length} numbers in a row, found the shape {numbers.shape}")
        self.value[:] = numbers


class Participant:
    """The place of this process in the run that started it.

    `role` is what the program serves as: "controller", "observer", "planner" or "plant". Signals are asked for before the first
    step; then the participant is iterated over, a step at a time. As a context (`with`) it ends the run with any exception that
    the program does not catch, and names it and the step. Agents count from 1; 0 is the participant's own.

    Raises PhalanxError if this process was not started by a run, or the run has another role for it.
    """

    def __init__(self, role: str = "controller") -> None:
        self._functions = library()
        self._role = role
        self._handle = _Handle(self._functions, role)
        self._outputs: list[Output] = []
        self._number: int | None = None
        self._raise_error()

    @property
    def _pointer(self) -> int | None:
        # One of several: what is asked is about it.
        if self._number is not None:
            self._functions.select(self._handle.pointer, self._number)
        return self._handle.pointer

    # -- What the run is --------------------------------------------------------------------------------------------------

    @property
    def name(self) -> str:
        """Name of the participant in the run, `controller_3`."""
        return str(self._functions.name(self._pointer).decode())

    @property
    def agent(self) -> int:
        """Number of the agent, from 1; 0 for a participant that serves several, or all of them."""
        return int(self._functions.agent(self._pointer))

    @property
    def served(self) -> list[int]:
        """The agents that the participant serves, ascending."""
        places = (ctypes.c_int * self.agents)()
        count = self._bound(self._functions.served(self._pointer, places, len(places)))
        return list(places[:count])

    @property
    def agents(self) -> int:
        """Number of agents in the scenario."""
        return int(self._functions.agents(self._pointer))

    @property
    def dt(self) -> float:
        """Length of a step, in s."""
        return float(self._functions.dt(self._pointer))

    @property
    def steps(self) -> int:
        """Number of steps of the run."""
        return int(self._functions.steps(self._pointer))

    # -- Values of the scenario -------------------------------------------------------------------------------------------

    def has(self, name: str) -> bool:
        """Whether the scenario as it is run, with variant and overrides, has a value of that dotted name."""
        return bool(self._functions.has(self._pointer, name.encode()))

    def number(self, name: str) -> float:
        """A number of the scenario by dotted name: `controller.c_p`, `agents.2.position.1` (lists count from 1).

        It is the number that the run uses: defaults, formulas of constants (`"pi/2"`), the default ring (`topology.A.1.3`) and what
        one value gives each agent (`topology.b.2`) are resolved. Raises PhalanxError if there is no such number; `has` asks first.
        """
        return self._checked(self._functions.number(self._pointer, name.encode()))

    def text(self, name: str) -> str:
        """A text of the scenario by dotted name."""
        return self._word(self._functions.text(self._pointer, name.encode()))

    def path(self, name: str) -> Path:
        """A text of the scenario that is a path, meant from the folder of the scenario file; absolute."""
        return Path(self._word(self._functions.path(self._pointer, name.encode())))

    def parameter(self, name: str, default: Any = None, agent: int = 0) -> Any:
        """A parameter for this program: that of an agent (`with` in its row; 0 is its own) or else that of the section, such as
        `[controller.with]`. A number (a boolean is 1.0 or 0.0), a text or a list. A text that is a path is `path`'s:
        `me.path("controller.with.model")`.

        Raises PhalanxError if there is none of this name, unless there is a `default`.
        """
        found = self._functions.parameter(self._pointer, agent, name.encode())
        if found is None and default is not None:
            self._handle.take_error()
            return default
        return self._value(self._word(found))

    def _value(self, name: str) -> Any:
        """A text, a list or a number by its full name, whichever it is."""
        text = self._functions.text(self._pointer, name.encode())
        if text is not None:
            return str(text.decode())
        self._handle.take_error()
        length = self._functions.length(self._pointer, name.encode())
        if length >= 0:
            return [self._value(f"{name}.{place}") for place in range(1, length + 1)]
        self._handle.take_error()
        return self.number(name)

    def _word(self, found: bytes | None) -> str:
        if found is None:
            raise PhalanxError(self._handle.take_error())
        return found.decode()

    def length(self, name: str) -> int:
        """Number of elements of a list of the scenario."""
        return self._bound(self._functions.length(self._pointer, name.encode()))

    def model(self, name: str, agent: int = 0) -> float:
        """What a controller may know of the vehicle of an agent (0: its own), as formulas call it: `m`, `R`, `Jx`."""
        return self._checked(self._functions.model(self._pointer, agent, name.encode()))

    # -- Graph and disturbance --------------------------------------------------------------------------------------------

    def weight(self, i: int, j: int, distance: float | None = None) -> float:
        """Weight of the link over which agent `i` receives from agent `j`; 0 if there is none.

        With the `distance` of both, in m, links that appear when agents come close (`topology.proximity`) count too.
        """
        if distance is None:
            return self._checked(self._functions.weight(self._pointer, i, j))
        return self._checked(self._functions.weight_at(self._pointer, i, j, distance))

    def neighbours(self, agent: int = 0) -> list[int]:
        """The agents from which an agent receives over static links, ascending.

        If the graph switches (`topology.at`), it is that of the step in progress, as for `weight` and `b`; before, that of step 0.
        """
        places = (ctypes.c_int * self.agents)()
        count = self._bound(self._functions.neighbours(self._pointer, agent, places, len(places)))
        return list(places[:count])

    def b(self, agent: int = 0) -> float:
        """Weight of the link between an agent and the reference."""
        return self._checked(self._functions.b(self._pointer, agent))

    def disturbance(self, agent: int, t: float, x: ArrayLike, v: ArrayLike | None = None) -> NDArray[np.float64]:
        """What `[disturbance]` adds where the input of an agent acts, at time `t`, coordinates `x` and velocities `v` (zeros)."""
        return self._disturb(self._functions.disturbance, agent, t, x, v)

    def mismatched(self, agent: int, t: float, x: ArrayLike, v: ArrayLike | None = None) -> NDArray[np.float64]:
        """The same for what is added to the velocities of a vehicle of order 2."""
        return self._disturb(self._functions.mismatched, agent, t, x, v)

    def _disturb(self, function: Any, agent: int, t: float, x: ArrayLike, v: ArrayLike | None) -> NDArray[np.float64]:
        length = self.length(f"agents.{agent or self.agent}.position")
        coordinates = _row("x", x, length)
        velocities = np.zeros(length) if v is None else _row("v", v, length)
        out = np.empty(length)
        pointers = (array.ctypes.data for array in (coordinates, velocities, out))
        if not function(self._pointer, agent, t, *pointers):
            raise PhalanxError(self._handle.take_error())
        return out

    # -- Signals ----------------------------------------------------------------------------------------------------------

    # A `length` that is not given is the one of the signal; one that is given is checked.

    def state(self, name: str, length: int | None = None, agent: int = 0) -> Input:
        """A signal of the plant, of this step. `agent` 0 is the participant's own."""
        return self.input("state", name, length, agent)

    def reference(self, name: str, length: int | None = None, agent: int = 0) -> Input:
        """A signal of the planner, of this step."""
        return self.input("reference", name, length, agent)

    def estimate(self, name: str, length: int | None = None, agent: int = 0) -> Input:
        """A signal of an observer, of this step."""
        return self.input("estimate", name, length, agent)

    def command_before(self, name: str, length: int | None = None, agent: int = 0) -> Input:
        """A signal of a controller, of the step before; zeros at step 0."""
        return self.input("command", name, length, agent)

    def read(self, role: str, name: str, length: int | None = None, agent: int = 0, before: bool = False) -> Input:
        """The signal `name` of a "plant", "planner", "observer" or "controller", of this step or of the step `before`.

        The scenario must let this participant read it: `reads` of its section says so, see "Adding a controller".
        """
        number = self._functions.signal(
            self._pointer, role.encode(), agent, name.encode(), length or 0, int(before)
        )
        number = self._bound(number)
        return Input(self._handle, number, name, self.size(role, name, agent))

    def size(self, role: str, name: str, agent: int = 0) -> int:
        """How many numbers a signal has."""
        return self._bound(self._functions.size(self._pointer, role.encode(), agent, name.encode()))

    def input(self, channel: str, name: str, length: int | None = None, agent: int = 0) -> Input:
        """The signal `name` of a channel: "state", "reference", "estimate" or "command"."""
        if length is None:
            if channel not in _WRITERS:
                raise PhalanxError(f"there is no channel called `{channel}`, expected one of {', '.join(_WRITERS)}")
            length = self.size(_WRITERS[channel], name, agent)
        number = self._functions.input(self._pointer, channel.encode(), agent, name.encode(), length)
        return Input(self._handle, self._bound(number), name, length)

    def output(self, name: str, length: int | None = None, agent: int = 0) -> Output:
        """A signal to write, as the participant that is replaced declares it, or `signals` of the scenario."""
        if length is None:
            length = self.size(self._role, name, agent)
        number = self._functions.output(self._pointer, agent, name.encode(), length)
        output = Output(self._handle, self._bound(number), name, length)
        self._outputs.append(output)
        return output

    # -- Steps ------------------------------------------------------------------------------------------------------------

    def __iter__(self) -> Iterator[Step]:
        functions, pointer = self._functions, self._handle.pointer
        while functions.next(pointer):
            yield from self._one_step()
            if not functions.done(pointer):
                break
        self._raise_error()

    def _one_step(self) -> Iterator[Step]:
        functions, handle = self._functions, self._handle
        handle.in_step = True
        yield Step(functions.step(handle.pointer), functions.time(handle.pointer))
        for output in self._outputs:
            if not output._touched:
                raise PhalanxError(self._failed(f"output `{output.name}` was not written"))
            output._touched = False
        handle.in_step = False

    def fail(self, message: str) -> None:
        """Ends the run with these words, because the participant cannot go on."""
        raise PhalanxError(self._failed(message))

    def __enter__(self) -> Participant:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, exception: BaseException | None, trace: TracebackType | None
    ) -> None:
        # What has ended the run already is known to it.
        if isinstance(exception, Exception) and not self._handle.error():
            # The last line of the program itself, not of this package.
            frames = [frame for frame in traceback.extract_tb(trace) if frame.filename != __file__]
            place = f" (line {frames[-1].lineno} of {frames[-1].filename})" if frames else ""
            kind = "" if isinstance(exception, PhalanxError) else f"{type(exception).__name__}: "
            self._failed(f"{kind}{exception}{place}")

    # -- Errors -----------------------------------------------------------------------------------------------------------

    def _failed(self, message: str) -> str:
        self._functions.fail(self._handle.pointer, message.encode(errors="replace").replace(b"\0", b" "))
        return message

    def _raise_error(self) -> None:
        if message := self._handle.take_error():
            raise PhalanxError(message)

    def _checked(self, number: float) -> float:
        if math.isnan(number):
            self._raise_error()
        return number

    def _bound(self, number: int) -> int:
        if number < 0:
            self._raise_error()
        return number


class Participants:
    """All participants that this process plays, as with --swap "controller.*@one=python3 mine.py".

        with phalanx.Participants("controller") as group:
            laws = {me.name: Law(me) for me in group}          # binds the signals of each
            for me, step in group.steps():                     # each in turn
                laws[me.name].step()

    `role`, and what is raised, are those of `Participant`.
    """

    def __init__(self, role: str = "controller") -> None:
        first = Participant(role)
        self._first, self._members = first, [first]
        functions, handle = first._functions, first._handle
        first._number = 0
        for number in range(1, int(functions.count(handle.pointer))):
            member = Participant.__new__(Participant)
            member._functions, member._role, member._handle = functions, role, handle
            member._outputs, member._number = [], number
            self._members.append(member)

    def __len__(self) -> int:
        return len(self._members)

    def __iter__(self) -> Iterator[Participant]:
        return iter(self._members)

    def steps(self) -> Iterator[tuple[Participant, Step]]:
        """Every step of every participant, in the order in which they run."""
        functions, handle = self._first._functions, self._first._handle
        for member in self._members:
            functions.select(handle.pointer, member._number)
        while functions.next(handle.pointer):
            member = self._members[functions.selected(handle.pointer)]
            yield from ((member, step) for step in member._one_step())
            if not functions.done(handle.pointer):
                break
        self._first._raise_error()

    def __enter__(self) -> Participants:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, exception: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._first.__exit__(kind, exception, trace)


def _row(name: str, numbers: ArrayLike, length: int) -> NDArray[np.float64]:
    """These numbers in a row, as the library reads them."""
    row = np.ascontiguousarray(numbers, dtype=np.float64)
    if row.shape != (length,):
        raise ValueError(f"`{name}` takes {length} numbers in a row, found the shape {row.shape}")
    return row

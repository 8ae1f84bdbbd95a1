//! Participants in other languages: the functions of `include/phalanx.h`, which documents them.
//!
//! What a pointer to a participant must be is what the header says: NULL, or what `phalanx_open` returned and `phalanx_close`
//! has not been given, used by one thread. So it arrives here as an optional reference or box.

mod mathematics;
mod participant;
mod scenario;
mod signals;

use std::ffi::{CStr, c_char, c_int};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::ptr::{null, null_mut};

use participant::Participant;
use scenario::Part;

/// The version of the interface; as in the header.
const ABI_VERSION: u32 = 2;

type Shared<'a> = Option<&'a Participant>;
type Mutable<'a> = Option<&'a mut Participant>;

/// Does `work`; whatever goes wrong, a panic too, is remembered and told to the run, and `failure` returned.
fn attempt<R>(participant: Mutable, failure: R, work: impl FnOnce(&mut Participant) -> Result<R, String>) -> R {
    let Some(participant) = participant else { return failure };
    // What a panic leaves half-done is not used again: the participant has failed then.
    let result = catch_unwind(AssertUnwindSafe(|| work(participant)));
    match result.unwrap_or_else(|_| Err("the library panicked; what it printed says where".into())) {
        Ok(value) => value,
        Err(message) => {
            participant.fail(message);
            failure
        }
    }
}

/// The same for what a program may go on without: what goes wrong is remembered, and ends the run at the next step unless the
/// program clears it.
fn ask<R>(participant: Mutable, failure: R, work: impl FnOnce(&mut Participant) -> Result<R, String>) -> R {
    let Some(participant) = participant else { return failure };
    match catch_unwind(AssertUnwindSafe(|| work(participant))) {
        Ok(Ok(value)) => value,
        Ok(Err(message)) => {
            participant.note(&message);
            failure
        }
        Err(_) => {
            participant.fail("the library panicked; what it printed says where".into());
            failure
        }
    }
}

/// Numbers of the caller.
fn numbers<'a>(pointer: *const f64, length: usize) -> Option<&'a [f64]> {
    // SAFETY: not NULL, so that there are `length` numbers that stay for the duration of the call, says the header.
    (!pointer.is_null()).then(|| unsafe { std::slice::from_raw_parts(pointer, length) })
}

/// A place for numbers of the caller.
fn room<'a, T>(pointer: *mut T, length: usize) -> Option<&'a mut [T]> {
    // SAFETY: not NULL, so that there is room for `length` numbers that nothing else uses during the call, says the header.
    (!pointer.is_null()).then(|| unsafe { std::slice::from_raw_parts_mut(pointer, length) })
}

/// A text of the caller.
fn text<'a>(pointer: *const c_char, what: &str) -> Result<&'a str, String> {
    if pointer.is_null() {
        return Err(format!("the {what} is NULL"));
    }
    // SAFETY: not NULL, so that it is a string that ends with 0 and stays for the duration of the call, says the header.
    let bytes = unsafe { CStr::from_ptr(pointer) };
    bytes.to_str().map_err(|_| format!("the {what} is no UTF-8 text"))
}

#[unsafe(no_mangle)]
extern "C" fn phalanx_abi_version() -> u32 {
    ABI_VERSION
}

#[unsafe(no_mangle)]
extern "C" fn phalanx_open(role: *const c_char) -> Box<Participant> {
    let opened = catch_unwind(|| Participant::open(text(role, "role")));
    Box::new(opened.unwrap_or_else(|_| Participant::nowhere("the library panicked; what it printed says where")))
}

#[unsafe(no_mangle)]
extern "C" fn phalanx_error(participant: Shared) -> *const c_char {
    participant.map_or(c"the participant is NULL".as_ptr(), |participant| participant.error().as_ptr())
}

#[unsafe(no_mangle)]
extern "C" fn phalanx_clear(participant: Mutable) {
    attempt(participant, (), |participant| {
        participant.clear();
        Ok(())
    });
}

#[unsafe(no_mangle)]
extern "C" fn phalanx_close(participant: Option<Box<Participant>>) -> c_int {
    let Some(mut participant) = participant else { return participant::NOWHERE };
    let code = participant.close();
    // A panic must not reach the caller, and the process ends in any case.
    let _ = catch_unwind(AssertUnwindSafe(|| drop(participant)));
    code
}

#[unsafe(no_mangle)]
extern "C" fn phalanx_count(participant: Shared) -> c_int {
    participant.map_or(0, |participant| participant.count() as c_int)
}

#[unsafe(no_mangle)]
extern "C" fn phalanx_select(participant: Mutable, number: c_int) -> c_int {
    ask(participant, 0, |participant| participant.select(number).map(|()| 1))
}

#[unsafe(no_mangle)]
extern "C" fn phalanx_selected(participant: Shared) -> c_int {
    participant.map_or(0, |participant| participant.selected() as c_int)
}

#[unsafe(no_mangle)]
extern "C" fn phalanx_agent(participant: Shared) -> c_int {
    participant.and_then(Participant::place).map_or(0, |place| place.agent as c_int)
}

#[unsafe(no_mangle)]
extern "C" fn phalanx_agents(participant: Shared) -> c_int {
    participant.and_then(Participant::place).map_or(0, |place| place.agents as c_int)
}

#[unsafe(no_mangle)]
extern "C" fn phalanx_served(participant: Mutable, agents: *mut c_int, capacity: c_int) -> c_int {
    ask(participant, -1, |participant| {
        let room = room(agents, usize::try_from(capacity).unwrap_or(0)).unwrap_or_default();
        let served = participant.interface()?.served();
        let count = served.len();
        room.iter_mut().zip(served).for_each(|(place, agent)| *place = agent.get() as c_int);
        Ok(count as c_int)
    })
}

#[unsafe(no_mangle)]
extern "C" fn phalanx_name(participant: Shared) -> *const c_char {
    participant.and_then(Participant::place).map_or(c"".as_ptr(), |place| place.name.as_ptr())
}

#[unsafe(no_mangle)]
extern "C" fn phalanx_dt(participant: Shared) -> f64 {
    participant.and_then(Participant::place).map_or(0.0, |place| place.dt)
}

#[unsafe(no_mangle)]
extern "C" fn phalanx_steps(participant: Shared) -> u64 {
    participant.and_then(Participant::place).map_or(0, |place| place.steps)
}

#[unsafe(no_mangle)]
extern "C" fn phalanx_has(participant: Shared, name: *const c_char) -> c_int {
    let found = text(name, "name").is_ok_and(|name| participant.is_some_and(|participant| participant.has(name)));
    found.into()
}

#[unsafe(no_mangle)]
extern "C" fn phalanx_number(participant: Mutable, name: *const c_char) -> f64 {
    ask(participant, f64::NAN, |participant| participant.number(text(name, "name of a number")?))
}

#[unsafe(no_mangle)]
extern "C" fn phalanx_text(participant: Mutable, name: *const c_char) -> *const c_char {
    ask(participant, null(), |participant| participant.text(text(name, "name of a text")?))
}

#[unsafe(no_mangle)]
extern "C" fn phalanx_parameter(participant: Mutable, agent: c_int, name: *const c_char) -> *const c_char {
    ask(participant, null(), |participant| participant.parameter(agent, text(name, "name of a parameter")?))
}

#[unsafe(no_mangle)]
extern "C" fn phalanx_path(participant: Mutable, name: *const c_char) -> *const c_char {
    ask(participant, null(), |participant| participant.path(text(name, "name of a path")?))
}

#[unsafe(no_mangle)]
extern "C" fn phalanx_length(participant: Mutable, name: *const c_char) -> c_int {
    ask(participant, -1, |participant| Ok(participant.length(text(name, "name of a list")?)? as c_int))
}

#[unsafe(no_mangle)]
extern "C" fn phalanx_model(participant: Mutable, agent: c_int, name: *const c_char) -> f64 {
    ask(participant, f64::NAN, |participant| participant.model(agent, text(name, "name of a model's number")?))
}

#[unsafe(no_mangle)]
extern "C" fn phalanx_weight(participant: Mutable, i: c_int, j: c_int) -> f64 {
    ask(participant, f64::NAN, |participant| participant.weight(i, j))
}

#[unsafe(no_mangle)]
extern "C" fn phalanx_weight_at(participant: Mutable, i: c_int, j: c_int, distance: f64) -> f64 {
    ask(participant, f64::NAN, |participant| participant.weight_at(i, j, distance))
}

#[unsafe(no_mangle)]
extern "C" fn phalanx_b(participant: Mutable, agent: c_int) -> f64 {
    ask(participant, f64::NAN, |participant| participant.reference_weight(agent))
}

#[unsafe(no_mangle)]
extern "C" fn phalanx_neighbours(participant: Mutable, agent: c_int, agents: *mut c_int, capacity: c_int) -> c_int {
    ask(participant, -1, |participant| {
        let room = room(agents, usize::try_from(capacity).unwrap_or(0)).unwrap_or_default();
        let mut places = room.iter_mut();
        let mut count = 0;
        for neighbour in participant.neighbours(agent)? {
            if let Some(place) = places.next() {
                *place = neighbour.get() as c_int;
            }
            count += 1;
        }
        Ok(count)
    })
}

#[unsafe(no_mangle)]
extern "C" fn phalanx_disturbance(
    participant: Mutable,
    agent: c_int,
    t: f64,
    x: *const f64,
    v: *const f64,
    out: *mut f64,
) -> c_int {
    disturbance(participant, Part::Matched, agent, t, [x, v], out)
}

#[unsafe(no_mangle)]
extern "C" fn phalanx_mismatched(
    participant: Mutable,
    agent: c_int,
    t: f64,
    x: *const f64,
    v: *const f64,
    out: *mut f64,
) -> c_int {
    disturbance(participant, Part::Mismatched, agent, t, [x, v], out)
}

fn disturbance(
    participant: Mutable,
    part: Part,
    agent: c_int,
    t: f64,
    [x, v]: [*const f64; 2],
    out: *mut f64,
) -> c_int {
    ask(participant, 0, |participant| {
        let length = participant.coordinates(agent)?;
        let x = numbers(x, length).ok_or("the coordinates are NULL")?;
        let v = numbers(v, length).unwrap_or_default();
        let out = room(out, length).ok_or("the place of the disturbance is NULL")?;
        participant.disturbance(part, agent, t, [x, v], out)?;
        Ok(length as c_int)
    })
}

#[unsafe(no_mangle)]
extern "C" fn phalanx_input(
    participant: Mutable,
    channel: *const c_char,
    agent: c_int,
    signal: *const c_char,
    length: c_int,
) -> c_int {
    ask(participant, -1, |participant| {
        participant.input(text(channel, "channel")?, agent, text(signal, "signal")?, length)
    })
}

#[unsafe(no_mangle)]
extern "C" fn phalanx_signal(
    participant: Mutable,
    role: *const c_char,
    agent: c_int,
    signal: *const c_char,
    length: c_int,
    before: c_int,
) -> c_int {
    ask(participant, -1, |participant| {
        participant.signal(text(role, "role")?, agent, text(signal, "signal")?, length, before != 0)
    })
}

#[unsafe(no_mangle)]
extern "C" fn phalanx_size(participant: Mutable, role: *const c_char, agent: c_int, signal: *const c_char) -> c_int {
    ask(participant, -1, |participant| participant.size(text(role, "role")?, agent, text(signal, "signal")?))
}

#[unsafe(no_mangle)]
extern "C" fn phalanx_output(participant: Mutable, agent: c_int, signal: *const c_char, length: c_int) -> c_int {
    ask(participant, -1, |participant| participant.output(agent, text(signal, "signal")?, length))
}

#[unsafe(no_mangle)]
extern "C" fn phalanx_next(participant: Mutable) -> c_int {
    attempt(participant, 0, |participant| participant.next().map(c_int::from))
}

#[unsafe(no_mangle)]
extern "C" fn phalanx_step(participant: Shared) -> u64 {
    participant.map_or(0, |participant| participant.step.index)
}

#[unsafe(no_mangle)]
extern "C" fn phalanx_time(participant: Shared) -> f64 {
    participant.map_or(0.0, |participant| participant.step.time())
}

#[unsafe(no_mangle)]
extern "C" fn phalanx_read(participant: Mutable, input: c_int) -> *const f64 {
    attempt(participant, null(), |participant| participant.read(input))
}

#[unsafe(no_mangle)]
extern "C" fn phalanx_write(participant: Mutable, output: c_int) -> *mut f64 {
    attempt(participant, null_mut(), |participant| participant.write(output))
}

#[unsafe(no_mangle)]
extern "C" fn phalanx_done(participant: Mutable) -> c_int {
    attempt(participant, 0, |participant| participant.done().map(c_int::from))
}

#[unsafe(no_mangle)]
extern "C" fn phalanx_fail(participant: Mutable, message: *const c_char) {
    attempt(participant, (), |_| Err(text(message, "message of phalanx_fail")?.to_string()));
}

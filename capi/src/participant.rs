//! The state of a participant in another language, and what may be done with it when.

use std::ffi::{CStr, CString, c_int};
use std::sync::atomic::{AtomicBool, Ordering};

use formation::scenario::Graph;
use formation::wiring::{Interface, Role, Station, load_scenario};
use lockstep::{Slice, Step};
use processes::{Link, Worker};

use crate::signals::Port;

/// Exit code of a program that no run started.
pub(crate) const NOWHERE: c_int = 2;

/// What a process plays: its places in a run, its signals, and how far it is.
pub(crate) struct Participant {
    /// One per participant that the process plays; none outside a run.
    seats: Vec<Seat>,
    /// The number of the one that questions and bindings are about.
    selected: usize,
    /// The number of the one whose step is in progress.
    pub(super) due: usize,
    /// The step in progress, or the last one.
    pub(crate) step: Step,
    /// The graphs from each of these steps on, kept so that nothing is allocated when a step asks for one; none outside a run.
    pub(super) graphs: Vec<(u64, Graph)>,
    pub(super) stage: Stage,
    /// The signals, each with the number of its participant.
    pub(super) ports: Vec<(usize, Port)>,
    /// Texts that the caller has pointers to.
    pub(super) texts: Vec<CString>,
    error: CString,
    exit_code: c_int,
}

/// A participant that this process plays.
struct Seat {
    place: Place,
    /// What it can ask for and bind.
    interface: Interface,
    /// The parts of its outputs that it did not bind.
    unbound: Vec<Slice>,
    /// Whether the program knows of it.
    is_known: bool,
}

/// What a participant asks about its place.
pub(crate) struct Place {
    pub(crate) name: CString,
    /// Number of the agent from 1; 0 if it serves all of them.
    pub(crate) agent: usize,
    pub(crate) agents: usize,
    pub(crate) dt: f64,
    pub(crate) steps: u64,
}

/// How far a participant is.
pub(super) enum Stage {
    /// Signals can be bound.
    Binding(Box<Worker>),
    /// Steps can be asked for.
    Running(Box<Link>),
    /// Nothing more can be done.
    Over,
}

impl Participant {
    /// A participant without a place in any run.
    pub(crate) fn nowhere(reason: &str) -> Self {
        Self {
            seats: Vec::new(),
            selected: 0,
            due: 0,
            step: Step { index: 0, dt: 0.0 },
            graphs: Vec::new(),
            stage: Stage::Over,
            ports: Vec::new(),
            texts: Vec::new(),
            error: c_text(reason),
            exit_code: NOWHERE,
        }
    }

    /// The place that the run has given to this process.
    pub(crate) fn open(role: Result<&str, String>) -> Self {
        // What the run has handed to this process can be taken over once only.
        static TAKEN: AtomicBool = AtomicBool::new(false);
        if TAKEN.swap(true, Ordering::Relaxed) {
            return Self::nowhere("this process is a participant already; it can be one only");
        }
        let worker = match Worker::join() {
            Ok(worker) => worker,
            Err(reason) => {
                let hint = "start it with `phalanx run SCENARIO --swap controller.3=PROGRAM`";
                return Self::nowhere(&format!("{reason}; {hint}"));
            }
        };
        match role.and_then(|role| find_seats(&worker, role)) {
            Ok(seats) => Self {
                step: Step { index: 0, dt: worker.plan().dt },
                graphs: seats.first().map(|seat| seat.interface.graphs()).unwrap_or_default(),
                seats,
                stage: Stage::Binding(Box::new(worker)),
                error: CString::default(),
                exit_code: 0,
                ..Self::nowhere("")
            },
            Err(message) => {
                let stage = Stage::Binding(Box::new(worker));
                let mut participant = Self { stage, exit_code: 0, ..Self::nowhere("") };
                participant.fail(message);
                participant
            }
        }
    }

    /// How many participants this process plays.
    pub(crate) fn count(&self) -> usize {
        self.seats.len()
    }

    /// The number of the one that questions are about.
    pub(crate) fn selected(&self) -> usize {
        self.selected
    }

    /// Makes questions and bindings be about the participant of this number.
    pub(crate) fn select(&mut self, number: c_int) -> Result<(), String> {
        let count = self.seats.len();
        let number = usize::try_from(number).ok().filter(|&number| number < count);
        self.selected =
            number.ok_or_else(|| format!("select: this process plays {count} participants, numbered from 0"))?;
        self.seats[self.selected].is_known = true;
        Ok(())
    }

    /// The place of the selected participant; `None` outside a run.
    pub(crate) fn place(&self) -> Option<&Place> {
        self.seats.get(self.selected).map(|seat| &seat.place)
    }

    /// What the selected participant can ask for and bind; `None` outside a run.
    pub(super) fn seat(&self) -> Option<&Interface> {
        self.seats.get(self.selected).map(|seat| &seat.interface)
    }

    /// The steps, and the parts of the outputs that the participant in progress did not bind; `None` if none runs.
    pub(super) fn running(&mut self) -> Option<(&mut Link, &[Slice])> {
        match (&mut self.stage, self.seats.get(self.due)) {
            (Stage::Running(link), Some(seat)) => Some((link.as_mut(), seat.unbound.as_slice())),
            _ => None,
        }
    }

    /// What failed first, until it is cleared.
    pub(crate) fn error(&self) -> &CStr {
        &self.error
    }

    /// Remembers what failed. Unless the program clears it, the run ends with it at the next step.
    pub(crate) fn note(&mut self, message: &str) {
        if self.error.is_empty() {
            self.error = c_text(message);
        }
    }

    /// Forgets what failed, if the program can go on without it.
    pub(crate) fn clear(&mut self) {
        if self.exit_code == 0 {
            self.error = CString::default();
        }
    }

    /// Ends the run with what failed and was not cleared; whether that was so.
    fn fail_with_what_is_noted(&mut self) -> bool {
        if self.exit_code != 0 || self.error.is_empty() {
            return false;
        }
        let message = self.error.to_string_lossy().into_owned();
        self.fail(message);
        true
    }

    /// Ends the run with `message`. Of several failures only the first counts.
    pub(crate) fn fail(&mut self, message: String) {
        if self.exit_code != 0 {
            return;
        }
        self.error = c_text(&message);
        match std::mem::replace(&mut self.stage, Stage::Over) {
            Stage::Binding(worker) => _ = worker.refuse(message),
            Stage::Running(mut link) => _ = link.fail(message),
            Stage::Over => return,
        }
        self.exit_code = 1;
    }

    /// Leaves the run; returns the exit code for the program.
    pub(crate) fn close(&mut self) -> c_int {
        self.fail_with_what_is_noted();
        self.stage = Stage::Over;
        self.exit_code
    }

    /// Waits for the next step; `false` if there is none.
    pub(crate) fn next(&mut self) -> Result<bool, String> {
        if self.fail_with_what_is_noted() {
            return Ok(false);
        }
        if let Stage::Binding(_) = self.stage {
            self.connect()?;
        }
        let Stage::Running(link) = &mut self.stage else { return Ok(false) };
        let due = link.next().map_err(|fault| fault.0);
        match due {
            Ok(Some(due)) => {
                self.step = due.step;
                (self.due, self.selected) = (due.number, due.number);
                self.write_unbound();
                Ok(true)
            }
            Ok(None) => {
                self.stage = Stage::Over;
                Ok(false)
            }
            Err(message) => Err(self.told(message)),
        }
    }

    /// Publishes the outputs; `false` if the run ends instead, with what failed before.
    pub(crate) fn done(&mut self) -> Result<bool, String> {
        if self.fail_with_what_is_noted() {
            return Ok(false);
        }
        let Stage::Running(link) = &mut self.stage else {
            return Err("done: no step is in progress".into());
        };
        let done = link.done();
        done.map(|()| true).map_err(|fault| self.told(fault.0))
    }

    fn connect(&mut self) -> Result<(), String> {
        if let Some(other) = self.seats.iter().skip(1).find(|seat| !seat.is_known) {
            return Err(format!(
                "this process plays {} participants, but the program binds no signal of {}; phalanx_select, or phalanx.Participants in \
                 Python, goes through them",
                self.seats.len(),
                other.interface.name()
            ));
        }
        if let Stage::Binding(worker) = std::mem::replace(&mut self.stage, Stage::Over) {
            let link = worker.connect().map_err(|fault| self.told(fault.0))?;
            self.stage = Stage::Running(Box::new(link));
            self.seats.iter_mut().for_each(|seat| seat.unbound = seat.interface.unbound());
        }
        Ok(())
    }

    /// The run has been told already why this participant cannot go on.
    fn told(&mut self, message: String) -> String {
        self.stage = Stage::Over;
        self.exit_code = 1;
        self.error = c_text(&message);
        message
    }
}

fn find_seats(worker: &Worker, role: &str) -> Result<Vec<Seat>, String> {
    let role = role_of(role, Role::name, "role")?;
    let scenario = load_scenario()?;
    let plan = worker.plan();
    let seat = |&node: &usize| -> Result<Seat, String> {
        let station = Station::new(&scenario, plan, role, node)?;
        let interface = Interface::new(scenario.clone(), station, plan.dt, plan.steps);
        let place = Place {
            name: c_text(interface.name()),
            agent: interface.agent().map_or(0, |agent| agent.get()),
            agents: interface.agents().len(),
            dt: plan.dt,
            steps: plan.steps,
        };
        Ok(Seat { place, interface, unbound: Vec::new(), is_known: false })
    };
    worker.nodes().iter().map(seat).collect()
}

/// The role whose `property` is `word`.
pub(super) fn role_of(word: &str, property: fn(Role) -> &'static str, what: &str) -> Result<Role, String> {
    Role::ALL.into_iter().find(|role| property(*role) == word).ok_or_else(|| {
        let words = Role::ALL.map(property).join(", ");
        format!("there is no {what} called `{word}`, expected one of {words}")
    })
}

/// A text for the caller; zeros within, which C could not tell from its end, become spaces.
pub(super) fn c_text(text: &str) -> CString {
    CString::new(text.replace('\0', " ")).unwrap_or_default()
}

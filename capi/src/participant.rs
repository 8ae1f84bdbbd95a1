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

/// A participant: its place in a run, its signals, and how far it is.
pub(crate) struct Participant {
    pub(crate) place: Place,
    /// The step in progress, or the last one.
    pub(crate) step: Step,
    /// What it can ask for and bind; `None` outside a run.
    pub(super) interface: Option<Interface>,
    /// The graphs from each of these steps on, kept so that nothing is allocated when a step asks for one; none outside a run.
    pub(super) graphs: Vec<(u64, Graph)>,
    pub(super) stage: Stage,
    pub(super) ports: Vec<Port>,
    /// The parts of its outputs that it did not bind.
    pub(super) unbound: Vec<Slice>,
    /// Texts that the caller has pointers to.
    pub(super) texts: Vec<CString>,
    error: CString,
    exit_code: c_int,
}

/// What a participant asks about its place.
#[derive(Default)]
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
            place: Place::default(),
            step: Step { index: 0, dt: 0.0 },
            interface: None,
            graphs: Vec::new(),
            stage: Stage::Over,
            ports: Vec::new(),
            unbound: Vec::new(),
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
        match role.and_then(|role| find_place(&worker, role)) {
            Ok((place, interface)) => Self {
                step: Step { index: 0, dt: place.dt },
                place,
                graphs: interface.graphs(),
                interface: Some(interface),
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
        if let Stage::Binding(worker) = std::mem::replace(&mut self.stage, Stage::Over) {
            let link = worker.connect().map_err(|fault| self.told(fault.0))?;
            self.stage = Stage::Running(Box::new(link));
            self.unbound = self.interface.as_ref().map(Interface::unbound).unwrap_or_default();
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

fn find_place(worker: &Worker, role: &str) -> Result<(Place, Interface), String> {
    let role = role_of(role, Role::name, "role")?;
    let scenario = load_scenario()?;
    let [node] = worker.nodes() else {
        return Err(format!("a program like this is one participant, but it was given {}", worker.nodes().len()));
    };
    let plan = worker.plan();
    let station = Station::new(&scenario, plan, role, *node)?;
    let interface = Interface::new(scenario, station, plan.dt, plan.steps);
    let place = Place {
        name: c_text(interface.name()),
        agent: interface.agent().map_or(0, |agent| agent.get()),
        agents: interface.agents().len(),
        dt: plan.dt,
        steps: plan.steps,
    };
    Ok((place, interface))
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

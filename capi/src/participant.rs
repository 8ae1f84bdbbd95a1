//! The state of a participant in another language, and what may be done with it when.

use std::ffi::{CStr, CString, c_int};
use std::sync::atomic::{AtomicBool, Ordering};

use formation::scenario::Scenario;
use formation::wiring::{Role, Station, load_scenario};
use lockstep::Step;
use processes::{Link, Worker};

use crate::signals::Port;

/// Exit code of a program that no run started.
pub(crate) const NOWHERE: c_int = 2;

/// A participant: its place in a run, its signals, and how far it is.
pub(crate) struct Participant {
    pub(crate) place: Place,
    /// The step in progress, or the last one.
    pub(crate) step: Step,
    pub(super) post: Option<Post>,
    pub(super) stage: Stage,
    pub(super) ports: Vec<Port>,
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

/// The scenario and the participant's node in it.
pub(super) struct Post {
    pub(super) scenario: Scenario,
    pub(super) station: Station,
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
            post: None,
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
            return Self::nowhere("phalanx_open was called before; a process is one participant");
        }
        let worker = match Worker::join() {
            Ok(worker) => worker,
            Err(reason) => {
                let hint = "start it with `phalanx run SCENARIO --swap controller.3=PROGRAM`";
                return Self::nowhere(&format!("{reason}; {hint}"));
            }
        };
        match role.and_then(|role| find_place(&worker, role)) {
            Ok((place, post)) => Self {
                step: Step { index: 0, dt: place.dt },
                place,
                post: Some(post),
                stage: Stage::Binding(Box::new(worker)),
                error: CString::default(),
                exit_code: 0,
                ..Self::nowhere("")
            },
            Err(message) => {
                let mut participant = Self { stage: Stage::Binding(Box::new(worker)), ..Self::nowhere("") };
                participant.fail(message);
                participant
            }
        }
    }

    /// Why the first function that failed did; those after it fail because of it.
    pub(crate) fn error(&self) -> &CStr {
        &self.error
    }

    /// Ends the run with `message`. Of several failures only the first counts.
    pub(crate) fn fail(&mut self, message: String) {
        if self.exit_code != 0 && !self.error.is_empty() {
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
        self.stage = Stage::Over;
        self.exit_code
    }

    /// Waits for the next step; `false` if there is none.
    pub(crate) fn next(&mut self) -> Result<bool, String> {
        if let Stage::Binding(_) = self.stage {
            self.connect()?;
        }
        let Stage::Running(link) = &mut self.stage else { return Ok(false) };
        let turn = link.next().map_err(|fault| fault.0);
        match turn {
            Ok(Some(turn)) => {
                self.step = turn.step;
                self.forget_outputs();
                Ok(true)
            }
            Ok(None) => {
                self.stage = Stage::Over;
                Ok(false)
            }
            Err(message) => Err(self.told(message)),
        }
    }

    /// Publishes the outputs.
    pub(crate) fn done(&mut self) -> Result<(), String> {
        let Stage::Running(link) = &mut self.stage else {
            return Err("phalanx_done: no step is in progress; phalanx_next begins one".into());
        };
        let done = link.done();
        done.map_err(|fault| self.told(fault.0))
    }

    fn connect(&mut self) -> Result<(), String> {
        if let Stage::Binding(worker) = std::mem::replace(&mut self.stage, Stage::Over) {
            let link = worker.connect().map_err(|fault| self.told(fault.0))?;
            self.stage = Stage::Running(Box::new(link));
        }
        Ok(())
    }

    /// The run has been told already why this participant cannot go on.
    fn told(&mut self, message: String) -> String {
        self.stage = Stage::Over;
        self.exit_code = 1;
        message
    }
}

fn find_place(worker: &Worker, role: &str) -> Result<(Place, Post), String> {
    let role = role_of(role, Role::name, "role")?;
    let scenario = load_scenario()?;
    let [node] = worker.nodes() else {
        return Err(format!("a program like this is one participant, but it was given {}", worker.nodes().len()));
    };
    let plan = worker.plan();
    let station = Station::new(&scenario, plan, role, *node)?;
    let agents = scenario.context.agents.len();
    let agent = match station.agents[..] {
        [agent] if station.node.name != role.name() => agent + 1,
        _ => 0,
    };
    let place = Place { name: c_text(&station.node.name), agent, agents, dt: plan.dt, steps: plan.steps };
    Ok((place, Post { scenario, station }))
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

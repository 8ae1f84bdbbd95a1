//! The state of a participant in another language, and what may be done with it when.

use std::ffi::{CStr, CString, c_int};

use formation::scenario::Scenario;
use formation::wiring::{Refusal, Role, Station, load_scenario};
use lockstep::{Link, Slice, Step, Timing, Worker};

/// Exit code of a program that no run started.
pub(crate) const NOWHERE: c_int = 2;

/// What messages call the component of a program like this.
const KIND: &str = "own program";

/// A participant: its place in a run, its signals, and how far it is.
pub(crate) struct Participant {
    pub(crate) place: Place,
    /// The step in progress, or the last one.
    pub(crate) step: Step,
    pub(super) post: Option<Post>,
    stage: Stage,
    ports: Vec<Port>,
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
    station: Station,
}

/// How far a participant is.
enum Stage {
    /// Signals can be bound.
    Binding(Worker),
    /// Steps can be asked for.
    Running(Box<Link>),
    /// Nothing more can be done.
    Over,
}

/// A bound signal; its place in the list is its handle.
#[derive(Clone, Copy)]
enum Port {
    Input(Slice),
    Output(Slice),
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
    pub(crate) fn open(role: &str) -> Self {
        let worker = match Worker::join() {
            Ok(worker) => worker,
            Err(reason) => {
                let hint = "start it with `phalanx run SCENARIO --swap controller.3=PROGRAM`";
                return Self::nowhere(&format!("{reason}; {hint}"));
            }
        };
        match find_place(&worker, role) {
            Ok((place, post)) => Self {
                step: Step { index: 0, dt: place.dt },
                place,
                post: Some(post),
                stage: Stage::Binding(worker),
                error: CString::default(),
                exit_code: 0,
                ..Self::nowhere("")
            },
            Err(message) => {
                let mut participant = Self { stage: Stage::Binding(worker), ..Self::nowhere("") };
                participant.fail(message);
                participant
            }
        }
    }

    /// Why the last function that failed did.
    pub(crate) fn error(&self) -> &CStr {
        &self.error
    }

    /// Ends the run with `message`. Of several failures the run is told the first.
    pub(crate) fn fail(&mut self, message: String) {
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

    /// Binds an input; returns its handle.
    pub(crate) fn input(&mut self, channel: &str, agent: c_int, signal: &str, length: c_int) -> Result<c_int, String> {
        let role = role_of(channel, Role::channel, "channel")?;
        let timing = if role == Role::Controller { Timing::Delayed } else { Timing::SameStep };
        let (agent, length) = (self.agent(agent)?, positive(signal, length)?);
        let slice = self.binding()?.bind(KIND).slice(role, agent, signal, length, timing);
        Ok(self.keep(Port::Input(slice.map_err(|Refusal(reason)| reason)?)))
    }

    /// Binds an output; returns its handle.
    pub(crate) fn output(&mut self, agent: c_int, signal: &str, length: c_int) -> Result<c_int, String> {
        let (agent, length) = (self.agent(agent)?, positive(signal, length)?);
        let slice = self.binding()?.bind(KIND).slice_out(agent, signal, length);
        Ok(self.keep(Port::Output(slice.map_err(|Refusal(reason)| reason)?)))
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

    /// Where the numbers of an input are.
    pub(crate) fn read(&mut self, handle: c_int) -> Result<*const f64, String> {
        match (self.port(handle)?, self.io()) {
            (Port::Input(slice), Some(io)) => Ok(io.input_pointer(slice)),
            (Port::Output(_), _) => Err(format!("phalanx_read: {handle} is an output, not an input")),
            (_, None) => Err("phalanx_read: no step is in progress; phalanx_next begins one".into()),
        }
    }

    /// Where the numbers of an output belong.
    pub(crate) fn write(&mut self, handle: c_int) -> Result<*mut f64, String> {
        match (self.port(handle)?, self.io()) {
            (Port::Output(slice), Some(mut io)) => Ok(io.output_pointer(slice)),
            (Port::Input(_), _) => Err(format!("phalanx_write: {handle} is an input, not an output")),
            (_, None) => Err("phalanx_write: no step is in progress; phalanx_next begins one".into()),
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

    /// Numbers that the program forgets to write are found by the check of the outputs.
    fn forget_outputs(&mut self) {
        let Stage::Running(link) = &mut self.stage else { return };
        let Some(mut io) = link.io() else { return };
        for port in &self.ports {
            if let Port::Output(slice) = *port {
                io.slice_mut(slice).fill(f64::NAN);
            }
        }
    }

    fn io(&mut self) -> Option<lockstep::Io<'_>> {
        match &mut self.stage {
            Stage::Running(link) => link.io(),
            _ => None,
        }
    }

    fn port(&self, handle: c_int) -> Result<Port, String> {
        let port = usize::try_from(handle).ok().and_then(|place| self.ports.get(place));
        port.copied().ok_or_else(|| {
            format!("{handle} is no handle of a signal; phalanx_input and phalanx_output give such handles")
        })
    }

    fn keep(&mut self, port: Port) -> c_int {
        self.ports.push(port);
        self.ports.len() as c_int - 1
    }

    /// The place to bind signals at, as long as that is possible.
    fn binding(&self) -> Result<&Station, String> {
        match (&self.stage, &self.post) {
            (Stage::Binding(_), Some(post)) => Ok(&post.station),
            (Stage::Running(_), _) => Err("signals can be bound before the first phalanx_next only".into()),
            _ => Err("signals can be bound in a run only".into()),
        }
    }

    /// The agent (from 0) that the caller means.
    pub(super) fn agent(&self, number: c_int) -> Result<usize, String> {
        match usize::try_from(number) {
            Ok(0) if self.place.agent == 0 => {
                Err("this participant serves all agents; name one, counting from 1".into())
            }
            Ok(0) => Ok(self.place.agent - 1),
            Ok(number) if number <= self.place.agents => Ok(number - 1),
            _ => Err(format!("there is no agent {number}; the scenario has {}, counted from 1", self.place.agents)),
        }
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
fn role_of(word: &str, property: fn(Role) -> &'static str, what: &str) -> Result<Role, String> {
    Role::ALL.into_iter().find(|role| property(*role) == word).ok_or_else(|| {
        let words = Role::ALL.map(property).join(", ");
        format!("there is no {what} called `{word}`, expected one of {words}")
    })
}

fn positive(signal: &str, length: c_int) -> Result<usize, String> {
    let length = usize::try_from(length).ok().filter(|&length| length > 0);
    length.ok_or_else(|| format!("the signal `{signal}` was asked for with a length that is not positive"))
}

/// A text for the caller; zeros within, which C could not tell from its end, become spaces.
pub(super) fn c_text(text: &str) -> CString {
    CString::new(text.replace('\0', " ")).unwrap_or_default()
}

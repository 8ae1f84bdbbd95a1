//! The run as viewers draw it by themselves: messages of well-known ROS 2 types beside the signals, in the same log.
//!
//! | topic | type | what |
//! |---|---|---|
//! | `/tf` | `tf2_msgs/TFMessage` | the frame `agent_1`, ... of every agent in `world` |
//! | `/scene/bodies` | `visualization_msgs/MarkerArray` | bodies, headings, numbers, in those frames |
//! | `/scene/obstacles` | the same | obstacles and the boundaries of their potential fields |
//! | `/scene/links` | the same | links of the communication graph that exist |
//! | `/scene/trails` | the same | where the agents came from |
//! | `/scene/poses`, `/scene/targets` | `geometry_msgs/PoseArray` | where the agents are, and their places in the formation |
//! | `/rosout` | `rcl_interfaces/Log` | start, end, faults, links that appear and vanish |
//!
//! What moves comes with 50 Hz of simulated time, or with every step if steps are longer. A scene follows from the samples
//! alone, so that equal runs keep giving equal logs.

mod actors;
mod bodies;
mod message;
mod moving;

use formation::scenario::Obstacles;
use formation::wiring::Assembly;
use lockstep::{Period, Store};
use processes::RunError;

use super::observer::{Flow, Observer, StepView};
use super::outcome::Ending;
use actors::{Actor, Link, actors, links};
use message::{Level, journal, poses, transforms};
use moving::{Links, Trails};
use recording::definitions::{self, Definition, JOURNAL, MARKERS, POSES, TRANSFORMS};
use recording::{Cdr, Durability, ExtraChannel, LogError, Recorder};

/// Simulated time between two frames of what moves, ns, if steps are not longer.
const FRAME_NS: u64 = 20_000_000;
/// Simulated time after which constant markers are repeated, for viewers that start in the middle of a log, ns.
const REMINDER_NS: u64 = 10_000_000_000;
/// What a line of the journal is from, if it is not from a participant.
const PROGRAM: &str = "phalanx";

/// Draws a run into its log.
pub struct Scene {
    period: Period,
    /// Steps from one frame to the next.
    every: u64,
    /// Frames between two reminders.
    reminder: u64,
    /// What is said at the start.
    greeting: String,
    actors: Vec<Actor>,
    obstacles: Option<Obstacles>,
    links: Links,
    trails: Trails,
    topics: Topics,
    /// Step of the last frame or line.
    last: Option<u64>,
    cdr: Cdr,
}

/// The channels of the scene; those are missing for which there is nothing to show.
struct Topics {
    transforms: ExtraChannel,
    bodies: ExtraChannel,
    obstacles: Option<ExtraChannel>,
    links: Option<ExtraChannel>,
    trails: ExtraChannel,
    poses: ExtraChannel,
    targets: Option<ExtraChannel>,
    journal: ExtraChannel,
}

impl Scene {
    /// Adds the topics of the scene to a log in which nothing is recorded yet; `None` if the positions of the agents are not
    /// among the signals.
    ///
    /// # Errors
    /// [`LogError`] if the log cannot take them.
    pub fn new(assembly: &Assembly, recorder: &mut Recorder) -> Result<Option<Self>, LogError> {
        let (scenario, context) = (&assembly.scenario, &assembly.scenario.context);
        let actors = actors(assembly);
        if actors.is_empty() {
            return Ok(None);
        }
        let period = context.timing.period();
        let every = period.steps_within(FRAME_NS).max(1);
        let frames = |time_ns: u64| (period.steps_within(time_ns) / every).max(1);
        let links = Links::new(links(assembly, &actors));
        let trails = Trails::new(actors.len(), frames);
        let obstacles = context.obstacles.clone().filter(|obstacles| !obstacles.radii.is_empty());
        let mut add = |topic: &str, definitions: &[Definition]| {
            let durability = if topic == "/tf" { Durability::Volatile } else { Durability::TransientLocal };
            recorder.add_channel(topic, definitions[0].0, &definitions::text(definitions), durability)
        };
        let topics = Topics {
            transforms: add("/tf", TRANSFORMS)?,
            bodies: add("/scene/bodies", MARKERS)?,
            obstacles: obstacles.as_ref().map(|_| add("/scene/obstacles", MARKERS)).transpose()?,
            links: (!links.is_empty()).then(|| add("/scene/links", MARKERS)).transpose()?,
            trails: add("/scene/trails", MARKERS)?,
            poses: add("/scene/poses", POSES)?,
            targets: actors.iter().any(Actor::has_target).then(|| add("/scene/targets", POSES)).transpose()?,
            journal: add("/rosout", JOURNAL)?,
        };
        let variant = if scenario.variant.is_empty() { String::new() } else { format!(" {}", scenario.variant) };
        let title = if scenario.title.is_empty() { String::new() } else { format!("{}; ", scenario.title) };
        let greeting = format!(
            "{}{variant}: {title}{} agents, {} s in steps of {} s",
            scenario.name,
            context.agents.len(),
            context.timing.duration,
            context.timing.period()
        );
        let reminder = frames(REMINDER_NS);
        let (last, cdr) = (None, Cdr::new());
        Ok(Some(Self { period, every, reminder, greeting, actors, obstacles, links, trails, topics, last, cdr }))
    }

    fn draw(&mut self, step: u64, store: &Store, recorder: &mut Recorder) -> Result<(), LogError> {
        let started = self.last.replace(step).is_some();
        let time_ns = self.period.time_ns(step);
        if !started {
            journal(&mut self.cdr, time_ns, Level::Info, PROGRAM, &self.greeting);
            recorder.write(self.topics.journal, step, self.cdr.bytes())?;
        }
        if !step.is_multiple_of(self.every) {
            return Ok(());
        }
        let frame = step / self.every;
        if !started || frame.is_multiple_of(self.reminder) {
            self.draw_what_rests(step, time_ns, recorder)?;
        }
        let Self { cdr, actors, topics, .. } = self;
        transforms(cdr, time_ns, actors.iter().map(|actor| (actor.frame.as_str(), actor.pose(store, step))));
        recorder.write(topics.transforms, step, cdr.bytes())?;
        poses(cdr, time_ns, actors.iter().map(|actor| actor.pose(store, step)));
        recorder.write(topics.poses, step, cdr.bytes())?;
        if let Some(channel) = topics.targets {
            let targets: Vec<_> = actors.iter().filter_map(|actor| actor.target(store, step)).collect();
            poses(cdr, time_ns, targets.into_iter());
            recorder.write(channel, step, cdr.bytes())?;
        }
        let places: Vec<[f64; 3]> = actors.iter().map(|actor| actor.pose(store, step).place).collect();
        if let Some(channel) = topics.links {
            let changes = self.links.update(|link: &Link| link.exists(store, step));
            for change in changes.into_iter().filter(|_| started) {
                let [from, to] = [change.from, change.to].map(|place| actors[place].number);
                let verb = if change.exists { "hears" } else { "no longer hears" };
                let text = format!("agent {to} {verb} agent {from}");
                journal(cdr, time_ns, Level::Info, PROGRAM, &text);
                recorder.write(topics.journal, step, cdr.bytes())?;
            }
            self.links.draw(cdr, time_ns, &places);
            recorder.write(channel, step, cdr.bytes())?;
        }
        if self.trails.update(frame, &places) {
            self.trails.draw(cdr, time_ns, actors);
            recorder.write(topics.trails, step, cdr.bytes())?;
        }
        Ok(())
    }

    fn draw_what_rests(&mut self, step: u64, time_ns: u64, recorder: &mut Recorder) -> Result<(), LogError> {
        bodies::bodies(&mut self.cdr, time_ns, &self.actors);
        recorder.write(self.topics.bodies, step, self.cdr.bytes())?;
        if let (Some(obstacles), Some(channel)) = (&self.obstacles, self.topics.obstacles) {
            // The boundaries hold for the centre of an agent: those of the largest one.
            let radius = self.actors.iter().map(|actor| actor.radius).fold(0.0, f64::max);
            bodies::obstacles(&mut self.cdr, time_ns, obstacles, radius);
            recorder.write(channel, step, self.cdr.bytes())?;
        }
        Ok(())
    }
}

impl Observer for Scene {
    /// Draws the step if a frame is due.
    fn step(&mut self, view: &mut StepView, log: Option<&mut Recorder>) -> Result<Flow, LogError> {
        log.map_or(Ok(()), |log| self.draw(view.step, view.store, log))?;
        Ok(Flow::Continue)
    }

    /// Writes how the run ended, at its last recorded step.
    fn end(&mut self, ending: &Ending, log: Option<&mut Recorder>) -> Result<(), LogError> {
        let (Some(step), Some(log)) = (self.last, log) else { return Ok(()) };
        let (level, name, text) = last_words(ending, step);
        journal(&mut self.cdr, self.period.time_ns(step), level, &name, &text);
        log.write(self.topics.journal, step, self.cdr.bytes())
    }
}

/// What is said at the end. Neither processes nor times of the wall clock are named: equal runs give equal logs.
fn last_words(ending: &Ending, step: u64) -> (Level, String, String) {
    let program = || PROGRAM.to_string();
    match ending {
        Ending::Complete | Ending::Halted => {
            (Level::Info, program(), format!("the run is complete, {} steps", step + 1))
        }
        Ending::Failed(RunError::Fault { node, step, message }) => {
            (Level::Error, node.clone(), format!("fault at step {step}: {message}"))
        }
        Ending::Interrupted { .. } | Ending::Emergency { .. } => {
            (Level::Warn, program(), format!("interrupted after step {step}"))
        }
        Ending::TooLate { .. } => (Level::Fatal, program(), format!("too late for its time after step {step}")),
        Ending::Failed(RunError::Died { worker, death, .. }) => {
            (Level::Fatal, worker.clone(), format!("the process {death} after step {step}"))
        }
        Ending::Failed(RunError::Deadline { late, .. }) => {
            let names: Vec<&str> = late.iter().map(|late| late.worker.as_str()).collect();
            (Level::Fatal, program(), format!("no answer after step {step} from {}", names.join(", ")))
        }
        Ending::Failed(_) | Ending::LogFailed(_) => {
            (Level::Fatal, program(), format!("the run could not go on after step {step}"))
        }
    }
}

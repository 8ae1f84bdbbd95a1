//! Events of iceoryx2 in the place of futexes: a service for every gate, with a listener for each worker of its phase, and one
//! for the bell.
//!
//! The conductor creates all services before it starts a process, with room for all processes that may ever take part: a killed
//! process keeps its place, since no process cleans up. A notification to a process that does not listen yet is lost, and one
//! under load now and then; that is why every wait is short.

use std::env;
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};
use std::time::Duration;

use iceoryx2::node::Node;
use iceoryx2::port::listener::Listener;
use iceoryx2::port::notifier::Notifier;
use iceoryx2::prelude::{FileName, NodeBuilder, SemanticString, SignalHandlingMode};
use iceoryx2::service::ipc_threadsafe::Service;
use iceoryx2::service::port_factory::event::PortFactory;

use super::protocol::WaitPoint;
use crate::service::{ServiceError, configuration, error};
use crate::{RunDirectory, directory};
use lockstep::Plan;

/// How long a wait is at most, before the word is looked at again.
pub(super) const LOOK: Duration = Duration::from_millis(4);
/// Environment variable that makes this process lose every so many-th of its notifications, to show that a run does not depend
/// on them.
const LOSS: &str = "PHALANX_LOSE_WAKE_UPS";
/// Longest path of a socket, without the zero at its end.
const MAX_SOCKET_PATH: usize = 107;
/// Digits of the longest name that iceoryx2 gives to a listener.
const LISTENER_DIGITS: usize = 39;
/// What iceoryx2 puts behind that: short, since paths of sockets are.
const SUFFIX: &[u8] = b".e";
/// Characters of the number that tells runs of one name apart.
const NUMBER: usize = 4;
/// What a port takes in the memory of a service.
const PORT_BYTES: usize = 256;
/// What a service takes besides.
const SERVICE_BYTES: usize = 16 << 10;

/// The ports of this process: of every gate, and last of the bell.
pub(crate) struct Events {
    // A process uses them from several threads: the conductor's, and those who ring for it.
    listeners: Vec<Option<Listener<Service>>>,
    notifiers: Vec<Option<Notifier<Service>>>,
    loss: Option<Loss>,
}

/// Which workers sleep at a point and which wake them, by number.
struct Participants {
    point: WaitPoint,
    listeners: Vec<usize>,
    notifiers: Vec<usize>,
}

impl Events {
    /// Creates all services of a run whose workers are replaced at most so often, and joins them as the conductor.
    ///
    /// # Errors
    /// [`ServiceError`] if iceoryx2 cannot do that, or paths would be too long.
    pub(crate) fn create(run_directory: &Path, plan: &Plan, replacements: usize) -> Result<Self, ServiceError> {
        check_path(run_directory, &plan.run)?;
        let node = join(run_directory, &plan.run, "conductor")?;
        let mut events = Self::empty();
        for Participants { point, listeners, notifiers } in participants(plan) {
            let what = || format!("create the event of {point:?}");
            // And the conductor.
            let ports = |workers: &[usize]| workers.len() * (replacements + 1) + 1;
            let (listening, notifying) = (ports(&listeners), ports(&notifiers));
            directory::require_room((listening + notifying) * PORT_BYTES + SERVICE_BYTES)
                .map_err(|error| ServiceError { what: what(), cause: error.to_string() })?;
            let service = node
                .service_builder(&name(point).as_str().try_into().map_err(error(what()))?)
                .event()
                .max_listeners(listening)
                .max_notifiers(notifying)
                .max_nodes(listening + notifying)
                .event_id_max_value(0)
                .create();
            let service = service.map_err(error(what()))?;
            events.add(&service, point, point == WaitPoint::Bell, true)?;
        }
        Ok(events)
    }

    /// Joins the events of a run as a worker: listens at the gates of its phases, and notifies the bell and the next gate.
    ///
    /// # Errors
    /// [`ServiceError`] if a service cannot be opened.
    pub(crate) fn join(run_directory: &Path, plan: &Plan, worker: usize) -> Result<Self, ServiceError> {
        let node = join(run_directory, &plan.run, &plan.workers[worker].name)?;
        let mut events = Self::empty();
        for Participants { point, listeners, notifiers } in participants(plan) {
            let (listens, notifies) = (listeners.contains(&worker), notifiers.contains(&worker));
            if !listens && !notifies {
                events.listeners.push(None);
                events.notifiers.push(None);
                continue;
            }
            let what = || format!("open the event of {point:?}");
            let name = name(point).as_str().try_into().map_err(error(what()))?;
            let service = node.service_builder(&name).event().open().map_err(error(what()))?;
            events.add(&service, point, listens, notifies)?;
        }
        Ok(events)
    }

    fn empty() -> Self {
        Self { listeners: Vec::new(), notifiers: Vec::new(), loss: Loss::from_environment() }
    }

    fn add(
        &mut self,
        service: &PortFactory<Service>,
        point: WaitPoint,
        listens: bool,
        notifies: bool,
    ) -> Result<(), ServiceError> {
        let what = |action: &str| format!("{action} the event of {point:?}");
        let listener = listens.then(|| service.listener_builder().create()).transpose();
        self.listeners.push(listener.map_err(error(what("listen to")))?);
        let notifier = notifies.then(|| service.notifier_builder().create()).transpose();
        self.notifiers.push(notifier.map_err(error(what("notify")))?);
        Ok(())
    }

    /// Waits until a process notifies this point, for at most `patience`, and forgets all notifications so far.
    pub(super) fn wait(&self, point: WaitPoint, patience: Duration) {
        let listener = port(&self.listeners, point);
        let waited = listener.map(|listener| listener.timed_wait(|_| {}, patience));
        if !matches!(waited, Some(Ok(_))) {
            // A process that cannot wait must not use up its core.
            std::thread::sleep(patience);
        }
    }

    /// Wakes all processes that listen at a point.
    pub(super) fn notify(&self, point: WaitPoint) {
        if self.loss.as_ref().is_some_and(Loss::is_due) {
            return;
        }
        // A process that could not be notified soon reads its word by itself.
        let _ = port(&self.notifiers, point).map(Notifier::notify);
    }
}

fn port<P>(ports: &[Option<P>], point: WaitPoint) -> Option<&P> {
    match point {
        WaitPoint::Gate(phase) => ports.get(phase)?.as_ref(),
        WaitPoint::Bell => ports.last()?.as_ref(),
    }
}

/// All participants: of every gate, and last of the bell.
fn participants(plan: &Plan) -> Vec<Participants> {
    let phases = plan.phase_count();
    let gate = |phase| Participants {
        point: WaitPoint::Gate(phase),
        listeners: plan.members(phase),
        // The last worker of a phase opens the next one, or the first one of the next step.
        notifiers: plan.members((phase + phases - 1) % phases),
    };
    let bell =
        Participants { point: WaitPoint::Bell, listeners: Vec::new(), notifiers: (0..plan.workers.len()).collect() };
    (0..phases).map(gate).chain([bell]).collect()
}

fn name(point: WaitPoint) -> String {
    match point {
        WaitPoint::Bell => "wake/bell".into(),
        WaitPoint::Gate(phase) => format!("wake/gate.{phase}"),
    }
}

fn join(run_directory: &Path, run: &str, name: &str) -> Result<Node<Service>, ServiceError> {
    let failed = || format!("iceoryx2 does not let {name} wake other processes");
    let mut config = configuration(run_directory, run)?;
    config.global.service.event_connection_suffix = FileName::new(SUFFIX).map_err(error(failed()))?;
    let node_name = name.try_into().map_err(error(failed()))?;
    let builder =
        NodeBuilder::new().name(&node_name).config(&config).signal_handling_mode(SignalHandlingMode::Disabled);
    builder.create().map_err(error(failed()))
}

/// Whether the sockets of a run may have the paths that iceoryx2 gives them. It only logs it if they may not.
fn check_path(run_directory: &Path, run: &str) -> Result<(), ServiceError> {
    let longest = longest_path(run_directory, run);
    if longest <= MAX_SOCKET_PATH {
        return Ok(());
    }
    let cause = format!(
        "paths of its sockets would have {longest} characters instead of {MAX_SOCKET_PATH}; call it `{}`",
        run.chars().take(longest_name()).collect::<String>()
    );
    Err(ServiceError { what: format!("wake the processes of run {run} by events"), cause })
}

/// Characters that the name of a run may have, with a number behind them.
pub(super) fn longest_name() -> usize {
    // It is part of the directory's path and of every file's name.
    let rest = longest_path(&RunDirectory::path_of(""), "");
    (MAX_SOCKET_PATH.saturating_sub(rest) / 2).saturating_sub(NUMBER)
}

fn longest_path(run_directory: &Path, run: &str) -> usize {
    run_directory.as_os_str().len() + 1 + directory::prefix(run).len() + LISTENER_DIGITS + SUFFIX.len()
}

/// Notifications that are lost on purpose.
struct Loss {
    every: u64,
    count: AtomicU64,
}

impl Loss {
    fn from_environment() -> Option<Self> {
        let every = env::var(LOSS).ok()?.parse().ok()?;
        Some(Self { every, count: AtomicU64::new(0) })
    }

    fn is_due(&self) -> bool {
        (self.count.fetch_add(1, Relaxed) + 1).is_multiple_of(self.every)
    }
}

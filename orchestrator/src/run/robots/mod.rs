//! The robots of a run: the bridges to them, and the emulators that are started for it.

mod log;

use std::io::{BufRead, BufReader};
use std::net::{Ipv4Addr, SocketAddr};
use std::os::unix::process::CommandExt;
use std::path::Path;
use std::process::{Child, Command, Stdio};

use formation::wiring::{Assembly, Role, SCENARIO_FILE};
use hardware::health;
use hardware::settings::Settings;
use lockstep::{Channel, ChannelId, Input, Network, Node, Timing, WorkerPlan};

pub(crate) use log::RobotLog;

use crate::failure::Failure;
use crate::run::priority::Priority;
use crate::run::swap::{RobotSwap, Swap};

/// What the emulator prints before its address.
pub(crate) const LISTENS: &str = "listens at ";

/// The emulators of a run. Dropping it ends them.
#[derive(Debug, Default)]
pub struct Robots {
    emulators: Vec<Child>,
}

impl Drop for Robots {
    fn drop(&mut self) {
        for emulator in &mut self.emulators {
            // It may have ended by itself.
            let _ = emulator.kill();
            let _ = emulator.wait();
        }
    }
}

/// The network with a second node for every bridge, which sends the command at the end of a step. If its robot has a clock of
/// its own, it also tells how the robot is, on a channel behind all others.
pub(crate) fn with_hands(network: &Network, swaps: &[Swap]) -> Network {
    let mut network = network.clone();
    for swap in swaps {
        let (Some(robot), Some(number)) = (swap.robot(), swap.agent()) else { continue };
        let topic = format!("/agent_{number}/{}", Role::Controller.channel());
        let channel = network.channels.iter().position(|channel| channel.topic == topic).map(ChannelId);
        let Some(channel) = channel else { continue };
        let mut outputs = Vec::new();
        if robot.is_free() {
            outputs.push(ChannelId(network.channels.len()));
            let topic = format!("/agent_{number}/{}", health::CHANNEL);
            network.channels.push(Channel { topic, agent: number, layout: health::layout(), initial: Vec::new() });
        }
        let inputs = vec![Input { channel, timing: Timing::SameStep }];
        network.nodes.push(Node { name: hand_of(number), inputs, outputs, every: 1, offset: 0 });
    }
    network
}

/// Name of the second node of the bridge of an agent.
fn hand_of(number: u32) -> String {
    format!("hardware_{number}")
}

/// Gives the second nodes to the workers that are bridges.
pub(crate) fn place_hands(network: &Network, workers: &mut [WorkerPlan], swaps: &[Swap]) {
    // The same agent may have a controller of the user, too, which is no bridge.
    for (swap, number) in swaps.iter().filter_map(|swap| Some((swap, swap.robot().and(swap.agent())?))) {
        let hand = network.nodes.iter().position(|node| node.name == hand_of(number));
        let worker = workers.iter_mut().find(|worker| worker.name == swap.node);
        if let (Some(hand), Some(worker)) = (hand, worker) {
            worker.nodes.push(hand);
        }
    }
}

impl Robots {
    /// The command of the bridge to the robot of a swap; starts its emulator first, if it is to have one. `directory` is that
    /// of the run.
    ///
    /// # Errors
    /// [`Failure`] if the emulator does not start, or a file cannot be written.
    pub(crate) fn bridge(
        &mut self,
        program: &Path,
        directory: &Path,
        swap: &Swap,
        priority: Priority,
    ) -> Result<Command, Failure> {
        let number = swap.agent().unwrap_or(0);
        let settings = match swap.robot() {
            Some(RobotSwap::There { settings, .. }) => (**settings).clone(),
            Some(RobotSwap::Emulated(clock)) => {
                let robot = self.start(program, directory, number, priority)?;
                let any = SocketAddr::from((Ipv4Addr::LOCALHOST, 0));
                Settings { clock: *clock, ..Settings::new(robot, any, number) }
            }
            None => return Ok(swap.command(program).unwrap_or_else(|| Command::new(program))),
        };
        let path = directory.join(format!("robot_{number}.toml"));
        std::fs::write(&path, settings.to_toml()).map_err(Failure::system(format!("write {}", path.display())))?;
        let mut command = Command::new(program);
        command.arg("bridge").arg(path);
        Ok(command)
    }

    fn start(
        &mut self,
        program: &Path,
        directory: &Path,
        number: u32,
        priority: Priority,
    ) -> Result<SocketAddr, Failure> {
        let failed = || Failure::system(format!("start the emulator of robot {number}"));
        let mut command = Command::new(program);
        command.args(["robot", "--quiet", "--attached", "--agent", &number.to_string(), "--scenario"]);
        command.arg(directory.join(SCENARIO_FILE));
        priority.apply(&mut command);
        // Its stdin stays open as long as this process lives. A Ctrl-C at the terminal is for this process alone.
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).process_group(0);
        let mut emulator = command.spawn().map_err(failed())?;
        let stdout = emulator.stdout.take();
        self.emulators.push(emulator);
        let mut line = String::new();
        if let Some(stdout) = stdout {
            BufReader::new(stdout).read_line(&mut line).map_err(failed())?;
        }
        let address = line.split_once(LISTENS).and_then(|(_, address)| address.trim().parse().ok());
        address.ok_or_else(|| failed()(std::io::Error::other("it ended before it listened; its words are above")))
    }
}

/// Whether everything that the swaps need is available.
///
/// # Errors
/// [`Failure::Usage`].
pub(crate) fn check(swaps: &[Swap], assembly: &Assembly, pace: Option<f64>) -> Result<(), Failure> {
    for swap in swaps {
        let Some(robot) = swap.robot() else { continue };
        if robot.is_free() && pace != Some(1.0) {
            let name = &swap.node;
            return Err(Failure::Usage(format!(
                "{name} is a robot for which time passes by itself: add --realtime (or use an emulator in lockstep: \
                 `emulator`, or `clock = \"lockstep\"` in its file)"
            )));
        }
        let emulated = matches!(robot, RobotSwap::Emulated(_));
        let agents = &assembly.scenario.context.agents;
        let vehicle = swap.agent().and_then(|number| agents.get(number as usize - 1)).map(|agent| &agent.vehicle);
        if emulated && !vehicle.is_some_and(plant::laboratory::is_emulated) {
            return Err(Failure::Usage(format!(
                "{} cannot be emulated: there is a model of robots with wheel speeds only (omni, order 1)",
                swap.node
            )));
        }
    }
    Ok(())
}

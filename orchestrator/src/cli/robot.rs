//! Arguments of the robot emulator.

use std::net::SocketAddr;
use std::path::PathBuf;

use clap::Args;

#[derive(Debug, Args)]
#[command(after_help = "\
Two ways to say which robot it is:
  phalanx robot robot2.toml                            the file has a section [emulator]
  phalanx robot --scenario compensated --agent 2       a robot of a scenario; prints the address at which it listens
The controller decides whether time passes by itself or with its commands (clock in robot.toml).")]
pub(crate) struct RobotArgs {
    /// A robot.toml with a section [emulator]
    #[arg(required_unless_present = "scenario", conflicts_with = "scenario")]
    pub(crate) file: Option<PathBuf>,
    /// Name of a shipped scenario or path of a scenario file: vehicle, start and disturbance are those of its agent
    #[arg(long, requires = "agent")]
    pub(crate) scenario: Option<String>,
    /// Number of the agent, from 1; also the number of the robot
    #[arg(long, requires = "scenario")]
    pub(crate) agent: Option<u32>,
    /// Variant of the scenario
    #[arg(long, requires = "scenario")]
    pub(crate) variant: Option<String>,
    /// Change a field of the scenario: --set NAME=VALUE; may be repeated
    #[arg(long = "set", value_name = "NAME=VALUE", requires = "scenario")]
    pub(crate) set: Vec<String>,
    /// The same for a field that only some variants have: in the others it does nothing
    #[arg(long, value_name = "NAME=VALUE", requires = "scenario")]
    pub(crate) set_if_present: Vec<String>,
    /// TCP address at which it listens for its controller; port 0 takes any
    #[arg(long, default_value = "127.0.0.1:0", conflicts_with = "file")]
    pub(crate) listen: SocketAddr,
    /// Write the true poses, which no controller sees, as CSV: t, x, y, theta, v1, v2, v3 at every tick
    #[arg(long, value_name = "FILE.csv")]
    pub(crate) record: Option<PathBuf>,
    /// Do not tell who connects and why it halts
    #[arg(short, long)]
    pub(crate) quiet: bool,
    /// End when stdin is closed
    #[arg(long, hide = true)]
    pub(crate) attached: bool,
}

//! `phalanx bridge`: the process of a run that stands for a robot.

use std::path::Path;
use std::process::ExitCode;

use formation::config::Problem;
use formation::wiring::{Refusal, Role, pair};
use hardware::settings::Settings;
use processes::serve;

use crate::run::priority::lock_memory_if_wanted;

/// Connects to the robot that the file describes, and serves.
pub(crate) fn bridge(path: &Path) -> ExitCode {
    lock_memory_if_wanted();
    serve(pair(Role::Plant, |context, agent, poses, commands| {
        let first = |problems: Vec<Problem>| Refusal(problems.first().map(Problem::to_string).unwrap_or_default());
        let settings = Settings::load(path).map_err(first)?;
        hardware::participants(&settings, context, agent, poses, commands)
    }))
}

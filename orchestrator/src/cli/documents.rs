//! What the command line says about itself, as documents.

use clap::CommandFactory;

use super::Cli;
use crate::failure::EXIT_CODES;

/// How editors come by the schema.
pub(super) const SCHEMA_HELP: &str = "\
Editors complete and check fields with it while one types. With Even Better TOML in VS Code, or any other editor that uses
Taplo, a scenario names its schema in its first line:
  #:schema ./scenario.schema.json

Example:
  phalanx schema > scenario.schema.json";

/// What stands below the list of commands.
pub(super) fn after_help() -> String {
    format!(
        "First steps:\n  phalanx list                        what there is\n  phalanx run uav                     \
         six quadcopters in 15 processes\n  phalanx report runs/uav-TSC.mcap    what they did, in a browser\n\n{EXIT_CODES}"
    )
}

/// The whole command line.
pub(super) fn program() -> clap::Command {
    Cli::command().term_width(100)
}

/// Every command with all its options, as a page of the documentation. (Markdown)
pub fn reference() -> String {
    let mut page = String::from(
        "# Every command\n\nWhat `phalanx COMMAND --help` prints, in one place. `phalanx completions SHELL` writes completions for \
         bash, zsh, fish, elvish and PowerShell,\n`phalanx man FOLDER` manual pages.\n",
    );
    let program = program().disable_help_subcommand(true);
    page.push_str(&section(program.clone(), 2, "phalanx"));
    for command in program.get_subcommands().filter(|command| !command.is_hide_set()) {
        let name = format!("phalanx {}", command.get_name());
        page.push_str(&section(command.clone(), 2, &name));
        for inner in command.get_subcommands() {
            page.push_str(&section(inner.clone(), 3, &format!("{name} {}", inner.get_name())));
        }
    }
    page
}

/// The help of a command under a heading.
fn section(command: clap::Command, level: usize, name: &str) -> String {
    let mut command = command.bin_name(name).term_width(100).disable_help_flag(true);
    let help = command.render_long_help().to_string();
    let lines: Vec<&str> = help.lines().map(str::trim_end).collect();
    format!("\n{} {name}\n\n```text\n{}\n```\n", "#".repeat(level), lines.join("\n").trim_end())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::commands::man::{ManArgs, man};

    #[test]
    fn every_command_that_is_shown_is_described() {
        let shown = program().get_subcommands().filter(|command| !command.is_hide_set()).cloned().collect::<Vec<_>>();
        let lacking: Vec<&str> =
            shown.iter().filter(|one| one.get_about().is_none()).map(|one| one.get_name()).collect();
        assert!(shown.len() > 20 && lacking.is_empty(), "without a description: {lacking:?}");
    }

    #[test]
    fn every_command_has_a_manual_page() {
        let folder = std::env::temp_dir().join(format!("phalanx-man-{}", std::process::id()));
        man(&ManArgs { folder: folder.clone() }, program()).unwrap();
        let mut commands: Vec<String> = program()
            .get_subcommands()
            .filter(|c| !c.is_hide_set())
            .map(|c| format!("phalanx-{}.1", c.get_name()))
            .collect();
        commands.push("phalanx.1".into());
        for page in commands {
            let text = std::fs::read_to_string(folder.join(&page)).unwrap_or_else(|error| panic!("{page}: {error}"));
            assert!(text.contains(".SH NAME") && text.contains(".SH SYNOPSIS"), "{page}");
        }
        std::fs::remove_dir_all(folder).unwrap();
    }
}

//! `phalanx layout`.

use std::path::{Path, PathBuf};

use clap::Args;

use super::arguments::ScenarioArgs;
use super::select::assemble;
use crate::catalog::Catalog;
use crate::failure::Failure;
use crate::files;
use crate::show::layouts::Viewer;
use crate::show::layouts::layout as write_layout;
use recording::Log;

#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  phalanx layout runs/uav-TSC.mcap --for foxglove
  phalanx layout uav --for plotjuggler --out uav.xml")]
pub(crate) struct LayoutArgs {
    /// A log that `phalanx run` recorded, or a scenario that is yet to run
    #[arg(value_name = "LOG.mcap|SCENARIO")]
    pub(crate) run: String,
    /// For which viewer
    #[arg(long = "for", value_enum, value_name = "VIEWER")]
    pub(crate) viewer: Viewer,
    /// Variant of the scenario
    #[arg(long)]
    pub(crate) variant: Option<String>,
    /// Where the layout goes [default: beside the log, or here: <LOG>-<VIEWER>.json, .xml, .py]
    #[arg(long, value_name = "FILE")]
    pub(crate) out: Option<PathBuf>,
}

pub(crate) fn layout(catalog: &Catalog, args: &LayoutArgs) -> Result<(), Failure> {
    let path = Path::new(&args.run);
    let (text, stem) = if path.extension().is_some_and(|extension| extension == "mcap") {
        if args.variant.is_some() {
            return Err(Failure::Usage("a log has its variant already; leave out --variant".into()));
        }
        let log = Log::open(path)?;
        let channels = log
            .channels()
            .iter()
            .filter_map(|channel| Some((channel.topic.as_str(), channel.agent, channel.layout.as_ref()?)));
        (write_layout(args.viewer, channels, &args.run), path.with_extension(""))
    } else {
        let scenario =
            ScenarioArgs { scenario: args.run.clone(), variant: args.variant.clone(), ..ScenarioArgs::default() };
        let assembly = assemble(catalog, &scenario)?;
        let name = super::run::default_log(&assembly, &[]);
        let channels = assembly.network.channels.iter().map(|c| (c.topic.as_str(), c.agent, &c.layout));
        let stem = name.file_stem().map(PathBuf::from).unwrap_or_default();
        (write_layout(args.viewer, channels, &name.display().to_string()), stem)
    };
    let out = args.out.clone().unwrap_or_else(|| {
        let mut name = stem.into_os_string();
        name.push(ending(args.viewer));
        name.into()
    });
    files::spare(&out, [path])?;
    files::write(&out, text).map_err(Failure::system(format!("write {}", out.display())))?;
    println!("{}", out.display());
    println!("{}", usage(args.viewer, &out.display().to_string()));
    Ok(())
}

fn ending(viewer: Viewer) -> &'static str {
    match viewer {
        Viewer::Foxglove => "-foxglove.json",
        Viewer::Lichtblick => "-lichtblick.json",
        Viewer::Plotjuggler => "-plotjuggler.xml",
        Viewer::Rerun => "-rerun.py",
    }
}

/// What to do with the file.
fn usage(viewer: Viewer, out: &str) -> String {
    match viewer {
        Viewer::Foxglove | Viewer::Lichtblick => "open the log, then Layout > Import from file".into(),
        Viewer::Plotjuggler => {
            "open the log, then File > Load layout; or `plotjuggler -d LOG.mcap -l ".to_string() + out + "`"
        }
        Viewer::Rerun => format!("`pip install rerun-sdk phalanx`, then `python3 {out}` opens the log with it"),
    }
}

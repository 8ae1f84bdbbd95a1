//! `phalanx report`.

use std::path::{Path, PathBuf};

use clap::Args;

use crate::catalog::Catalog;
use crate::failure::Failure;
use crate::files;
use crate::show::figures::FigureOptions;
use crate::show::view::LoggedRun;
use crate::show::{figures, report};
use crate::terminal::program;

#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  phalanx report runs/uav-TSC.mcap
  phalanx report runs/uav-TSC.mcap runs/uav-TOC.mcap --out both.html
  phalanx report runs/uav-*.mcap --figures figures --format pdf
  phalanx report runs/uav-TSC.mcap --figures figures --font times --font-size 9")]
pub(crate) struct ReportArgs {
    /// Logs that `phalanx run` recorded; several are compared
    #[arg(required = true)]
    pub(crate) logs: Vec<PathBuf>,
    /// Where the report goes [default: <LOG>.html beside the log, or comparison.html]
    #[arg(long, value_name = "FILE.html", conflicts_with = "figures")]
    pub(crate) out: Option<PathBuf>,
    /// Write figures for a paper into this folder instead of a report: those of the thesis by their numbers, and all plots of each
    /// run
    #[arg(long, value_name = "FOLDER")]
    pub(crate) figures: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) look: FigureOptions,
}

pub(crate) fn report(catalog: &Catalog, args: &ReportArgs) -> Result<(), Failure> {
    let runs = args.logs.iter().map(|log| LoggedRun::open(catalog, log)).collect::<Result<Vec<_>, _>>()?;
    if let Some(folder) = &args.figures {
        return write_figures(catalog, &runs, folder, &args.look);
    }
    let out = args.out.clone().unwrap_or_else(|| default_out(&args.logs));
    files::spare(&out, &args.logs)?;
    let html = report::html(&runs);
    files::write(&out, &html).map_err(Failure::system(format!("write the report {}", out.display())))?;
    println!("{} ({:.1} MB): open it in a browser, it needs nothing else.", out.display(), html.len() as f64 / 1e6);
    Ok(())
}

fn write_figures(catalog: &Catalog, runs: &[LoggedRun], folder: &Path, options: &FigureOptions) -> Result<(), Failure> {
    let (mut written, missing) = figures::write_published(catalog, runs, folder, options)?;
    for run in runs {
        // Plots of one run must not replace those of another.
        let mark = if runs.len() > 1 { run.stem() } else { String::new() };
        written.extend(figures::write(run, folder, &mark, options)?);
    }
    for path in written {
        println!("{}", path.display());
    }
    for figures::Missing { number, scenario, variants } in missing {
        let run = |variant: &String| format!("`{} run {scenario} --variant {variant}`", program());
        eprintln!("figure {number} needs also {}", variants.iter().map(run).collect::<Vec<_>>().join(", "));
    }
    Ok(())
}

fn default_out(logs: &[PathBuf]) -> PathBuf {
    match logs {
        [one] => one.with_extension("html"),
        [first, ..] => first.with_file_name("comparison.html"),
        [] => Path::new("report.html").into(),
    }
}

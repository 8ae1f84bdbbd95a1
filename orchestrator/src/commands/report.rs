//! `phalanx report`.

use std::path::{Path, PathBuf};

use crate::cli::ReportArgs;
use crate::failure::Failure;
use crate::view::Subject;
use crate::{figures, report};

pub(crate) fn report(args: &ReportArgs) -> Result<(), Failure> {
    if let Some(folder) = &args.figures {
        for log in &args.logs {
            let subject = Subject::open(log)?;
            // Figures of one run must not replace those of another.
            let mark = if args.logs.len() > 1 { subject.stem() } else { String::new() };
            let written = figures::write(&subject, folder, &mark, args.format)?;
            for path in written {
                println!("{}", path.display());
            }
        }
        return Ok(());
    }
    let subjects = args.logs.iter().map(|log| Subject::open(log)).collect::<Result<Vec<_>, _>>()?;
    let out = args.out.clone().unwrap_or_else(|| default_out(&args.logs));
    let html = report::html(&subjects);
    std::fs::write(&out, &html).map_err(Failure::system(format!("write the report {}", out.display())))?;
    println!("{} ({:.1} MB): open it in a browser, it needs nothing else.", out.display(), html.len() as f64 / 1e6);
    Ok(())
}

fn default_out(logs: &[PathBuf]) -> PathBuf {
    match logs {
        [one] => one.with_extension("html"),
        [first, ..] => first.with_file_name("comparison.html"),
        [] => Path::new("report.html").into(),
    }
}

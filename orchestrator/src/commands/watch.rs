//! `phalanx watch`.

use std::io::IsTerminal;
use std::process::{Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering::SeqCst};
use std::thread;
use std::time::{Duration, Instant};

use clap::Args;
use processes::RunDirectory;
use serde_json::json;

use super::arguments::RunName;
use super::select_run::{choose, no_such_run};
use crate::catalog::Catalog;
use crate::failure::Failure;
use crate::run::control::{Request, State, Status, ask};
use crate::show::report;
use crate::show::watch::{LiveStatus, NoPast, RunMonitor, Screen, Web};
use crate::terminal::program;

/// Time between two frames: 30 a second.
const FRAME: Duration = Duration::from_nanos(1_000_000_000 / 30);
/// Time between two questions to the run.
const QUESTION: Duration = Duration::from_millis(250);
/// Time between two looks for a run to begin.
const LOOK: Duration = Duration::from_millis(20);
/// How long a run that is named may take until it is there: it may have been started a moment ago.
const NAMED_PATIENCE: Duration = Duration::from_secs(3);

#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  phalanx run uav --realtime &   then   phalanx watch
  phalanx watch --web            waits for a run if none is going on
  phalanx watch uav-2 --web --port 9000

The run does not wait for viewers. Steps between two updates of the view are only in the log.")]
pub(crate) struct WatchArgs {
    #[command(flatten)]
    pub(crate) run: RunName,
    /// Show it in a browser on this machine: the formation in motion and all plots, as in a report
    #[arg(long)]
    pub(crate) web: bool,
    /// Port of the page [default: 8467 if it is free, else any]
    #[arg(long, requires = "web", value_parser = clap::value_parser!(u16).range(1..))]
    pub(crate) port: Option<u16>,
    /// Only print where the page is, open no browser
    #[arg(long, requires = "web")]
    pub(crate) no_open: bool,
}

pub(crate) fn watch(catalog: &Catalog, args: &WatchArgs) -> Result<(), Failure> {
    let leave = Arc::new(AtomicBool::new(false));
    let asked = leave.clone();
    ctrlc::set_handler(move || asked.store(true, SeqCst))
        .map_err(|error| Failure::system("listen for Ctrl-C")(std::io::Error::other(error)))?;
    let Some((run, status)) = find(args.run.name.as_deref(), &leave)? else { return Ok(()) };
    // The only process of a run that has no others.
    let single = status.processes == 1;
    if single && args.web {
        return Err(Failure::Usage(format!(
            "the run {run} is one process (--placement single), whose samples cannot be seen from outside; run it with \
             --placement processes or agents, or make a report of its log"
        )));
    }
    let monitor = if single { None } else { Some(RunMonitor::join(catalog, &run, status.log.as_deref())?) };
    let web = match &monitor {
        Some(monitor) if args.web => {
            let no_past = monitor.no_past.as_ref().map(NoPast::to_string);
            Some(Web::start(args.port, monitor.history(), monitor.duration, no_past)?)
        }
        _ => None,
    };
    if let Some(web) = &web {
        println!("The run {run}, live: {}", web.url());
        if !args.no_open {
            open(&web.url());
        }
    }
    let mut view = View { run, monitor, web, status, told: None };
    let over = view.follow(&leave);
    view.conclude(over, &leave);
    Ok(())
}

/// The run that is meant, with its status, once its processes are there; waits for one to begin unless a name is given.
/// `None` if Ctrl-C came first.
///
/// # Errors
/// [`Failure::Usage`] if there is no run of that name, or no name and several runs.
fn find(name: Option<&str>, leave: &AtomicBool) -> Result<Option<(String, Status)>, Failure> {
    let start = Instant::now();
    let mut said = false;
    while !leave.load(SeqCst) {
        let runs = RunDirectory::list()?;
        let there = name.map_or(!runs.is_empty(), |name| runs.iter().any(|run| run == name));
        if there {
            let run = choose(name)?;
            // One that is over again is as good as none.
            if let Ok(status) = ask(&run, &Request::Status)
                && status.state != State::Starting
            {
                return Ok(Some((run, status)));
            }
        } else if let Some(name) = name.filter(|_| start.elapsed() > NAMED_PATIENCE) {
            return Err(Failure::Usage(no_such_run(name, &runs)));
        } else if name.is_none() && !said {
            eprintln!("waiting for a run to begin: {} run SCENARIO; Ctrl-C leaves", program());
            said = true;
        }
        thread::sleep(LOOK);
    }
    Ok(None)
}

struct View {
    run: String,
    monitor: Option<RunMonitor>,
    web: Option<Web>,
    /// The last answer of the run.
    status: Status,
    /// How the run went between the last two answers.
    told: Option<LiveStatus>,
}

impl View {
    /// Shows the run until it is over; whether it is.
    fn follow(&mut self, leave: &AtomicBool) -> bool {
        let page = self.web.as_ref().map(|web| format!("{}   ", web.url())).unwrap_or_default();
        let mut screen = Screen::new(&format!("{page}Ctrl-C leaves; the run continues."));
        if let Some(errors) = self.monitor.as_ref().and_then(RunMonitor::past_errors) {
            screen.note(&errors);
        }
        let mut question = Instant::now() + QUESTION;
        while !leave.load(SeqCst) {
            let start = Instant::now();
            // Asked first, so that the last look comes after the last step.
            let over = self.is_over();
            self.look(&mut screen);
            if over {
                return true;
            }
            if start >= question {
                self.ask();
                question = start + QUESTION;
                if let Some(status) = self.told.as_ref().filter(|_| screen.is_due()) {
                    screen.show(status);
                }
            }
            thread::sleep(FRAME.saturating_sub(start.elapsed()));
        }
        false
    }

    fn is_over(&self) -> bool {
        match &self.monitor {
            Some(monitor) => monitor.is_over(),
            None => !RunDirectory::list().is_ok_and(|runs| runs.contains(&self.run)),
        }
    }

    fn look(&mut self, screen: &mut Screen) {
        let Some(monitor) = self.monitor.as_mut() else { return };
        if !monitor.look() {
            return;
        }
        if let Some(errors) = monitor.errors() {
            screen.note(&errors);
        }
        if let (Some(web), Some(now)) = (&self.web, monitor.now())
            && web.is_watched()
        {
            web.send("frame", &report::frame(now));
        }
    }

    fn ask(&mut self) {
        // A run that does not answer is about to end, or busy; the next question will tell.
        let Ok(now) = ask(&self.run, &Request::Status) else { return };
        let status = LiveStatus::of(Some(&self.status), &now);
        if let Some(web) = &self.web {
            let waiting = status.waiting();
            let text = if waiting.is_empty() { status.sentence() } else { format!("{}; {waiting}", status.sentence()) };
            web.send("status", &json!({ "text": text }));
        }
        self.told = Some(status);
        self.status = now;
    }

    /// Says how it ended, in the terminal and to the browsers.
    fn conclude(&self, over: bool, leave: &AtomicBool) {
        let Status { dt, of, .. } = self.status;
        let seen = self.monitor.as_ref().and_then(RunMonitor::newest);
        let text = match (over, seen) {
            (false, _) => format!("Left; the run {} continues.", self.run),
            (_, Some(step)) if step + 1 == of => format!("The run {} is over: all {of} steps are done.", self.run),
            (_, Some(step)) => {
                let time = step as f64 * dt;
                format!("The run {} is over. It ended early, at step {step} of {}, t = {time} s.", self.run, of - 1)
            }
            (_, None) => format!("The run {} is over.", self.run),
        };
        println!("{text}");
        let Some(web) = &self.web else { return };
        let last = self.monitor.as_ref().and_then(RunMonitor::now).map(report::frame);
        if web.end(&text, last) || !over {
            return;
        }
        println!("The page stays at {} until a browser has shown it; Ctrl-C ends it.", web.url());
        while !web.is_done() && !leave.load(SeqCst) {
            thread::sleep(QUESTION);
        }
    }
}

/// Opens a browser, if there is a desktop.
fn open(url: &str) {
    let desktop = ["DISPLAY", "WAYLAND_DISPLAY"].iter().any(|name| std::env::var_os(name).is_some());
    if desktop && std::io::stdout().is_terminal() {
        let mut command = Command::new("xdg-open");
        // The address has been printed and can be copied.
        let _ = command.arg(url).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null()).spawn();
    }
}

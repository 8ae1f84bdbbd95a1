//! The state of a run on one screen of the terminal; as plain lines where stdout is not a terminal.

use std::io::{IsTerminal, Write};
use std::time::{Duration, Instant};

use super::curves::Curves;
use super::sparkline::range;
use super::{Errors, LiveStatus};
use crate::terminal::{counted, plain, size_of};

/// Time between two screens, and between two plain lines.
const SCREEN_EVERY: Duration = Duration::from_millis(250);
const LINE_EVERY: Duration = Duration::from_secs(2);
/// Share of a run that is hardly seen: curves that begin earlier begin with the run.
const HARDLY: f64 = 0.01;

/// Shows a run on stdout.
pub(crate) struct Screen {
    terminal: Option<Terminal>,
    next: Instant,
    curves: Curves,
    /// The last line.
    footer: String,
}

/// The terminal gets its own screen and its cursor back when this is dropped.
struct Terminal {
    blocks: bool,
    colour: bool,
}

impl Screen {
    /// A screen, if stdout is a terminal that can have one. `footer` is its last line.
    pub(crate) fn new(footer: &str) -> Self {
        let dumb = std::env::var_os("TERM").is_none_or(|term| term == "dumb");
        let terminal = (std::io::stdout().is_terminal() && !dumb).then(Terminal::take);
        Self { terminal, next: Instant::now(), curves: Curves::default(), footer: footer.into() }
    }

    /// Keeps tracking errors.
    pub(crate) fn note(&mut self, errors: &Errors) {
        self.curves.extend(errors);
    }

    /// Whether it is time for the next picture.
    pub(crate) fn is_due(&self) -> bool {
        Instant::now() >= self.next
    }

    /// Shows the state of the run. An error of stdout is ignored: its reader has closed it.
    pub(crate) fn show(&mut self, status: &LiveStatus) {
        let mut out = std::io::stdout().lock();
        let (text, every) = match &self.terminal {
            None => (format!("{}\n", plain(&self.line(status))), LINE_EVERY),
            Some(terminal) => {
                let (width, height) = size_of(std::io::stdout()).unwrap_or((80, 24));
                let lines = self.lines(status, terminal, width, height);
                let lines: Vec<String> = lines.iter().map(|line| format!("{line}\x1b[K")).collect();
                (format!("\x1b[H{}\x1b[J", lines.join("\r\n")), SCREEN_EVERY)
            }
        };
        self.next = Instant::now() + every;
        let _ = out.write_all(text.as_bytes()).and_then(|()| out.flush());
    }

    fn line(&self, status: &LiveStatus) -> String {
        let mut line = status.sentence();
        let now = self.curves.values().filter_map(|list| list.last()).copied().enumerate();
        if let Some((agent, error)) = now.max_by(|a, b| a.1.total_cmp(&b.1)) {
            line.push_str(&format!(", largest error {error:.1e} {} (agent {})", self.curves.unit(), agent + 1));
        }
        let waiting = status.waiting();
        if waiting.is_empty() { line } else { format!("{line}; {waiting}") }
    }

    /// The screen as lines that fit.
    fn lines(&self, status: &LiveStatus, terminal: &Terminal, width: usize, height: usize) -> Vec<String> {
        let processes = counted(status.processes as usize, "process");
        let mut lines = vec![
            terminal.strong(&cut(&plain(&format!("{}: run {}, {processes}", status.title, status.run)), width)),
            terminal.bar(status.share(), width),
            cut(&plain(&status.sentence()), width),
            cut(&plain(&status.waiting()), width),
        ];
        let room = height.saturating_sub(lines.len() + 4);
        if self.curves.agents() > 0 && room > 0 {
            let limits = range(self.curves.values());
            lines.push(String::new());
            lines.push(terminal.faint(&cut(&self.heading(status, limits), width)));
            // Of more agents than there are lines, those that are worst.
            let latest: Vec<f64> = self.curves.values().map(|list| list.last().copied().unwrap_or(0.0)).collect();
            let mut agents: Vec<usize> = (0..latest.len()).collect();
            if agents.len() > room {
                agents.sort_by(|a, b| latest[*b].total_cmp(&latest[*a]));
                agents.truncate(room);
                agents.sort_unstable();
            }
            for agent in agents {
                let line = self.curves.line(agent, width.saturating_sub(17), limits, terminal.blocks);
                let head = cut(&format!("{:>5}  {:>7.1e}  ", agent + 1, latest[agent]), width);
                lines.push(format!("{head}{}", terminal.accent(&line)));
            }
        }
        if lines.len() + 2 <= height {
            lines.push(String::new());
            lines.push(terminal.faint(&cut(&self.footer, width)));
        }
        lines.truncate(height);
        lines
    }
}

impl Screen {
    /// What the curves show: from when on, and on which scale.
    fn heading(&self, status: &LiveStatus, limits: [f64; 2]) -> String {
        let start = self.curves.start();
        let since = if start <= HARDLY * status.duration {
            "since the start of the run".into()
        } else {
            format!("since t = {start:.2} s, when `watch` began")
        };
        let scale = format!("{:.0e} to {:.0e} {}", limits[0], limits[1], self.curves.unit());
        format!("agent    error  {since}, logarithmic, {scale}")
    }
}

impl Terminal {
    fn take() -> Self {
        let blocks = ["LC_ALL", "LC_CTYPE", "LANG"].into_iter().filter_map(|name| std::env::var(name).ok());
        let locale = blocks.into_iter().find(|value| !value.is_empty()).unwrap_or_default().to_ascii_lowercase();
        let colour = std::env::var_os("NO_COLOR").is_none_or(|value| value.is_empty());
        draw!("\x1b[?1049h\x1b[?25l");
        Self { blocks: locale.contains("utf-8") || locale.contains("utf8"), colour }
    }

    fn style(&self, code: &str, text: &str) -> String {
        if self.colour { format!("\x1b[{code}m{text}\x1b[0m") } else { text.into() }
    }

    fn strong(&self, text: &str) -> String {
        self.style("1", text)
    }

    fn faint(&self, text: &str) -> String {
        self.style("2", text)
    }

    fn accent(&self, text: &str) -> String {
        self.style("36", text)
    }

    fn bar(&self, share: f64, width: usize) -> String {
        let done = (share.clamp(0.0, 1.0) * width as f64) as usize;
        let [full, empty] = if self.blocks { ["█", "░"] } else { ["#", "."] };
        format!("{}{}", self.accent(&full.repeat(done)), self.faint(&empty.repeat(width - done)))
    }
}

impl Drop for Terminal {
    fn drop(&mut self) {
        let mut out = std::io::stdout().lock();
        let _ = out.write_all(b"\x1b[?25h\x1b[?1049l").and_then(|()| out.flush());
    }
}

/// At most `width` characters of a text.
fn cut(text: &str, width: usize) -> String {
    text.chars().take(width).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn screen(agents: usize) -> Screen {
        let values = (1..=agents).map(|agent| vec![1.0, 0.1 * agent as f64]).collect();
        let mut curves = Curves::default();
        curves.extend(&Errors { times: vec![0.0, 5.0], values, unit: "m".into() });
        Screen { terminal: None, next: Instant::now(), curves, footer: "Ctrl-C leaves".into() }
    }

    fn status() -> LiveStatus {
        let last = vec![("controller_3".to_string(), 0.5)];
        LiveStatus {
            title: "uav TSC".into(),
            run: "uav".into(),
            steps: 500,
            of: 1001,
            duration: 10.0,
            last,
            ..LiveStatus::default()
        }
    }

    #[test]
    fn every_screen_fits_its_terminal() {
        let terminal = std::mem::ManuallyDrop::new(Terminal { blocks: false, colour: false });
        for (width, height) in [(80, 24), (20, 5), (5, 2), (200, 60), (1, 1), (40, 8)] {
            let lines = screen(30).lines(&status(), &terminal, width, height);
            assert!(lines.len() <= height, "{height}: {lines:#?}");
            assert!(lines.iter().all(|line| line.chars().count() <= width.max(17)), "{width}: {lines:#?}");
        }
        let lines = screen(6).lines(&status(), &terminal, 80, 24).join("\n");
        let slowest = "slowest participants: controller_3 (last in 50 % of its steps)";
        for word in
            ["uav TSC: run uav", "####", slowest, "since the start of the run", "    6   6.0e-1", "Ctrl-C leaves"]
        {
            assert!(lines.contains(word), "{word}: {lines}");
        }
        let wide = screen(1).lines(&status(), &terminal, 200, 24);
        assert!(wide.iter().any(|line| line.len() == 200), "{wide:#?}");
    }

    #[test]
    fn a_line_names_the_agent_that_is_worst() {
        assert!(
            screen(3).line(&status()).contains("largest error 3.0e-1 m (agent 3)"),
            "{}",
            screen(3).line(&status())
        );
    }
}

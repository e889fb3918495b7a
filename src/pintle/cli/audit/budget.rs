//! How long an audit takes: what it may, and what is left.

use crate::cli::tell::complain;
use indicatif::{HumanDuration, ProgressBar, ProgressStyle};
use pintle_audit::Progress;
use std::io::{self, IsTerminal};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// An estimate is told from so many seconds on.
const LONG: f64 = 5.0;

/// Where no bar can be drawn, a line is written so often.
const OFTEN: Duration = Duration::from_secs(10);

/// A time in seconds, as `60s`, `5m`, `2h` or `90`.
pub(super) fn seconds(text: &str) -> Result<f64, String> {
    let (number, unit) = match text.char_indices().next_back() {
        Some((at, 's')) => (&text[..at], 1.0),
        Some((at, 'm')) => (&text[..at], 60.0),
        Some((at, 'h')) => (&text[..at], 3600.0),
        _ => (text, 1.0),
    };
    let time = number.trim().parse::<f64>().map(|number| number * unit);
    let time = time.ok().filter(|time| time.is_finite() && *time > 0.0);
    time.ok_or_else(|| format!("{text} is no time: write 60s, 5m or 2h"))
}

/// Says that a budget was not enough, and what took the time: the models come first, and a sample has a least size.
pub(super) fn say_budget(budget: f64, models: Duration, all: Duration) {
    /// Beyond that part of it.
    const EXCEEDED: f64 = 1.1;
    if all.as_secs_f64() > EXCEEDED * budget {
        let [models, all] = [models, all].map(|time| format!("{:.1} s", time.as_secs_f64()));
        let rest = "reading and looking at the models took";
        complain("note", &format!("the budget of {budget} s was not enough: {all} in all; {rest} {models}"));
    }
}

/// What shows how far an audit is: a bar with the time left on a terminal, lines elsewhere.
pub(crate) struct Bar {
    bar: ProgressBar,
    said: Mutex<Instant>,
}

impl Bar {
    pub(crate) fn new() -> Self {
        let bar = ProgressBar::new(0);
        if let Ok(style) = ProgressStyle::with_template("{bar:30} {pos}/{len} {msg}, {eta} left") {
            bar.set_style(style);
        }
        Self { bar, said: Mutex::new(Instant::now()) }
    }

    /// Says what is done now.
    pub(super) fn say(&self, what: &str) {
        self.bar.set_message(what.to_string());
    }

    /// So much more is to be done.
    pub(crate) fn expect(&self, more: usize) {
        self.bar.inc_length(more as u64);
        self.bar.reset_eta();
    }

    /// So much more was done.
    pub(crate) fn advance(&self, more: usize, what: &str) {
        self.bar.inc(more as u64);
        self.bar.set_message(what.to_string());
        let mut said = self.said.lock().unwrap_or_else(PoisonError::into_inner);
        if !io::stderr().is_terminal() && said.elapsed() >= OFTEN {
            *said = Instant::now();
            let (done, all) = (self.bar.position(), self.bar.length().unwrap_or_default());
            let left = HumanDuration(self.bar.eta());
            complain("note", &format!("{done} of {all} {what}, about {left} left"));
        }
    }

    /// Shows how far the numbers of scenes are; what takes long is told before it begins.
    pub(super) fn hear(&self, at: Progress<'_>) {
        match at {
            Progress::Judged(more) => self.advance(more, "connector states judged"),
            Progress::Begins(share, seconds) => {
                self.expect(usize::try_from(share.states).unwrap_or(usize::MAX));
                let seconds = seconds.filter(|seconds| *seconds >= LONG);
                let Some(seconds) = seconds.or((!share.is_whole()).then_some(0.0)) else { return };
                let time = HumanDuration(Duration::from_secs_f64(seconds.max(1.0)));
                let what = match share.is_whole() {
                    true => format!("{} connector states", share.states),
                    false => format!(
                        "{} of {} connector states ({} of {} connectors and MPCs; --budget 2h judges more)",
                        share.states, share.of_states, share.connectors, share.of_connectors
                    ),
                };
                self.bar.suspend(|| complain("note", &format!("{}: {what}, about {time}", share.scene)));
            }
        }
    }

    pub(crate) fn finish(&self) {
        self.bar.finish_and_clear();
    }
}

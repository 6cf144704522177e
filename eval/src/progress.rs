//! Progress: a bar on a terminal, and few lines anywhere else.

use indicatif::{ProgressBar, ProgressStyle};
use std::collections::BTreeSet;
use std::io::{IsTerminal, Write};
use std::sync::{Arc, Condvar, Mutex, OnceLock, PoisonError};
use std::time::{Duration, Instant};

/// How much a process says of what it is about.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Loudness {
    /// Notes alone.
    Quiet,
    /// How far each stage is, too.
    #[default]
    Usual,
    /// Notes in full, too.
    Verbose,
}

static LOUDNESS: OnceLock<Loudness> = OnceLock::new();

impl Loudness {
    /// Makes it that of this process; the first call counts.
    pub fn apply(self) {
        LOUDNESS.get_or_init(|| self);
    }

    fn of_process() -> Self {
        LOUDNESS.get().copied().unwrap_or_default()
    }
}

/// Where progress is shown.
#[derive(Clone)]
pub struct Progress(Target);

#[derive(Clone)]
enum Target {
    Notes,
    Within { said: Arc<Mutex<BTreeSet<String>>>, outer: Option<Outer> },
    Bars,
    Lines { sink: Sink, pause: Duration },
}

type Sink = Arc<Mutex<dyn Write + Send>>;

/// The stage that others are within.
#[derive(Clone)]
struct Outer {
    name: String,
    total: u64,
    shown: Arc<Shown>,
}

/// Between two lines of one stage, whether steps are done or not.
const PAUSE: Duration = Duration::from_secs(20);

impl Progress {
    /// Bars where standard error is a terminal, lines on it otherwise; notes alone in a quiet process.
    pub fn detect() -> Self {
        if Loudness::of_process() == Loudness::Quiet {
            Self(Target::Notes)
        } else if std::io::stderr().is_terminal() {
            Self(Target::Bars)
        } else {
            Self::lines_to(std::io::stderr(), PAUSE)
        }
    }

    /// Notes alone, each of them once: for what is done again and again within a stage that is shown.
    pub fn notes_once() -> Self {
        Self(Target::Within { said: Arc::default(), outer: None })
    }

    /// The same for what is done within `stage`, whose bar or lines say how far that is, too.
    pub fn within(&self, stage: &Stage) -> Self {
        let said = match &self.0 {
            Target::Within { said, .. } => Arc::clone(said),
            _ => Arc::default(),
        };
        let outer = Outer { name: stage.name.clone(), total: stage.total, shown: Arc::clone(&stage.shown) };
        Self(Target::Within { said, outer: Some(outer) })
    }

    /// Lines on `sink`, one of a stage each `pause`, and its last.
    pub fn lines_to(sink: impl Write + Send + 'static, pause: Duration) -> Self {
        Self(Target::Lines { sink: Arc::new(Mutex::new(sink)), pause })
    }

    /// Whether notes are to be in full.
    pub fn is_verbose(&self) -> bool {
        Loudness::of_process() == Loudness::Verbose
    }

    /// Says a line, whatever stage is under way.
    pub fn note(&self, line: &str) {
        match &self.0 {
            Target::Notes | Target::Bars => say(line),
            Target::Within { said, .. } => {
                if said.lock().unwrap_or_else(PoisonError::into_inner).insert(line.to_owned()) {
                    say(line);
                }
            }
            Target::Lines { sink, .. } => print(sink, line),
        }
    }

    /// Starts a stage of `total` steps; it ends when dropped.
    pub fn stage(&self, name: &str, total: u64) -> Stage {
        let now = Instant::now();
        let shown = match &self.0 {
            Target::Notes | Target::Within { outer: None, .. } => Shown::Nowhere,
            Target::Within { outer: Some(outer), .. } => {
                Shown::Within { outer: outer.clone(), done: Mutex::new(0) }
            }
            Target::Bars => {
                let bar = ProgressBar::new(total).with_message(name.to_owned());
                if let Ok(style) = ProgressStyle::with_template(
                    "{msg:24} {bar:30} {pos}/{len}, {elapsed} so far, {eta} left",
                ) {
                    bar.set_style(style);
                }
                bar.enable_steady_tick(Duration::from_secs(1));
                Shown::Bar(bar)
            }
            Target::Lines { sink, pause } => Shown::Lines {
                sink: Arc::clone(sink),
                pause: *pause,
                state: Mutex::new(LineState { done: 0, last: now, ended: false }),
                end: Condvar::new(),
            },
        };
        let stage = Stage { name: name.to_owned(), total, start: now, shown: Arc::new(shown) };
        stage.beat();
        stage
    }
}

/// A stage under way. May be shared between threads.
pub struct Stage {
    name: String,
    total: u64,
    start: Instant,
    shown: Arc<Shown>,
}

enum Shown {
    Nowhere,
    Bar(ProgressBar),
    Lines { sink: Sink, pause: Duration, state: Mutex<LineState>, end: Condvar },
    Within { outer: Outer, done: Mutex<u64> },
}

struct LineState {
    done: u64,
    last: Instant,
    ended: bool,
}

impl Stage {
    /// Goes on saying how far a stage is whose steps take longer than the pause between lines.
    fn beat(&self) {
        let Shown::Lines { pause, .. } = &*self.shown else { return };
        if pause.is_zero() {
            return;
        }
        let (shown, name, total, start) =
            (Arc::clone(&self.shown), self.name.clone(), self.total, self.start);
        std::thread::spawn(move || {
            let Shown::Lines { sink, pause, state, end } = &*shown else { return };
            let mut state = state.lock().unwrap_or_else(PoisonError::into_inner);
            while !state.ended {
                let rest = pause.saturating_sub(state.last.elapsed());
                if rest.is_zero() {
                    state.last = Instant::now();
                    let seconds = start.elapsed().as_secs();
                    print(sink, &format!("{name}: {} of {total}, {seconds} s so far", state.done));
                } else {
                    state = end.wait_timeout(state, rest).unwrap_or_else(PoisonError::into_inner).0;
                }
            }
        });
    }

    /// Notes that `steps` more are done.
    pub fn advance(&self, steps: u64) {
        match &*self.shown {
            Shown::Nowhere => {}
            Shown::Bar(bar) => bar.inc(steps),
            Shown::Lines { sink, pause, state, .. } => {
                let mut state = state.lock().unwrap_or_else(PoisonError::into_inner);
                state.done += steps;
                if state.done < self.total && state.last.elapsed() >= *pause {
                    state.last = Instant::now();
                    print(sink, &format!("{}: {} of {}", self.name, state.done, self.total));
                }
            }
            Shown::Within { outer, done } => {
                let mut done = done.lock().unwrap_or_else(PoisonError::into_inner);
                *done += steps;
                outer.say(&format!("{}: {done} of {}", self.name, self.total));
            }
        }
    }
}

impl Outer {
    /// Says how far a stage within this one is.
    fn say(&self, within: &str) {
        match &*self.shown {
            Shown::Nowhere | Shown::Within { .. } => {}
            Shown::Bar(bar) => bar.set_message(format!("{}, {within}", self.name)),
            Shown::Lines { sink, pause, state, .. } => {
                let mut state = state.lock().unwrap_or_else(PoisonError::into_inner);
                if state.last.elapsed() >= *pause {
                    state.last = Instant::now();
                    print(sink, &format!("{}: {} of {}, {within}", self.name, state.done, self.total));
                }
            }
        }
    }
}

impl Drop for Stage {
    fn drop(&mut self) {
        let seconds = self.start.elapsed().as_secs_f64();
        match &*self.shown {
            Shown::Nowhere | Shown::Within { .. } => {}
            Shown::Bar(bar) => bar.finish_and_clear(),
            Shown::Lines { sink, state, end, .. } => {
                let mut state = state.lock().unwrap_or_else(PoisonError::into_inner);
                state.ended = true;
                end.notify_all();
                print(sink, &format!("{}: {} of {} in {seconds:.1} s", self.name, state.done, self.total));
            }
        }
    }
}

/// Says a line on standard error. That nobody reads it is no reason to stop.
pub fn say(line: &str) {
    let _ = writeln!(std::io::stderr(), "{line}");
}

/// A progress line that cannot be written is no reason to stop.
fn print(sink: &Mutex<dyn Write + Send>, line: &str) {
    let mut sink = sink.lock().unwrap_or_else(PoisonError::into_inner);
    let _ = writeln!(sink, "{line}");
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Clone, Default)]
    struct Written(Arc<Mutex<Vec<u8>>>);

    impl Write for Written {
        fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
            self.0.lock().unwrap().write(bytes)
        }

        fn flush(&mut self) -> std::io::Result<()> {
            Ok(())
        }
    }

    fn lines(pause: Duration) -> Vec<String> {
        let sink = Written::default();
        let stage = Progress::lines_to(sink.clone(), pause).stage("render", 4);
        std::thread::scope(|scope| {
            for _ in 0..4 {
                scope.spawn(|| stage.advance(1));
            }
        });
        drop(stage);
        let bytes = sink.0.lock().unwrap().clone();
        String::from_utf8(bytes).unwrap().lines().map(str::to_owned).collect()
    }

    #[test]
    fn without_a_terminal_a_short_stage_is_one_line() {
        let quiet = lines(Duration::from_secs(3600));
        assert_eq!(quiet.len(), 1);
        assert!(quiet[0].starts_with("render: 4 of 4 in "), "{quiet:?}");
    }

    #[test]
    fn a_long_stage_says_now_and_then_how_far_it_is() {
        let chatty = lines(Duration::ZERO);
        assert_eq!(chatty[..3], ["render: 1 of 4", "render: 2 of 4", "render: 3 of 4"]);
        assert_eq!(chatty.len(), 4);
    }

    #[test]
    fn a_long_step_does_not_look_like_a_hang() {
        let sink = Written::default();
        let stage = Progress::lines_to(sink.clone(), Duration::from_millis(1)).stage("render", 4);
        while sink.0.lock().unwrap().is_empty() {
            std::thread::yield_now();
        }
        drop(stage);
        let text = String::from_utf8(sink.0.lock().unwrap().clone()).unwrap();
        let first = text.lines().next().unwrap();
        assert!(first.starts_with("render: 0 of 4, ") && first.ends_with(" s so far"), "{text}");
        assert!(text.lines().last().unwrap().starts_with("render: 0 of 4 in "), "{text}");
    }

    #[test]
    fn a_stage_within_another_is_said_on_the_lines_of_that() {
        let sink = Written::default();
        let cells = Progress::lines_to(sink.clone(), Duration::ZERO).stage("cells", 2);
        let estimates = Progress::notes_once().within(&cells).stage("estimates", 2);
        estimates.advance(1);
        cells.advance(1);
        estimates.advance(1);
        drop(estimates);
        let bytes = sink.0.lock().unwrap().clone();
        let lines: Vec<&str> = std::str::from_utf8(&bytes).unwrap().lines().collect();
        assert_eq!(
            lines,
            ["cells: 0 of 2, estimates: 1 of 2", "cells: 1 of 2", "cells: 1 of 2, estimates: 2 of 2"]
        );
    }
}

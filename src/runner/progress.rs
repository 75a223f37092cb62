//! Progress for people, on standard error: a bar with rate and time left for each running job on a terminal, plain lines
//! where the output is none.

use std::collections::BTreeMap;
use std::io::{IsTerminal, Write};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use indicatif::{MultiProgress, ProgressBar, ProgressStyle};

use crate::document::visible::escaped;

use super::events::{Event, Listener};

/// Plain lines about one job come at most this often.
const LINE_INTERVAL: Duration = Duration::from_secs(10);

/// Shows a run's progress.
pub struct Progress {
    shown: Mutex<Shown>,
}

struct Shown {
    jobs: BTreeMap<String, Running>,
    out: Out,
}

enum Out {
    Bars(MultiProgress),
    Lines(Box<dyn Write + Send>),
}

struct Running {
    since: Instant,
    last_line: Instant,
    stage: String,
    blocks: u64,
    blocks_done: u64,
    /// When the stage began, and how many of its blocks were found rather than run: for the rate.
    stage_since: Instant,
    blocks_found: u64,
    bar: Option<ProgressBar>,
}

impl Progress {
    /// Progress on standard error, in the manner that fits it.
    pub fn on_standard_error() -> Self {
        if std::io::stderr().is_terminal() {
            Self::to(Out::Bars(MultiProgress::new()))
        } else {
            Self::lines_to(Box::new(std::io::stderr()))
        }
    }

    /// Plain lines to any writer.
    pub fn lines_to(writer: Box<dyn Write + Send>) -> Self {
        Self::to(Out::Lines(writer))
    }

    fn to(out: Out) -> Self {
        Self { shown: Mutex::new(Shown { jobs: BTreeMap::new(), out }) }
    }
}

impl Listener for Progress {
    fn hear(&self, event: &Event) {
        self.shown.lock().unwrap_or_else(PoisonError::into_inner).hear(event);
    }
}

impl Shown {
    fn hear(&mut self, event: &Event) {
        match event {
            Event::RunStarted { to_run, cached, threads } => {
                let line = format!(
                    "{} to run on {}, {cached} in the cache",
                    counted(*to_run as u64, "job"),
                    counted(*threads as u64, "thread")
                );
                self.line(&line);
            }
            Event::JobStarted { job, kind, .. } => {
                let now = Instant::now();
                let bar = match &self.out {
                    Out::Bars(bars) => Some(bars.add(new_bar(job))),
                    Out::Lines(_) => None,
                };
                let running = Running {
                    since: now,
                    last_line: now,
                    stage: String::new(),
                    blocks: 0,
                    blocks_done: 0,
                    stage_since: now,
                    blocks_found: 0,
                    bar,
                };
                self.jobs.insert(job.clone(), running);
                if matches!(self.out, Out::Lines(_)) {
                    self.line(&format!("{job}: started ({kind})"));
                }
            }
            Event::StageStarted { job, stage, blocks } => {
                let Some(running) = self.jobs.get_mut(job) else { return };
                running.stage.clone_from(stage);
                (running.blocks, running.blocks_done, running.blocks_found) = (*blocks as u64, 0, 0);
                running.stage_since = Instant::now();
                if let Some(bar) = &running.bar {
                    bar.reset();
                    bar.set_length(running.blocks);
                    bar.set_message(stage.clone());
                }
            }
            Event::BlockDone { job, cached, .. } => self.block_done(job, *cached),
            Event::Damaged { object } => {
                self.line(&format!("object {} of the cache is damaged; it is computed again", object.short()));
            }
            Event::NotStored { reason } => {
                self.line(&format!("warning: not all results are kept in the cache: {reason}"));
            }
            Event::JobFinished { job, blocks_run, blocks_cached, .. } => {
                let found = if *blocks_cached > 0 { format!(", {blocks_cached} found") } else { String::new() };
                let elapsed_s = self.close(job);
                let blocks = counted(*blocks_run as u64, "block");
                self.line(&format!("{job}: done in {} ({blocks} run{found})", duration_text(elapsed_s)));
            }
            Event::JobCached { job, .. } => {
                self.close(job);
            }
            Event::JobFailed { job, reason } => {
                self.close(job);
                self.line(&format!("{job}: FAILED: {reason}"));
            }
            Event::JobSkipped { job, upstream } => {
                self.close(job);
                self.line(&format!("{job}: not run, because {upstream} has no result"));
            }
            Event::RunFinished { finished, failed, interrupted } => {
                for job in self.jobs.keys().cloned().collect::<Vec<_>>() {
                    self.close(&job);
                }
                let failed = if *failed > 0 { format!(", {failed} without one") } else { String::new() };
                let end = if *interrupted { "; interrupted, what was finished is kept" } else { "" };
                self.line(&format!("{} with a result{failed}{end}", counted(*finished as u64, "job")));
            }
        }
    }

    fn block_done(&mut self, job: &str, found: bool) {
        let Some(running) = self.jobs.get_mut(job) else { return };
        running.blocks_done += 1;
        running.blocks_found += u64::from(found);
        if let Some(bar) = &running.bar {
            bar.inc(1);
        } else if running.last_line.elapsed() >= LINE_INTERVAL {
            running.last_line = Instant::now();
            let line = format!("{job}: {}", running.stage_text(running.stage_since.elapsed().as_secs_f64()));
            self.line(&line);
        }
    }

    /// Ends a job's bar and gives the seconds since it started.
    fn close(&mut self, job: &str) -> f64 {
        let Some(running) = self.jobs.remove(job) else { return 0.0 };
        if let Some(bar) = running.bar {
            bar.finish_and_clear();
        }
        running.since.elapsed().as_secs_f64()
    }

    /// Tells a line. Names of jobs and reasons come from files: nothing in them steers the terminal.
    fn line(&mut self, line: &str) {
        let line = escaped(line);
        // A closed standard error must not end a run.
        let _ = match &mut self.out {
            Out::Bars(bars) => bars.println(line.as_ref()),
            Out::Lines(writer) => writeln!(writer, "{line}"),
        };
    }
}

impl Running {
    /// `sum: 50 of 200 blocks, 2.5/s, about 1 min left`; the rate is that of blocks that were run.
    fn stage_text(&self, elapsed_s: f64) -> String {
        let mut text = format!("{}: {} of {} blocks", self.stage, self.blocks_done, self.blocks);
        let rate = (self.blocks_done - self.blocks_found) as f64 / elapsed_s.max(1e-9);
        if rate > 0.0 {
            let left_s = self.blocks.saturating_sub(self.blocks_done) as f64 / rate;
            text.push_str(&format!(", {rate:.3}/s, about {} left", duration_text(left_s)));
        }
        text
    }
}

fn new_bar(job: &str) -> ProgressBar {
    const TEMPLATE: &str = "{prefix} {msg} [{bar:30}] {pos}/{len} {per_sec} {eta} left";
    let bar = ProgressBar::new(0).with_prefix(escaped(job).into_owned());
    match ProgressStyle::with_template(TEMPLATE) {
        Ok(style) => bar.with_style(style.progress_chars("=> ")),
        Err(_) => bar,
    }
}

fn counted(count: u64, what: &str) -> String {
    if count == 1 { format!("1 {what}") } else { format!("{count} {what}s") }
}

/// A duration in seconds, as a person says it.
pub fn duration_text(duration_s: f64) -> String {
    match duration_s {
        s if s < 10.0 => format!("{s:.1} s"),
        s if s < 120.0 => format!("{s:.0} s"),
        s if s < 7200.0 => format!("{:.0} min", s / 60.0),
        s => format!("{:.1} h", s / 3600.0),
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::runner::key::Key;

    #[derive(Clone, Default)]
    struct Sink(Arc<Mutex<Vec<u8>>>);

    impl Write for Sink {
        fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
            self.0.lock().unwrap().extend(bytes);
            Ok(bytes.len())
        }
        fn flush(&mut self) -> std::io::Result<()> {
            Ok(())
        }
    }

    #[test]
    fn plain_lines_tell_the_story_of_a_run() {
        let sink = Sink::default();
        let progress = Progress::lines_to(Box::new(sink.clone()));
        let key = Key::of(b"key");
        let job = || "pass-1:before".to_owned();
        for event in [
            Event::RunStarted { to_run: 1, cached: 2, threads: 1 },
            Event::JobStarted { job: job(), kind: "propagate".into(), key: key.clone() },
            Event::StageStarted { job: job(), stage: "sum".into(), blocks: 1 },
            Event::BlockDone { job: job(), stage: "sum".into(), index: 0, cached: false },
            Event::JobFinished {
                job: job(),
                kind: "propagate".into(),
                key,
                blocks_run: 1,
                blocks_cached: 0,
                work_s: 0.1,
            },
            Event::JobFailed { job: "x\u{1b}[2J".into(), reason: "no path to a \u{202e}boundary\n".into() },
            Event::RunFinished { finished: 3, failed: 1, interrupted: false },
        ] {
            progress.hear(&event);
        }
        let text = String::from_utf8(sink.0.lock().unwrap().clone()).unwrap();
        let expected = "1 job to run on 1 thread, 2 in the cache\n\
                        pass-1:before: started (propagate)\n\
                        pass-1:before: done in 0.0 s (1 block run)\n\
                        x\\u{1b}[2J: FAILED: no path to a \\u{202e}boundary\\n\n\
                        3 jobs with a result, 1 without one\n";
        assert_eq!(text, expected);
    }

    #[test]
    fn the_rate_counts_only_blocks_that_were_run() {
        let now = Instant::now();
        let running = Running {
            since: now,
            last_line: now,
            stage: "sum".into(),
            blocks: 200,
            blocks_done: 60,
            stage_since: now,
            blocks_found: 50,
            bar: None,
        };
        assert_eq!(running.stage_text(10.0), "sum: 60 of 200 blocks, 1.000/s, about 2 min left");
    }

    #[test]
    fn durations_read_well() {
        let texts = [0.04, 3.0, 59.6, 240.0, 9000.0].map(duration_text);
        assert_eq!(texts, ["0.0 s", "3.0 s", "60 s", "4 min", "2.5 h"]);
    }
}

//! Progress for people, on standard error: a bar with rate and time left for each running job on a terminal, plain lines
//! where the output is none.

use std::collections::BTreeMap;
use std::fmt;
use std::io::{IsTerminal, Write};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use indicatif::{MultiProgress, ProgressBar, ProgressState, ProgressStyle};

use crate::document::counted;
use crate::document::visible::escaped;

use super::events::{Event, Listener};
use super::forecast::{RunningBlock, Seen, left};
use crate::watch::Share;

/// Plain lines about one job come at most this often.
const LINE_INTERVAL: Duration = Duration::from_secs(10);
/// A bar is drawn anew this often, also while no block ends.
const TICK: Duration = Duration::from_millis(500);

/// Shows a run's progress.
pub struct Progress {
    shown: Mutex<Shown>,
}

struct Shown {
    jobs: BTreeMap<String, Running>,
    threads: usize,
    to_run: usize,
    out: Out,
}

enum Out {
    Bars(MultiProgress),
    Lines(Box<dyn Write + Send>),
}

struct Running {
    since: Instant,
    last_line: Instant,
    /// Shared with the bar, which is drawn by a thread of its own.
    stage: Arc<Mutex<Stage>>,
    bar: Option<ProgressBar>,
}

/// A stage under way.
pub struct Stage {
    name: String,
    /// When it began.
    pub since: Instant,
    blocks: usize,
    /// Blocks that were found rather than run.
    pub found: usize,
    /// How long each block took that was run, s.
    pub ended_s: Vec<f64>,
    running: BTreeMap<usize, (Instant, Share)>,
    threads: usize,
    is_last: bool,
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
        Self { shown: Mutex::new(Shown { jobs: BTreeMap::new(), threads: 1, to_run: 0, out }) }
    }
}

impl Listener for Progress {
    fn hear(&self, event: &Event) {
        lock(&self.shown).hear(event);
    }

    fn block_runs(&self, job: &str, index: usize, share: &Share) {
        if let Some(running) = lock(&self.shown).jobs.get(job) {
            lock(&running.stage).running.insert(index, (Instant::now(), share.clone()));
        }
    }
}

impl Shown {
    fn hear(&mut self, event: &Event) {
        match event {
            Event::RunStarted { to_run, cached, threads, engine } => {
                self.threads = *threads;
                self.to_run = *to_run;
                if *to_run > 0 {
                    let place = match engine {
                        Some(engine) => format!("by {engine}"),
                        None => format!("on {}", counted(*threads as u64, "thread")),
                    };
                    let line = format!("{} to run {place}, {cached} in the cache", counted(*to_run as u64, "job"));
                    self.line(&line);
                } else if *cached > 0 {
                    self.line(&format!("nothing to run, {} in the cache", counted(*cached as u64, "job")));
                }
            }
            Event::JobStarted { job, kind, .. } => {
                let now = Instant::now();
                let stage = Arc::new(Mutex::new(Stage::new(String::new(), 0, self.threads, false)));
                let bar = match &self.out {
                    Out::Bars(bars) => {
                        let bar = bars.add(new_bar(job, &stage));
                        bar.enable_steady_tick(TICK);
                        Some(bar)
                    }
                    Out::Lines(_) => None,
                };
                self.jobs.insert(job.clone(), Running { since: now, last_line: now, stage, bar });
                if matches!(self.out, Out::Lines(_)) {
                    self.line(&format!("{job}: started ({kind})"));
                }
            }
            Event::StageStarted { job, stage, blocks, is_last } => {
                let Some(running) = self.jobs.get_mut(job) else { return };
                *lock(&running.stage) = Stage::new(stage.clone(), *blocks, self.threads, *is_last);
                if let Some(bar) = &running.bar {
                    bar.reset();
                    bar.set_length(*blocks as u64);
                    bar.set_message(stage.clone());
                }
            }
            Event::BlockDone { job, index, cached, .. } => self.block_done(job, *index, *cached),
            Event::Damaged { object } => {
                self.line(&format!("object {} of the cache is damaged; it is computed again", object.short()));
            }
            Event::Cluster { text } => self.line(text),
            Event::NotStored { reason } => {
                self.line(&format!("warning: not all results are kept in the cache: {reason}"));
            }
            Event::JobFinished { job, blocks_run, blocks_cached, .. } => {
                let cached_clause = if *blocks_cached > 0 { format!(", {blocks_cached} found") } else { String::new() };
                let elapsed_s = self.close(job);
                let blocks = counted(*blocks_run as u64, "block");
                self.line(&format!("{job}: done in {} ({blocks} run{cached_clause})", duration_text(elapsed_s)));
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
                if self.to_run == 0 {
                    return;
                }
                let failed = if *failed > 0 { format!(", {failed} without one") } else { String::new() };
                let end = if *interrupted {
                    "; interrupted: what was finished is kept, and the next run goes on from there"
                } else {
                    ""
                };
                self.line(&format!("{} with a result{failed}{end}", counted(*finished as u64, "job")));
            }
        }
    }

    fn block_done(&mut self, job: &str, index: usize, found: bool) {
        let Some(running) = self.jobs.get_mut(job) else { return };
        let now = Instant::now();
        lock(&running.stage).block_done(index, found, now);
        if let Some(bar) = &running.bar {
            bar.inc(1);
        } else if running.last_line.elapsed() >= LINE_INTERVAL {
            running.last_line = now;
            let line = format!("{job}: {}", lock(&running.stage).text(now));
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

impl Stage {
    /// A stage of so many blocks that begins now.
    pub fn new(name: String, blocks: usize, threads: usize, is_last: bool) -> Self {
        let (ended_s, running) = (Vec::new(), BTreeMap::new());
        Self { name, since: Instant::now(), blocks, found: 0, ended_s, running, threads, is_last }
    }

    fn block_done(&mut self, index: usize, found: bool, now: Instant) {
        match self.running.remove(&index) {
            Some((since, _)) => self.ended_s.push(now.duration_since(since).as_secs_f64()),
            None => self.found += usize::from(found),
        }
    }

    fn done(&self) -> usize {
        self.ended_s.len() + self.found
    }

    /// What the forecast is made from.
    fn seen(&self, now: Instant) -> Seen {
        let running = self.running.values().map(|(since, share)| RunningBlock {
            elapsed_s: now.duration_since(*since).as_secs_f64(),
            share: share.done(),
        });
        let running: Vec<RunningBlock> = running.collect();
        Seen {
            waiting: self.blocks.saturating_sub(self.done() + running.len()),
            ended_s: self.ended_s.clone(),
            running,
            threads: self.threads,
            is_last: self.is_last,
        }
    }

    /// `2.5/s, about 1 min left`, as far as it is known; the rate is that of blocks that were run.
    fn pace(&self, now: Instant) -> String {
        let rate = self.ended_s.len() as f64 / now.duration_since(self.since).as_secs_f64().max(1e-9);
        let rate = (rate >= 0.1).then(|| format!("{rate:.1}/s"));
        rate.into_iter().chain(left(&self.seen(now)).text()).collect::<Vec<_>>().join(", ")
    }

    /// `sum: 50 of 200 blocks, 2.5/s, about 1 min left`.
    pub fn text(&self, now: Instant) -> String {
        let pace = Some(self.pace(now)).filter(|pace| !pace.is_empty());
        let pace = pace.map_or_else(String::new, |pace| format!(", {pace}"));
        format!("{}: {} of {}{pace}", self.name, self.done(), counted(self.blocks, "block"))
    }
}

fn new_bar(job: &str, stage: &Arc<Mutex<Stage>>) -> ProgressBar {
    const TEMPLATE: &str = "{prefix} {msg} {pos}/{len} [{wide_bar}] {pace}";
    let bar = ProgressBar::new(0).with_prefix(escaped(job).into_owned());
    let stage = Arc::clone(stage);
    let pace = move |_: &ProgressState, out: &mut dyn fmt::Write| {
        let _ = out.write_str(&lock(&stage).pace(Instant::now()));
    };
    match ProgressStyle::with_template(TEMPLATE) {
        Ok(style) => bar.with_style(style.progress_chars("=> ").with_key("pace", pace)),
        Err(_) => bar,
    }
}

/// What is guarded here is whole after every assignment.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A duration in seconds, in words.
pub fn duration_text(duration_s: f64) -> String {
    match duration_s {
        s if s < 10.0 => format!("{s:.1} s"),
        s if s < 120.0 => format!("{s:.0} s"),
        s if s < 7200.0 => format!("{:.0} min", s / 60.0),
        s => format!("{:.1} h", s / 3600.0),
    }
}

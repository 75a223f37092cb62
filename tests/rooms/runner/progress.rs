//! Tests of `src/runner/progress.rs`.

use bmv::runner::Listener;
use std::io::Write;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use bmv::runner::events::Event;
use bmv::runner::key::Key;
use bmv::runner::progress::*;

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
        Event::RunStarted { to_run: 1, cached: 2, threads: 1, engine: None },
        Event::JobStarted { job: job(), kind: "propagate".into(), key: key.clone() },
        Event::StageStarted { job: job(), stage: "sum".into(), blocks: 1, is_last: true },
        Event::BlockDone { job: job(), stage: "sum".into(), index: 0, cached: false },
        Event::JobFinished { job: job(), kind: "propagate".into(), key, blocks_run: 1, blocks_cached: 0, work_s: 0.1 },
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
    let mut stage = Stage::new("sum".into(), 200, 1, true);
    (stage.found, stage.ended_s) = (50, vec![1.0; 10]);
    let now = stage.since + Duration::from_secs(10);
    assert_eq!(stage.text(now), "sum: 60 of 200 blocks, 1.0/s, about 2 min left");
    let mut stage = Stage::new("sample".into(), 5, 2, false);
    stage.ended_s = vec![30.0];
    assert_eq!(stage.text(stage.since + Duration::from_secs(60)), "sample: 1 of 5 blocks");
}

#[test]
fn durations_read_well() {
    let texts = [0.04, 3.0, 59.6, 240.0, 9000.0].map(duration_text);
    assert_eq!(texts, ["0.0 s", "3.0 s", "60 s", "4 min", "2.5 h"]);
}

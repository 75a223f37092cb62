//! Tests of `src/batch/memory.rs`.

use bmv::batch::memory::*;
use bmv::runner::Key;
use bmv::runner::plan::Preview;

#[test]
fn what_does_not_fit_is_refused_with_what_to_change() {
    let job = |job: &str, memory_bytes| Preview {
        job: job.into(),
        kind: "propagate".into(),
        key: Key::of(b"key"),
        cached: false,
        work_s: None,
        is_same_work: false,
        memory_bytes,
    };
    let needed = [job("small", 1 << 20), job("large", 34 << 30), job("none", 0)];
    assert!(refused(&needed, 40 << 30).is_ok());
    let message = refused(&needed, 16 << 30).unwrap_err().to_string();
    assert_eq!(
        message,
        "`large` needs about 36.5 GB of memory, this machine has 17.2 GB: give it fewer `samples` (or `draws`), or a sweep \
         of fewer `steps`, or less `data` and fewer `effects`"
    );
    assert_eq!(notes(&needed), ["large takes about 36.5 GB of memory"]);
    let texts = [300_000_000, 2_100_000_000, 250_000_000_000, 8_600_000_000_000].map(bytes_text);
    assert_eq!(texts, ["300 MB", "2.1 GB", "250 GB", "8.6 TB"]);
}

//! A job's blocks one after the other on one thread, without a cache.

use bmv::job::{JobError, Next, NoParts, Runnable};
use serde_json::Value;

/// The result of a job.
pub fn run(job: &dyn Runnable) -> Result<Value, JobError> {
    let mut next = job.begin()?;
    loop {
        match next {
            Next::Done(result) => return Ok(result.json),
            Next::Stage(stage) => {
                let block = |index| job.block(&stage, index, &NoParts);
                let outputs = (0..stage.inputs.len()).map(block).collect::<Result<Vec<_>, _>>()?;
                next = job.reduce(&stage, outputs)?;
            }
        }
    }
}

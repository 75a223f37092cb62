//! `bmv cache stat`, `verify`, `prune`, `why`.

use clap::Subcommand;

use super::Context;
use super::options::{CacheOption, PathsArgument};
use super::output::{escaped, print, print_json, shown, table};
use super::status::{Failure, Status};
use crate::batch;
use crate::document::counted;
use crate::runner::Plan;

/// Verbs below `bmv cache`.
#[derive(Debug, Subcommand)]
pub(super) enum CacheVerb {
    /// Count what is stored
    Stat {
        #[command(flatten)]
        cache: CacheOption,
        /// Print one JSON document
        #[arg(long)]
        json: bool,
    },
    /// Read every object and set the damaged ones aside; exit status 1 if there were any
    Verify {
        #[command(flatten)]
        cache: CacheOption,
        /// Print one JSON document
        #[arg(long)]
        json: bool,
    },
    /// Move what the passes as they are now do not use to the trash, and delete what lies there for more than a day
    Prune {
        #[command(flatten)]
        paths: PathsArgument,
        #[command(flatten)]
        cache: CacheOption,
        /// Print one JSON document
        #[arg(long)]
        json: bool,
    },
    /// Print what a job's key is made of
    Why {
        /// Name of a job, or its pass and name as `bmv plan` shows them
        job: String,
        #[command(flatten)]
        paths: PathsArgument,
    },
}

impl CacheVerb {
    pub(super) fn execute(self, context: &Context) -> Result<Status, Failure> {
        match self {
            Self::Stat { cache, json } => {
                let cache = cache.cache(&[]);
                let statistics = cache.statistics()?;
                if json {
                    print_json(&statistics)?;
                    return Ok(Status::Done);
                }
                let row = |name: &str, count: u64, bytes: Option<u64>| {
                    vec![
                        name.to_owned(),
                        count.to_string(),
                        bytes.map_or(String::new(), |bytes| counted(bytes, "byte")),
                    ]
                };
                let rows = [
                    row("results", statistics.results, Some(statistics.result_bytes)),
                    row("blocks", statistics.blocks, Some(statistics.block_bytes)),
                    row("unfinished or foreign files", statistics.leftovers, None),
                    row("damaged, in quarantine", statistics.quarantined, None),
                    row("not reproducible, in conflict", statistics.conflicts, None),
                    row("in the trash", statistics.trashed, None),
                ];
                print(&format!("{}\n{}", shown(cache.root()), table(&rows, None)))?;
                Ok(Status::Done)
            }
            Self::Verify { cache, json } => {
                let verification = cache.cache(&[]).verify()?;
                if json {
                    print_json(&verification)?;
                } else {
                    for name in &verification.damaged {
                        print(&format!("damaged: {name}\n"))?;
                    }
                    print(&format!(
                        "{} sound, {} damaged\n",
                        counted(verification.sound, "object"),
                        verification.damaged.len()
                    ))?;
                }
                Ok(if verification.damaged.is_empty() { Status::Done } else { Status::CheckFailed })
            }
            Self::Prune { paths, cache, json } => {
                let loaded = batch::load(&paths.paths, &context.reading)?;
                let cache = cache.cache(&loaded.passes);
                let plan = Plan::new(loaded.nodes)?;
                let done = cache.prune(&plan.keys().iter().cloned().collect())?;
                if json {
                    print_json(&done)?;
                } else {
                    print(&format!(
                        "{} kept, {} moved to the trash ({}), {} deleted\n",
                        counted(done.kept, "object"),
                        done.moved,
                        counted(done.moved_bytes, "byte"),
                        counted(done.deleted, "file")
                    ))?;
                }
                Ok(Status::Done)
            }
            Self::Why { job, paths } => {
                let plan = Plan::new(batch::load(&paths.paths, &context.reading)?.nodes)?;
                let Some(position) = plan.find(&job) else {
                    let same_name = plan.nodes().iter().filter(|node| node.name == job).map(|node| escaped(&node.id));
                    let ids: Vec<_> = same_name.collect();
                    let job = escaped(&job);
                    return Err(Failure::input(if ids.is_empty() {
                        format!("no job is called `{job}`")
                    } else {
                        format!("several jobs are called `{job}`: {}", ids.join(", "))
                    }));
                };
                print(&format!("{}\n", plan.material(position).explain()?))?;
                super::output::tell(&format!("key {}", plan.keys()[position]));
                Ok(Status::Done)
            }
        }
    }
}

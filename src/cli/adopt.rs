//! `bmv adopt`.

use std::path::{Path, PathBuf};

use serde::Deserialize;

use super::execute::execute;
use super::options::{CachedRunOptions, RunOptions};
use super::output::{escaped, print, tell};
use super::status::{Failure, Status};
use super::{Context, select};
use crate::batch::next_pass::{
    Acting, Adoption, Asked, Mended, NextPass, acts_in, adopt_into, probability_text, to_mend,
};
use crate::batch::{self, Loaded, LoadedPass};
use crate::diagnosis::output::EffectResult;
use crate::diagnosis::verdict::numbers::kelvins_before_and_after;
use crate::diagnosis::{Output, RISES};
use crate::document::suggest;
use crate::document::visible::shell_word;
use crate::measurement::Doubt;
use crate::runner::Listener;
use crate::study::job::CALIBRATION;

/// Diagnostics printed of one refusal.
const MOST_DIAGNOSTICS: usize = 20;

/// Arguments of `bmv adopt`.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Effects are named as in `effects` of `bmv diagnose PASS --json`, or by a beginning, an effect's \
                        name or the last places that stand for one. What the diagnosis did not select, or could not tell from what it \
                        selected, is refused; what it leaves open (`ambiguous`) is adopted by name only. The next pass takes all else from its parent; nothing is run.\n\n\
                        An effect acts in every measurement and environment, so that flight predictions have it too. What \
                        belongs to the test alone (a harness, the chamber) is adopted with --test-only.\n\n\
                        Examples:\n  \
                        bmv adopt my-study/pass-1.json\n  \
                        bmv adopt my-study/pass-1.json sensor-lag\n  \
                        bmv adopt my-study/pass-1.json conductive-path --test-only"
)]
pub(super) struct Adopt {
    /// Pass file
    pass: PathBuf,
    /// Effects to adopt [default: those that the diagnosis selected, where its verdict is `identified`]
    #[arg(value_name = "EFFECT")]
    effects: Vec<String>,
    /// File of the next pass, beside its parent [default: the next free pass-N.json]
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// The effects belong to the test alone: they act in the measurements of the pass and in no prediction
    #[arg(long, conflicts_with = "applies_to")]
    test_only: bool,
    /// Measurement or environment in which the effects act; may be given several times [default: all]
    #[arg(long, value_name = "NAME")]
    applies_to: Vec<String>,
    /// Adopt what the diagnosis does not support, and replace the file that --out names
    #[arg(long)]
    force: bool,
    /// Name of the diagnosis in the pass [default: the first]
    #[arg(long, value_name = "NAME")]
    job: Option<String>,
    #[command(flatten)]
    options: CachedRunOptions,
}

impl Adopt {
    pub(super) fn execute(self, context: &Context) -> Result<Status, Failure> {
        select::one_pass(&self.pass)?;
        let of_job = self.job.as_ref().map_or_else(String::new, |job| format!(" --job {}", shell_word(job)));
        let pass = self.pass.display().to_string();
        let acting = match (self.test_only, self.applies_to.as_slice()) {
            (true, _) => Acting::InTests,
            (false, []) => Acting::Everywhere,
            (false, names) => Acting::In(names.to_vec()),
        };
        let command = format!("bmv adopt {}{of_job}", shell_word(&pass));
        let asked = Asked::new(&command, &self.effects).acting(acting.clone());
        let job = select::job_of_kind(&self.pass, "diagnose", self.job.as_deref(), context.coloured)?;
        let options = self.options.clone().into();
        let executed = execute(std::slice::from_ref(&self.pass), &options, context, |_, name| name == job)?;
        let Some(pass) = executed.passes.first() else { return Ok(Status::of(&executed)) };
        let diagnosis_result = executed.results(pass).find(|(at, _)| executed.plan.nodes()[*at].name == job);
        let Some((_, result)) = diagnosis_result else { return Ok(Status::of_wanted(&executed)) };
        let diagnosis = Output::deserialize(&*result.stored.value).map_err(|error| {
            Failure::job(format!("{}: the result of `{job}` is no diagnosis: {error}", escaped(&pass.shown)))
        })?;
        let asked = asked.mending(self.to_mend(context)?);
        let adoption = adopt_into(&pass.pass, &job, &diagnosis, &asked, self.out.as_deref(), self.force);
        match adoption.map_err(|wrong| Failure::rendered(wrong.render(context.coloured, MOST_DIAGNOSTICS)))? {
            Adoption::There(twin) => {
                let (shown, parent_file) = (escaped(&twin.display().to_string()), escaped(&pass.file));
                let there = format!("{shown} is {parent_file} with the same effects already; nothing is written");
                print(&format!("{there} (--out FILE writes another pass all the same)\n{}", now_try(pass, &twin)))?;
            }
            Adoption::Written(path, next) => {
                for line in diagnosis.doubts.iter().map(Doubt::in_words) {
                    tell(&format!("warning: {}", escaped(&line)));
                }
                if !next.warnings.is_empty() {
                    tell(&next.warnings.render(context.coloured, MOST_DIAGNOSTICS));
                }
                let words: String = self.effects.iter().map(|effect| format!(" {}", shell_word(effect))).collect();
                let acting =
                    next.acts_on_model.then(|| where_it_acts(pass, &path, &next, &acting, &(command + &words)));
                print(&described(pass, &path, &next, (&diagnosis, &acting.unwrap_or_default())))?;
            }
        }
        Ok(Status::of(&executed))
    }

    /// Calibrations of the pass that the cache says did not converge; none is run for it.
    fn to_mend(&self, context: &Context) -> Result<Vec<Mended>, Failure> {
        let loaded = batch::load(std::slice::from_ref(&self.pass), &context.reading)?;
        let mut prepared = batch::prepare(loaded, Loaded::default(), |_, kind, _| kind == CALIBRATION)?;
        let options: RunOptions = self.options.clone().into();
        prepared.leave_out_missing(&options.cache.cache(prepared.passes()));
        if prepared.passes().iter().all(|pass| pass.jobs.is_empty()) {
            return Ok(Vec::new());
        }
        let cache = options.cache.cache(prepared.passes());
        let executed = prepared.run(options.settings(), &cache, &context.interrupts, &Vec::<&dyn Listener>::new())?;
        Ok(executed.passes.iter().flat_map(|pass| to_mend(pass, &executed)).collect())
    }
}

/// What was written, what stays open, and the next commands.
fn described(pass: &LoadedPass, path: &Path, next: &NextPass<'_>, (diagnosis, acting): (&Output, &str)) -> String {
    let shown = escaped(&path.display().to_string());
    let mut text = format!("wrote {shown}: {} with\n", escaped(&pass.file));
    for (name, finding) in &next.adopted {
        let probability = probability_text(finding.probability);
        let against = if diagnosis.supports(finding) { "" } else { ", against the diagnosis" };
        text.push_str(&format!("  {}: {}, probability {probability}{against}\n", escaped(name), escaped(&finding.id)));
    }
    text.push_str(acting);
    for file in &next.files {
        text.push_str(&format!(
            "wrote effects/{}.json: the {} that the diagnosis proposes\n",
            escaped(&file.name),
            escaped(&file.law)
        ));
    }
    let chosen: Vec<_> = next.adopted.iter().map(|(_, finding)| *finding).collect();
    for (id, [before, after]) in chosen.iter().filter_map(|finding| Some((&finding.id, worse(finding)?))) {
        let (id, [before, after]) = (escaped(id), kelvins_before_and_after([before, after]));
        text.push_str(&format!("with {id} the error on the held-out readings rises from {before} to {after} K\n"));
    }
    if !next.extended.is_empty() {
        let jobs = suggest::listed(next.extended.iter().map(String::as_str), 12);
        text.push_str(&format!("{} names its parameters; those of the effects were added\n", escaped(&jobs)));
    }
    for mended in &next.mended {
        text.push_str(&format!(
            "`{}` of {} did not converge: here it has {}\n",
            escaped(&mended.job),
            escaped(&pass.file),
            escaped(&mended.settings)
        ));
    }
    for (name, kind) in &next.added {
        let parent_file = escaped(&pass.file);
        text.push_str(&format!(
            "{parent_file} has no job of kind {kind}; `{}` was added, so that `bmv history` can tell the error\n",
            escaped(name)
        ));
    }
    text + &now_try(pass, path)
}

/// Where the effects act, and how that is changed where they belong to the test alone.
fn where_it_acts(pass: &LoadedPass, path: &Path, next: &NextPass<'_>, acting: &Acting, command: &str) -> String {
    let (sentence, tests) = acts_in(&pass.pass, acting, next.adopted.len() == 1);
    let mut text = format!("{}\n", escaped(&sentence));
    if let Some(tests) = tests {
        let shown = escaped(&path.display().to_string());
        let (out, command) = (escaped(&shell_word(&path.display().to_string())), escaped(command));
        text.push_str(&format!(
            "does it belong to the test alone (a harness, the chamber)? then write \"applies_to\": {} beside \"because\" in \
             {shown}, or\n{command} --test-only --out {out} --force\n",
            escaped(&tests)
        ));
    }
    text
}

/// Errors on the held-out readings before and after, K, where they rise by more than a twentieth.
fn worse(finding: &EffectResult) -> Option<[f64; 2]> {
    let [before, after] = finding.rmse_k.held_out;
    let (before, after) = (before?, after?);
    (after > RISES * before).then_some([before, after])
}

/// The next commands.
fn now_try(pass: &LoadedPass, path: &Path) -> String {
    let study = escaped(&pass.study.display().to_string());
    let study = if study.is_empty() { ".".to_owned() } else { study };
    format!("now try\nbmv run {}\nbmv history {study}\n", escaped(&path.display().to_string()))
}

//! What a section says of its kind's results outside the report: in a line or two, figure by figure, against what is
//! required.

use crate::job::kind::JobKind;
use crate::report::required::Standing;
use crate::report::view::JobEntry;

/// Results of a kind in brief; the type that implements it holds nothing.
pub trait Brief: Sync {
    /// The kind.
    type Kind: JobKind;

    /// The outcome, a line each.
    fn headline(job: &JobEntry, output: &<Self::Kind as JobKind>::Output) -> Vec<String>;

    /// Names and texts of the figures that tell the result.
    fn essentials(output: &<Self::Kind as JobKind>::Output) -> Vec<(String, String)>;

    /// How requirements stand; none where the kind judges none.
    fn standings(_output: &<Self::Kind as JobKind>::Output) -> Vec<Standing> {
        Vec::new()
    }
}

/// Results of some kind in brief; `None` where the job is of another kind.
pub trait ErasedBrief: Sync {
    /// See [`Brief::headline`].
    fn headline(&self, job: &JobEntry) -> Option<Vec<String>>;
    /// See [`Brief::essentials`].
    fn essentials(&self, job: &JobEntry) -> Option<Vec<(String, String)>>;
    /// See [`Brief::standings`].
    fn standings(&self, job: &JobEntry) -> Option<Vec<Standing>>;
}

impl<B: Brief> ErasedBrief for B {
    fn headline(&self, job: &JobEntry) -> Option<Vec<String>> {
        job.output_of::<B::Kind>().map(|output| <B as Brief>::headline(job, output))
    }

    fn essentials(&self, job: &JobEntry) -> Option<Vec<(String, String)>> {
        job.output_of::<B::Kind>().map(<B as Brief>::essentials)
    }

    fn standings(&self, job: &JobEntry) -> Option<Vec<Standing>> {
        job.output_of::<B::Kind>().map(<B as Brief>::standings)
    }
}

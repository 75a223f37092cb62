//! A conventional analysis in brief.

use crate::document::counted;
use crate::job::conventional::{Kind, Output};
use crate::report::number::{NONE, Shown};
use crate::report::section::brief::Brief;
use crate::report::view::JobEntry;

/// A conventional analysis in brief.
pub(in crate::report::section) struct Sizing;

impl Brief for Sizing {
    type Kind = Kind;

    /// The range of the sizes by rule.
    fn headline(_: &JobEntry, output: &Output) -> Vec<String> {
        let design = Shown::written(&output.design_unit);
        let sizes: Vec<f64> = output.sizes.iter().filter_map(|size| size.size).collect();
        let (least, most) = (sizes.iter().copied().reduce(f64::min), sizes.iter().copied().reduce(f64::max));
        let nominal = design.text(output.design_nominal);
        let passing = output.sizes.iter().filter(|size| size.passes).count();
        let range = match least.zip(most) {
            Some((least, most)) => {
                format!("{} from {} to {} by rule", output.design_variable, design.number(least), design.text(most))
            }
            None => format!("no {} of the range satisfies any rule", output.design_variable),
        };
        vec![format!("{range}; the nominal {nominal} passes {passing} of {}", counted(output.sizes.len(), "rule"))]
    }

    fn essentials(output: &Output) -> Vec<(String, String)> {
        let design = Shown::written(&output.design_unit);
        let name = &output.design_variable;
        let mut rows = vec![(format!("{name}, nominal"), design.text(output.design_nominal))];
        rows.extend(output.sizes.iter().map(|size| {
            let (rule, requirement, environment) = (&size.rule.name, &size.requirement, &size.environment);
            let figure = format!("{name} by rule {rule}, {}: {requirement} in {environment}", size.basis.words());
            (figure, size.size.map_or_else(|| NONE.to_owned(), |size| design.text(size)))
        }));
        rows
    }
}

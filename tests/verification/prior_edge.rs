//! Two paths that a model lacks, one of which the bounds of a parameter hide while the other is alone in the set. The readings
//! of `two_paths` were simulated apart from this program, with a solver of their own: 0.04 W/K from the battery to a panel and
//! 0.06 W/K from a board to another, noise of 0.3 K.

use std::path::Path;

use bmv::diagnosis::{Diagnosis, Settings};
use bmv::random::StreamKey;

/// Beside the battery's path alone the board's conductor is at its upper bound of 0.5 W/K (0.398 is true), where no second
/// effect stands out; with both it comes back, and the sum of squares falls by 27.
#[test]
#[ignore = "thorough"]
fn what_a_bound_hides_is_found_where_the_parameters_were_believed_to_be() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/verification/two_paths/pass-1.json");
    let pass = bmv::job::load(&file).unwrap_or_else(|wrong| panic!("{}", wrong.render(false, 20)));
    let problem = bmv::study::problem(&pass);
    let diagnosis = Diagnosis::new(problem, Settings::default(), StreamKey::new(7, "test", "bent"));
    let output = diagnosis.run().expect("a diagnosis");
    let mut selected = output.selected.clone();
    selected.sort_unstable();
    assert_eq!(selected, ["conductive-path:bat:zp", "conductive-path:s1:yp"], "{:?}", output.words);
    for (id, truth) in [("conductive-path:bat:zp", 0.04), ("conductive-path:s1:yp", 0.06)] {
        let own = output.effects.iter().find(|effect| effect.id == id).expect("fitted");
        let found = &own.amplitudes["conductance"];
        // Normal: one of 370 beyond 3 standard deviations.
        assert!((found.value - truth).abs() < 3.0 * found.sd, "{id}: {found:?}");
    }
}

//! Tests of `src/runner/cluster/worker.rs`.

use bmv::runner::cluster::worker::*;
use bmv::runner::key::Key;

#[test]
fn ends_have_the_codes_of_the_system() {
    assert_eq!([End::Published, End::Usage, End::Rejected, End::Temporary].map(End::code), [0, 64, 65, 75]);
    assert!(Key::try_from(program_sha256()).is_ok());
}

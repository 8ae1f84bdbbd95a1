//! What every controller publishes, by the names of its outputs.

use std::path::Path;

use formation::wiring::Role;
use formation::wiring::testing::check_responses;

#[test]
fn outputs_have_the_values_of_their_names() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    // What a law by formulas publishes is said by a scenario of a user.
    let kinds: Vec<_> = low_level_ctrl::KINDS.iter().copied().filter(|kind| kind.name != "formulas").collect();
    check_responses(Role::Controller, &kinds, &root.join("../scenarios"), &root.join("tests/outputs.txt"));
}

//! What every controller publishes, by the names of its outputs.

use std::path::Path;

use formation::wiring::Role;
use formation::wiring::testing::check_responses;

#[test]
fn outputs_have_the_values_of_their_names() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    check_responses(
        Role::Controller,
        low_level_ctrl::KINDS,
        &root.join("../scenarios"),
        &root.join("tests/outputs.txt"),
    );
}

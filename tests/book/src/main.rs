//! Builds the book into `target/book`:
//!
//! ```text
//! cargo doc --workspace --no-deps --release     # for the reference of the Rust crates; without it, the book lacks that part
//! cargo run --manifest-path tests/book/Cargo.toml
//! ```

fn main() {
    let folder = book::build();
    println!("{}", folder.join("index.html").display());
}

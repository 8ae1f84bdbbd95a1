//! Scenarios that a program brings along.

/// A scenario that is compiled into a program.
#[derive(Clone, Copy, Debug)]
pub struct Shipped {
    /// Its name, `uav`.
    pub name: &'static str,
    /// Where its file is in the repository, for messages.
    pub file: &'static str,
    /// Its text.
    pub text: &'static str,
}

/// The scenarios of the files with these names, `shipped!("../../scenarios/", "uav", "rca")`; the folder is relative to the source
/// file that uses the macro.
#[macro_export]
macro_rules! shipped {
    ($folder:literal, $($name:literal),* $(,)?) => {
        &[$($crate::scenario::Shipped {
            name: $name,
            file: concat!("scenarios/", $name, ".toml"),
            text: include_str!(concat!($folder, $name, ".toml")),
        }),*]
    };
}

//! Published results on networks, in `scenarios/literature`: what comes out is what theory says.

use std::path::PathBuf;

use crate::program::Folder;

/// Every file, and its variants.
fn scenarios() -> Vec<(PathBuf, Vec<String>)> {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../scenarios/literature");
    let entries = std::fs::read_dir(&folder).unwrap_or_else(|error| panic!("{}: {error}", folder.display()));
    let mut files: Vec<PathBuf> = entries.map(|entry| entry.expect("an entry").path()).collect();
    files.sort();
    let of_file = |file: PathBuf| {
        let text = std::fs::read_to_string(&file).expect("a scenario");
        let table: toml::Table = toml::from_str(&text).expect("valid TOML");
        let default = table.get("variant").and_then(|name| name.as_str()).unwrap_or_default().to_string();
        let others = table.get("variants").and_then(|variants| variants.as_table()).into_iter().flatten();
        let variants = std::iter::once(default).chain(others.map(|(name, _)| name.clone())).collect();
        (file, variants)
    };
    files.into_iter().map(of_file).collect()
}

#[test]
fn every_result_is_that_of_theory() {
    let folder = Folder::new();
    let all = scenarios();
    assert!(all.len() >= 6, "{all:?}");
    for (file, variants) in all {
        let file = file.to_str().expect("a readable path");
        for variant in variants {
            let mut arguments =
                vec!["run", file, "--placement", "single", "--strict", "-q", "--json", "--out", "run.mcap"];
            if !variant.is_empty() {
                arguments.extend(["--variant", &variant]);
            }
            _ = std::fs::remove_file(folder.path("run.mcap"));
            let end = folder.run(&arguments);
            assert_eq!(end.code(), 0, "{file} {variant}: {}\n{}", end.stdout(), end.stderr());
            let metrics = end.json()["metrics"].as_object().cloned().unwrap_or_default();
            assert!(
                !metrics.is_empty() && metrics.values().all(|metric| metric["in_range"] != false),
                "{file} {variant}: {metrics:?}"
            );
        }
    }
}

#[test]
fn a_process_for_each_gives_the_same_bits() {
    let folder = Folder::new();
    for (file, _) in scenarios() {
        let file = file.to_str().expect("a readable path");
        let digests = ["single", "processes"].map(|placement| {
            _ = std::fs::remove_file(folder.path("run.mcap"));
            let end = folder.run(&[
                "run",
                file,
                "--placement",
                placement,
                "-q",
                "--json",
                "--out",
                "run.mcap",
                "--set",
                "timing.duration=10",
                "--set",
                "metrics=",
            ]);
            assert_eq!(end.code(), 0, "{file}: {}", end.stderr());
            end.json()["sha256"].as_str().expect("a digest").to_string()
        });
        assert_eq!(digests[0], digests[1], "{file}");
    }
}

//! The public API, as a list that is checked in, so that no change of it goes unseen.
//!
//! `cargo run -p api` fails if the list is not that of the source, and says in what; `cargo run -p
//! api -- --write` writes it anew.

use std::{
    collections::BTreeSet,
    env,
    error::Error,
    fs,
    path::{Path, PathBuf},
    process::{Command, ExitCode},
};

use public_api::Builder;
use serde_json::Value;

type Outcome<T = ()> = Result<T, Box<dyn Error>>;

fn main() -> ExitCode {
    let write = match env::args().skip(1).collect::<Vec<_>>().as_slice() {
        [] => false,
        [write] if write == "--write" => true,
        _ => {
            eprintln!("usage: api [--write]");
            return ExitCode::FAILURE;
        }
    };
    match run(write) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run(write: bool) -> Outcome {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    let list = here.join("bevy_octree.txt");
    let items = items(&documentation(here)?)?;
    if write {
        fs::write(&list, items.join("\n") + "\n")?;
        println!(
            "{} items of the public API are in {}",
            items.len(),
            list.display()
        );
        return Ok(());
    }
    let checked_in = fs::read_to_string(&list)
        .map_err(|error| format!("cannot read {}: {error}", list.display()))?;
    let before: BTreeSet<_> = checked_in.lines().collect();
    let now: BTreeSet<_> = items.iter().map(String::as_str).collect();
    let (gone, new) = (before.difference(&now), now.difference(&before));
    let changes: Vec<_> = gone
        .map(|item| format!("-{item}"))
        .chain(new.map(|item| format!("+{item}")))
        .collect();
    if changes.is_empty() {
        println!("the public API is as listed: {} items", items.len());
        return Ok(());
    }
    println!("{}", changes.join("\n"));
    Err("the public API has changed: if it was to, `cargo run -p api -- --write`, and a line in CHANGELOG.md".into())
}

/// Has rustdoc write what it knows of the library with all features, and returns the file.
fn documentation(here: &Path) -> Outcome<PathBuf> {
    let root = here.join("../..");
    let mut rustdoc = Command::new(env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    rustdoc
        .current_dir(&root)
        .env("RUSTDOC", here.join("rustdoc"))
        .env_remove("RUSTDOCFLAGS");
    rustdoc.args([
        "rustdoc",
        "--quiet",
        "--locked",
        "-p",
        "bevy_octree",
        "--lib",
        "--all-features",
    ]);
    rustdoc.args(["--", "-Z", "unstable-options", "--output-format", "json"]);
    if !rustdoc.status()?.success() {
        return Err("rustdoc has failed".into());
    }
    let target = env::var_os("CARGO_TARGET_DIR").map_or_else(|| root.join("target"), PathBuf::from);
    Ok(target.join("doc/bevy_octree.json"))
}

/// The items of a file of rustdoc's, in order, each in a line.
///
/// Of impls of other crates' traits, there is the impl alone: what is in it is the trait's. Types
/// of which `glam` has one for each kind of processor are named as if there were but one.
fn items(documentation: &Path) -> Outcome<Vec<String>> {
    let mut known: Value = serde_json::from_slice(&fs::read(documentation)?)?;
    let index = known["index"]
        .as_object_mut()
        .ok_or("rustdoc's file has no index")?;
    for item in index.values_mut() {
        if let Some(of_trait) = item["inner"]
            .get_mut("impl")
            .filter(|item| !item["trait"].is_null())
        {
            of_trait["items"] = Value::Array(Vec::new());
        }
    }
    let bare = documentation.with_extension("bare.json");
    fs::write(&bare, serde_json::to_vec(&known)?)?;
    let builder = Builder::from_rustdoc_json(&bare)
        .omit_blanket_impls(true)
        .omit_auto_trait_impls(true);
    let api = builder.build().map_err(|error| {
        format!("{error}\nIf this is a newer Rust: tools/api/Cargo.toml needs the public-api that goes with it")
    })?;
    let is_simd = |part: &str| ["sse2", "neon", "scalar", "wasm32"].contains(&part);
    let named = |item: String| {
        item.split("::")
            .filter(|part| !is_simd(part))
            .collect::<Vec<_>>()
            .join("::")
    };
    let mut items: Vec<_> = api.items().map(|item| named(item.to_string())).collect();
    items.retain(|item| !comes_with_another(item));
    items.dedup();
    Ok(items)
}

/// Whether a derive makes this impl beside another, which is listed: of `Reflect`, of `PartialEq`.
fn comes_with_another(item: &str) -> bool {
    let reflected = ["Reflect for", "FromReflect for"];
    let beside = |trait_path: &str| {
        !reflected
            .iter()
            .any(|listed| trait_path.contains(&format!("::{listed}")))
    };
    item.contains(" core::marker::StructuralPartialEq for ")
        || item
            .split_once(" bevy_reflect::")
            .is_some_and(|(start, path)| start.starts_with("impl") && beside(path))
}

//! Tables of the documentation that are to name all there is of something, read from the sources.

use std::{collections::BTreeSet, fs, path::Path};

fn read(file: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(file);
    fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// The names of the files in a folder, without their ending.
fn stems(folder: &str, ending: &str) -> BTreeSet<String> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(folder);
    let files = fs::read_dir(path).unwrap().map(|file| {
        let name = file.unwrap().file_name();
        name.to_string_lossy()
            .strip_suffix(ending)
            .map(str::to_owned)
    });
    files.flatten().collect()
}

/// The public methods in the `impl` blocks of a type, in text as rustfmt leaves it.
fn public_methods(text: &str, of: &str) -> Vec<String> {
    let mut inside = false;
    let mut methods = Vec::new();
    for line in text.lines() {
        if line.starts_with("impl") && !line.contains(" for ") {
            inside = line.contains(&format!(" {of}<"));
        } else if line.starts_with('}') {
            inside = false;
        }
        let method = line
            .strip_prefix("    pub fn ")
            .or_else(|| line.strip_prefix("    pub const fn "));
        if let (true, Some(method)) = (inside, method) {
            let end = method.find(['(', '<']).unwrap();
            methods.push(method[..end].to_owned());
        }
    }
    methods
}

#[test]
fn methods_are_found_in_text() {
    let text = "impl Ask<'_, '_> {\n    pub fn one(&self) {}\n    fn two(&self) {}\n}\nimpl Debug for \
                Ask<'_, '_> {\n    pub fn no() {}\n}\nimpl<'a> Other<'a> {\n    pub fn three() \
                {}\n}\nimpl Ask<'_, '_> {\n    pub const fn four<F>(&self) {}\n}";
    assert_eq!(public_methods(text, "Ask"), ["one", "four"]);
}

#[test]
fn every_question_is_in_the_index_of_questions() {
    let query = read("src/spatial_query/query.rs");
    let index = query.split_once("/// # All questions\n").unwrap().1;
    let index = index.split_once("/// # Exactness\n").unwrap().0;
    let methods: Vec<_> = stems("src/spatial_query", ".rs")
        .iter()
        .flat_map(|file| {
            let text = read(&format!("src/spatial_query/{file}.rs"));
            public_methods(&text, "SpatialQuery")
        })
        .collect();
    assert!(methods.len() > 40, "the sources are read: {methods:?}");
    let missing: Vec<_> = methods
        .iter()
        .filter(|method| !index.contains(&format!("[`{method}`](Self::{method})")))
        .collect();
    assert!(missing.is_empty(), "not in the index: {missing:?}");
}

#[test]
fn every_page_of_the_guide_is_listed() {
    let pages = stems("docs/guide", ".md");
    assert!(pages.len() > 5, "the pages are read: {pages:?}");
    let (guide, root, readme) = (read("src/guide.rs"), read("src/lib.rs"), read("README.md"));
    for page in pages {
        let includes = format!("include_str!(\"../docs/guide/{page}.md\")");
        assert!(guide.contains(&includes), "{page} is no page of `guide`");
        let link = format!("](docs/guide/{page}.md)");
        assert!(readme.contains(&link), "{page} is not in the README");
        let row = format!("//! | [`{page}`](guide::{page})");
        // What is there with a feature alone has no link.
        let bare = format!("//! | `{page}` ");
        assert!(
            root.contains(&row) || root.contains(&bare),
            "{page} is not in the crate's documentation"
        );
    }
}

#[test]
fn every_feature_is_in_all_tables_of_features() {
    let manifest = read("Cargo.toml");
    let features = manifest.split_once("\n[features]\n").unwrap().1;
    let features = features.split_once("\n[").unwrap().0;
    let features: Vec<_> = features
        .lines()
        .filter(|line| !line.starts_with('#'))
        .filter_map(|line| line.split_once(" = ").map(|(name, _)| name))
        .filter(|name| *name != "default")
        .collect();
    assert!(features.len() > 5, "the features are read: {features:?}");
    for (file, start) in [
        ("README.md", ""),
        ("src/lib.rs", "//! "),
        ("docs/guide/costs.md", ""),
    ] {
        let text = read(file);
        for feature in &features {
            let row = format!("\n{start}| `{feature}` |");
            assert!(text.contains(&row), "{feature} is not in {file}");
        }
    }
}

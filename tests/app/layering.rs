//! The house rules about imports, read from the sources themselves: no circle among files, none
//! among the rooms of `src/` or of a folder in it, nothing of the inner ring imports the outer, and
//! nobody imports the roof.

use std::{
    collections::{BTreeMap, BTreeSet},
    fs,
    path::Path,
};

/// The rooms of `src/` that know nothing of the ECS.
const INNER_RING: [&str; 5] = ["octree", "broad_phase", "narrow_phase", "parallel", "trace"];
/// The files that everything else is below of.
const ROOF: [&str; 2] = ["lib", "plugin"];

#[test]
fn no_file_is_part_of_a_circle() {
    let house = House::read(Path::new(env!("CARGO_MANIFEST_DIR")).join("src").as_path());
    assert!(house.files.len() > 100, "the sources are read");
    assert_eq!(circles(&house.imports()), Vec::<Vec<String>>::new());
}

#[test]
fn no_room_is_part_of_a_circle() {
    let house = House::read(Path::new(env!("CARGO_MANIFEST_DIR")).join("src").as_path());
    let folders: BTreeSet<_> = house
        .files
        .keys()
        .flat_map(|module| ancestors(module))
        .collect();
    for folder in folders {
        let rooms = house.imports_among_rooms(&folder);
        assert_eq!(
            circles(&rooms),
            Vec::<Vec<String>>::new(),
            "among the rooms of `{folder}`"
        );
    }
}

#[test]
fn the_inner_ring_imports_nothing_of_the_outer() {
    let house = House::read(Path::new(env!("CARGO_MANIFEST_DIR")).join("src").as_path());
    assert_eq!(violations_of_rings(&house), Vec::<String>::new());
}

#[test]
fn nobody_imports_the_roof() {
    let house = House::read(Path::new(env!("CARGO_MANIFEST_DIR")).join("src").as_path());
    assert_eq!(imports_of_the_roof(&house), Vec::<String>::new());
}

/// The rules are no use if they cannot be broken.
#[test]
fn planted_violations_are_found() {
    let house = House::of(&[
        (
            "lib",
            "mod plugin; mod octree; mod swept; pub mod filters; pub use filters::Layers;",
        ),
        ("plugin", "use crate::swept::Swept; pub struct Plugins;"),
        ("octree", "mod tree; mod node; pub use tree::Tree;"),
        (
            "octree::tree",
            "use super::node::{self, Node}; use crate::swept; pub struct Tree;",
        ),
        (
            "octree::node",
            "// use crate::plugin::Plugins;\npub struct Node { tree: Option<Box<super::Tree>> }",
        ),
        (
            "swept",
            "use crate::{filters::{Layers as L, mask}, plugin}; pub struct Swept;",
        ),
        (
            "filters",
            "mod layers; pub use layers::*; pub struct Filter(crate::swept::Swept);",
        ),
        (
            "filters::layers",
            "pub struct Layers; pub const fn mask() {} #[cfg(test)] mod tests { use crate::plugin; }",
        ),
    ]);
    let imports = house.imports();
    let of = |file: &str| imports[file].iter().map(String::as_str).collect::<Vec<_>>();
    assert_eq!(of("plugin"), ["swept"]);
    assert_eq!(of("octree::tree"), ["octree::node", "swept"]);
    assert_eq!(
        of("octree::node"),
        ["octree::tree"],
        "a re-export is followed, a comment is not read"
    );
    assert_eq!(
        of("swept"),
        ["filters::layers", "plugin"],
        "a glob is followed"
    );
    assert_eq!(
        of("filters::layers"),
        [""; 0],
        "tests may import what they like"
    );
    assert_eq!(
        circles(&imports),
        [
            vec!["octree::node", "octree::tree"],
            vec!["plugin", "swept"]
        ]
    );
    assert_eq!(
        circles(&house.imports_among_rooms("")),
        [["filters", "plugin", "swept"]]
    );
    assert_eq!(
        circles(&house.imports_among_rooms("octree")),
        [["node", "tree"]]
    );
    assert_eq!(violations_of_rings(&house), ["octree::tree imports swept"]);
    assert_eq!(imports_of_the_roof(&house), ["swept imports plugin"]);
}

fn violations_of_rings(house: &House) -> Vec<String> {
    let is_inner = |module: &str| INNER_RING.contains(&room(module, ""));
    pairs(&house.imports())
        .filter(|(from, to)| is_inner(from) && !is_inner(to))
        .map(|(from, to)| format!("{from} imports {to}"))
        .collect()
}

fn imports_of_the_roof(house: &House) -> Vec<String> {
    pairs(&house.imports())
        .filter(|(from, to)| !ROOF.contains(from) && ROOF.contains(to))
        .map(|(from, to)| format!("{from} imports {to}"))
        .collect()
}

/// What each file imports of the others.
type Imports = BTreeMap<String, BTreeSet<String>>;

fn pairs(imports: &Imports) -> impl Iterator<Item = (&str, &str)> {
    imports
        .iter()
        .flat_map(|(from, to)| to.iter().map(move |to| (from.as_str(), to.as_str())))
}

/// The folder of a module and all folders that it is in, the root (of no name) included.
fn ancestors(module: &str) -> Vec<String> {
    let parts: Vec<_> = module.split("::").collect();
    (0..parts.len())
        .map(|length| parts[..length].join("::"))
        .collect()
}

/// The part of a folder that a module is in.
fn room<'a>(module: &'a str, folder: &str) -> &'a str {
    let inside = module
        .strip_prefix(folder)
        .unwrap_or(module)
        .trim_start_matches("::");
    inside.split("::").next().unwrap_or_default()
}

/// The sets of at least two that import each other, directly or not: each sorted, in the order of
/// their first members.
fn circles(imports: &Imports) -> Vec<Vec<String>> {
    let reaches = |start: &str| {
        let (mut seen, mut open) = (BTreeSet::new(), vec![start]);
        while let Some(next) = open.pop() {
            for to in imports.get(next).into_iter().flatten() {
                if seen.insert(to.as_str()) {
                    open.push(to);
                }
            }
        }
        seen
    };
    let reached: BTreeMap<_, _> = imports
        .keys()
        .map(|file| (file.as_str(), reaches(file)))
        .collect();
    let circle_of = |file: &str| {
        let members = reached[file]
            .iter()
            .filter(|other| reached.get(*other).is_some_and(|back| back.contains(file)));
        members.map(ToString::to_string).collect::<Vec<_>>()
    };
    let circles: BTreeSet<_> = imports
        .keys()
        .map(|file| circle_of(file))
        .filter(|circle| circle.len() > 1)
        .collect();
    circles.into_iter().collect()
}

/// All modules of the crate that have a file.
struct House {
    files: BTreeMap<String, File>,
}

/// What a file says that matters here.
#[derive(Default)]
struct File {
    /// The names of what it defines.
    defines: BTreeSet<String>,
    /// By the name that they have here: what it imports, as a path from the root. Globs are under
    /// `*` and a number.
    uses: BTreeMap<String, Vec<String>>,
    /// Of these, the names that it only hands on.
    handed_on: BTreeSet<String>,
    /// Other paths that it mentions.
    mentions: Vec<Vec<String>>,
}

impl House {
    fn read(src: &Path) -> Self {
        let mut texts = Vec::new();
        read_folder(src, "", &mut texts);
        Self::of(
            &texts
                .iter()
                .map(|(module, text)| (module.as_str(), text.as_str()))
                .collect::<Vec<_>>(),
        )
    }

    fn of(texts: &[(&str, &str)]) -> Self {
        Self {
            files: texts
                .iter()
                .map(|(module, text)| ((*module).to_owned(), File::parse(module, text)))
                .collect(),
        }
    }

    fn imports(&self) -> Imports {
        let of = |module: &String, file: &File| {
            let used = file
                .uses
                .iter()
                .filter(|(name, _)| !file.handed_on.contains(*name))
                .map(|(_, path)| path);
            let paths = used.chain(&file.mentions);
            let mut to: BTreeSet<_> = paths.filter_map(|path| self.defining(path, 0)).collect();
            to.remove(module);
            to
        };
        self.files
            .iter()
            .map(|(module, file)| (module.clone(), of(module, file)))
            .collect()
    }

    /// The imports from one part of a folder to another.
    fn imports_among_rooms(&self, folder: &str) -> Imports {
        let inside = |module: &str| folder.is_empty() || module.starts_with(&format!("{folder}::"));
        let mut rooms = Imports::new();
        for (from, to) in pairs(&self.imports()).filter(|(from, to)| inside(from) && inside(to)) {
            let [from, to] = [from, to].map(|module| room(module, folder).to_owned());
            let others = rooms.entry(from.clone()).or_default();
            if from != to {
                others.insert(to);
            }
        }
        rooms
    }

    /// The module that defines what a path leads to; a module itself, if the path names one.
    fn defining(&self, path: &[String], depth: usize) -> Option<String> {
        // Re-exports that lead nowhere, or in a circle, belong to other crates, or do not compile.
        if depth > 8 {
            return None;
        }
        let mut length = path.len();
        while length > 0 && !self.files.contains_key(&path[..length].join("::")) {
            length -= 1;
        }
        let module = if length == 0 {
            "lib".to_owned()
        } else {
            path[..length].join("::")
        };
        let file = self.files.get(&module)?;
        let Some(name) = path.get(length) else {
            // A module by itself: a folder's list of modules stands for nothing that it defines.
            return Some(module);
        };
        if file.defines.contains(name) {
            return Some(module);
        }
        if let Some(target) = file.uses.get(name) {
            let rest = &path[length + 1..];
            return self.defining(&[target, rest].concat(), depth + 1);
        }
        let globs = file.uses.iter().filter(|(name, _)| name.starts_with('*'));
        globs
            .map(|(_, target)| [target, &path[length..]].concat())
            .find_map(|path| self.defining(&path, depth + 1))
    }
}

fn read_folder(folder: &Path, module: &str, texts: &mut Vec<(String, String)>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_stem().unwrap().to_str().unwrap();
        let inside = if module.is_empty() {
            name.to_owned()
        } else {
            format!("{module}::{name}")
        };
        if path.is_dir() {
            read_folder(&path, &inside, texts);
        } else if name == "tests" || name.ends_with("_tests") || name == "checked" {
            // Tests may import what they like.
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            texts.push((
                if name == "mod" {
                    module.to_owned()
                } else {
                    inside
                },
                fs::read_to_string(&path).unwrap(),
            ));
        }
    }
}

impl File {
    fn parse(module: &str, text: &str) -> Self {
        let tokens = without_tests(&tokens(text));
        let mut file = Self::default();
        let mut mentioned = BTreeSet::new();
        let mut place = 0;
        while place < tokens.len() {
            let token = tokens[place].as_str();
            match token {
                "use" => {
                    let end = place
                        + tokens[place..]
                            .iter()
                            .position(|token| token == ";")
                            .unwrap();
                    let known: BTreeSet<_> = file.uses.keys().cloned().collect();
                    file.add_uses(&origin(module), &tokens[place + 1..end], true);
                    if place > 0 && [")", "pub"].contains(&tokens[place - 1].as_str()) {
                        file.handed_on.extend(
                            file.uses
                                .keys()
                                .filter(|name| !known.contains(*name))
                                .cloned(),
                        );
                    }
                    place = end;
                }
                "struct" | "enum" | "trait" | "fn" | "const" | "static" | "type" | "union" => {
                    file.defines
                        .extend(tokens.get(place + 1).filter(|name| is_name(name)).cloned());
                }
                "!" if place > 0 && tokens[place - 1] == "macro_rules" => {
                    file.defines.extend(tokens.get(place + 1).cloned());
                }
                "crate" | "super" if tokens.get(place + 1).is_some_and(|token| token == "::") => {
                    let mut end = place + 1;
                    while tokens.get(end).is_some_and(|token| token == "::")
                        && is_name(&tokens[end + 1])
                    {
                        end += 2;
                    }
                    file.add_uses(&origin(module), &tokens[place..end], false);
                    place = end - 1;
                }
                name => drop(mentioned.insert(name)),
            }
            place += 1;
        }
        file.handed_on
            .retain(|name| !mentioned.contains(name.as_str()));
        file
    }

    /// Takes apart a tree of imports: those that give a name, or a path in the midst of the code.
    fn add_uses(&mut self, origin: &[String], tree: &[String], named: bool) {
        let mut path: Vec<String> = Vec::new();
        let mut place = 0;
        while place < tree.len() {
            match tree[place].as_str() {
                "::" => {}
                "{" => {
                    for branch in branches(&tree[place..]) {
                        let whole: Vec<_> = path
                            .iter()
                            .flat_map(|part| [part.clone(), "::".to_owned()])
                            .collect();
                        self.add_uses(origin, &[&whole, branch].concat(), named);
                    }
                    return;
                }
                "as" => {
                    let name = tree[place + 1].clone();
                    self.add_use(origin, &path, Some(name), named);
                    return;
                }
                part => path.push(part.to_owned()),
            }
            place += 1;
        }
        self.add_use(origin, &path, None, named);
    }

    fn add_use(&mut self, origin: &[String], path: &[String], alias: Option<String>, named: bool) {
        // What begins with a name is another crate, or, as in a re-export, a module below.
        let mut from_root = origin.to_vec();
        for part in path {
            match part.as_str() {
                "crate" => from_root.clear(),
                "super" => drop(from_root.pop()),
                "self" => {}
                part => from_root.push(part.to_owned()),
            }
        }
        if !named {
            self.mentions.push(from_root);
            return;
        }
        let last = from_root.last().cloned().unwrap_or_default();
        if last == "*" {
            from_root.pop();
            self.uses.insert(format!("*{}", self.uses.len()), from_root);
        } else {
            self.uses
                .insert(alias.filter(|name| name != "_").unwrap_or(last), from_root);
        }
    }
}

/// A module as a path from the root.
fn origin(module: &str) -> Vec<String> {
    module
        .split("::")
        .filter(|part| !part.is_empty() && *part != "lib")
        .map(str::to_owned)
        .collect()
}

/// The parts between the outermost braces of a tree of imports.
fn branches(tree: &[String]) -> Vec<&[String]> {
    let (mut depth, mut start, mut found) = (0, 1, Vec::new());
    for (place, token) in tree.iter().enumerate() {
        match token.as_str() {
            "{" => depth += 1,
            "}" if depth == 1 => {
                found.push(&tree[start..place]);
                break;
            }
            "}" => depth -= 1,
            "," if depth == 1 => {
                found.push(&tree[start..place]);
                start = place + 1;
            }
            _ => {}
        }
    }
    found.retain(|branch| !branch.is_empty());
    found
}

fn is_name(token: &str) -> bool {
    token.starts_with(|first: char| first.is_alphabetic() || first == '_')
}

/// Names, `::` and single marks; without comments and without what is quoted.
fn tokens(text: &str) -> Vec<String> {
    let mut tokens = Vec::new();
    let mut rest = text;
    while let Some(first) = rest.chars().next() {
        let length = if rest.starts_with("//") {
            rest.find('\n').unwrap_or(rest.len())
        } else if rest.starts_with("/*") {
            rest.find("*/").map_or(rest.len(), |end| end + 2)
        } else if rest.starts_with("r\"") || rest.starts_with("r#\"") {
            let (end, opening) = if rest.starts_with("r\"") {
                ("\"", 2)
            } else {
                ("\"#", 3)
            };
            rest[opening..]
                .find(end)
                .map_or(rest.len(), |at| opening + at + end.len())
        } else if first == '"' {
            end_of_quote(rest)
        } else if first == '\'' {
            // A lifetime is a mark and a name.
            match rest[1..].chars().nth(1) {
                Some('\'') => 2 + rest[1..].chars().next().map_or(0, char::len_utf8),
                _ if rest[1..].starts_with('\\') => 3 + rest[3..].find('\'').unwrap_or(0) + 1,
                _ => 1,
            }
        } else if first.is_alphanumeric() || first == '_' {
            let end = rest
                .find(|next: char| !next.is_alphanumeric() && next != '_')
                .unwrap_or(rest.len());
            tokens.push(rest[..end].to_owned());
            end
        } else {
            let mark = if rest.starts_with("::") {
                "::"
            } else {
                &rest[..first.len_utf8()]
            };
            if !first.is_whitespace() {
                tokens.push(mark.to_owned());
            }
            mark.len()
        };
        rest = &rest[length..];
    }
    tokens
}

fn end_of_quote(rest: &str) -> usize {
    let mut escaped = false;
    for (at, next) in rest.char_indices().skip(1) {
        match next {
            _ if escaped => escaped = false,
            '\\' => escaped = true,
            '"' => return at + 1,
            _ => {}
        }
    }
    rest.len()
}

/// All but the items that are for tests only.
fn without_tests(tokens: &[String]) -> Vec<String> {
    const MARK: [&str; 7] = ["#", "[", "cfg", "(", "test", ")", "]"];
    let mut kept = Vec::new();
    let mut place = 0;
    while place < tokens.len() {
        if tokens[place..]
            .iter()
            .zip(MARK)
            .filter(|(token, mark)| token == mark)
            .count()
            == MARK.len()
        {
            let mut depth = 0;
            place += MARK.len();
            while place < tokens.len() {
                match tokens[place].as_str() {
                    "{" | "(" | "[" => depth += 1,
                    "}" | ")" | "]" => depth -= 1,
                    _ => {}
                }
                place += 1;
                if depth == 0 && [";", "}"].contains(&tokens[place - 1].as_str()) {
                    break;
                }
            }
        } else {
            kept.push(tokens[place].clone());
            place += 1;
        }
    }
    kept
}

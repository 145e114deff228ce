//! The house rules about imports, read from the sources themselves: no circle among files, none
//! among the rooms of `src/` or of a folder in it, nothing of the inner ring imports the outer, and
//! nobody imports the roof; the floors are those of the map in `ARCHITECTURE.md`.

mod house;

use std::{
    collections::{BTreeMap, BTreeSet},
    fs,
    path::Path,
};

use house::{House, Imports, room};

/// The rooms of `src/` that are no part of an `App`: no systems, no components, no plugins of ours.
const INNER_RING: [&str; 5] = ["octree", "broad_phase", "narrow_phase", "parallel", "trace"];
/// What has no place in them. Resources may be derived there, for outer rooms to insert.
const OF_SYSTEMS: [&str; 6] = [
    "Component",
    "SystemParam",
    "Query<",
    "Plugin",
    "Commands",
    "ResMut",
];
/// The files that everything else is below of.
const ROOF: [&str; 2] = ["lib", "plugin"];

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn crate_house() -> House {
    House::read(&|file| fs::read_to_string(root().join("src").join(file)).ok())
}

#[test]
fn no_file_is_part_of_a_circle() {
    let house = crate_house();
    assert!(house.files().len() > 100, "the sources are read");
    assert_eq!(circles(&house.imports()), Vec::<Vec<String>>::new());
}

#[test]
fn no_room_is_part_of_a_circle() {
    let house = crate_house();
    let folders: BTreeSet<_> = house.files().into_iter().flat_map(ancestors).collect();
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
    assert_eq!(violations_of_rings(&crate_house()), [""; 0]);
}

#[test]
fn the_inner_ring_has_no_part_of_an_app() {
    assert_eq!(parts_of_an_app(&crate_house()), [""; 0]);
}

#[test]
fn nobody_imports_the_roof() {
    assert_eq!(imports_of_the_roof(&crate_house()), [""; 0]);
}

#[test]
fn nobody_imports_all_of_a_module() {
    assert_eq!(crate_house().globs(), [""; 0]);
}

/// An import that is not understood would be one that no rule sees.
#[test]
fn all_paths_lead_somewhere() {
    assert_eq!(crate_house().paths_to_nowhere(), [""; 0]);
}

#[test]
fn floors_are_as_in_the_map() {
    let text = fs::read_to_string(root().join("ARCHITECTURE.md")).unwrap();
    assert_eq!(violations_of_floors(&crate_house(), &text), [""; 0]);
}

/// The rules are no use if they cannot be broken.
#[test]
fn planted_violations_are_found() {
    let house = planted(&[
        (
            "lib.rs",
            "mod plugin; mod octree; mod swept; pub mod filters; pub use filters::Layers;",
        ),
        ("plugin.rs", "use crate::swept::Swept; pub struct Plugins;"),
        ("octree/mod.rs", "mod tree; mod node; pub use tree::Tree;"),
        (
            "octree/tree.rs",
            "use super::node::{self, Node}; use crate::swept; pub struct Tree;",
        ),
        (
            "octree/node.rs",
            "// use crate::plugin::Plugins;\npub struct Node { tree: Option<Box<super::Tree>> }",
        ),
        (
            "swept.rs",
            "use crate::{filters::{Layers as L, mask}, plugin}; pub struct Swept;",
        ),
        (
            "filters/mod.rs",
            "mod layers; pub use layers::*; pub struct Filter(crate::swept::Swept);",
        ),
        (
            "filters/layers.rs",
            "pub struct Layers; pub const fn mask() {} #[cfg(test)] mod tests { use crate::plugin; }",
        ),
    ]);
    let imports = house.imports();
    let of = |file: &str| imports[file].iter().map(String::as_str).collect::<Vec<_>>();
    assert_eq!(of("lib"), [""; 0], "the roof hands on what is below it");
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
    assert_eq!(house.globs(), [""; 0], "of a module's own");
    assert_eq!(house.paths_to_nowhere(), [""; 0]);
}

/// The ways to hide an import, one at a time in a house that keeps the rules: a file, what it says,
/// and what is found, among other things that it breaks.
#[test]
fn hidden_violations_are_found() {
    assert_eq!(all_violations("", ""), [""; 0]);
    let roof = ["roof: swept imports lib"];
    let ring = ["ring: octree::tree imports swept"];
    let plants: &[(&str, &str, &[&str])] = &[
        // Modules within the roof, and paths that lead nowhere.
        (
            "swept.rs",
            "use crate::plugins::Core; pub struct Swept;",
            &roof,
        ),
        (
            "swept.rs",
            "use crate::prelude::*; pub struct Swept;",
            &[
                "roof: swept imports lib",
                "glob: swept has crate::prelude::*",
            ],
        ),
        (
            "swept.rs",
            "pub struct Swept(crate::prelude::Layers);",
            &roof,
        ),
        ("swept.rs", "use crate::Plugins; pub struct Swept;", &roof),
        (
            "swept.rs",
            "use crate as house; pub struct Swept(house::layers::Layers);",
            &roof,
        ),
        (
            "swept.rs",
            "use crate::layers::Nothing; pub struct Swept;",
            &["nowhere: swept has crate::layers::Nothing"],
        ),
        (
            "swept.rs",
            "pub struct Swept(super::nothing::Nothing);",
            &["nowhere: swept has super::nothing::Nothing"],
        ),
        // What is handed on, but is not below.
        (
            "octree/mod.rs",
            "mod tree; pub use tree::Tree; pub use crate::swept::Swept;",
            &["ring: octree imports swept"],
        ),
        (
            "layers.rs",
            "pub(crate) use crate::plugin::Plugins; pub struct Layers;",
            &["roof: layers imports plugin"],
        ),
        // What stands behind something for tests, or looks like an import.
        (
            "octree/tree.rs",
            "pub struct Tree { #[cfg(test)] x: u8, y: crate::swept::Swept }",
            &ring,
        ),
        (
            "octree/tree.rs",
            "pub struct Tree { #[cfg(test)] x: u8 } use crate::swept::Swept;",
            &ring,
        ),
        (
            "octree/tree.rs",
            "pub struct Tree; enum A { #[cfg(test)] B, C(crate::swept::Swept) }",
            &ring,
        ),
        (
            "octree/tree.rs",
            "pub struct Tree; #[cfg(test)] fn f<A, B>() { crate::plugin::f() } fn g() { crate::swept::Swept; }",
            &ring,
        ),
        (
            "octree/tree.rs",
            "pub struct Tree; fn f<'a>() -> impl Sized + use<'a> { crate::swept::Swept }",
            &ring,
        ),
        (
            "octree/tree.rs",
            "pub struct Tree; fn f<'a>() -> impl Sized + use<'a> { crate::swept::Swept; 1 }",
            &ring,
        ),
        // Files with names like those of tests.
        (
            "octree/mod.rs",
            "mod tree; mod checked; pub use tree::Tree;",
            &["ring: octree::checked imports swept"],
        ),
        (
            "octree/mod.rs",
            "mod tree; mod tree_tests; pub use tree::Tree;",
            &["ring: octree::tree_tests imports swept"],
        ),
        (
            "octree/mod.rs",
            "mod tree; mod tests; pub use tree::Tree;",
            &["ring: octree::tests imports swept"],
        ),
        (
            "octree/mod.rs",
            "mod tree; #[cfg(test)] mod tests; pub use tree::Tree;",
            &[],
        ),
        // Floors.
        (
            "layers.rs",
            "use crate::swept::Swept; pub struct Layers;",
            &[
                "floor: layers on 1 imports swept on 2",
                "floor: layers is on 3",
            ],
        ),
        ("swept.rs", "pub struct Swept;", &["floor: swept is on 1"]),
        (
            "lib.rs",
            "mod plugin; mod octree; mod swept; mod layers; mod attic;",
            &["floor: attic has no floor"],
        ),
        // Parts of an `App` in the inner ring.
        (
            "octree/tree.rs",
            "use bevy::prelude::*; #[derive(Component)] pub struct Tree;",
            &["app: octree::tree has Component"],
        ),
        (
            "octree/tree.rs",
            "pub struct Tree; fn f(all: Query<&Tree>) {}",
            &["app: octree::tree has Query<"],
        ),
        ("octree/tree.rs", "pub struct Tree; struct Query;", &[]),
        (
            "octree/tree.rs",
            "pub struct Tree; impl bevy::app::Plugin for Tree {}",
            &["app: octree::tree has Plugin"],
        ),
        (
            "octree/tree.rs",
            "#[derive(SystemParam)] pub struct Tree;",
            &["app: octree::tree has SystemParam"],
        ),
        // Names that come by a module, or by the root.
        (
            "octree/tree.rs",
            "pub struct Tree; fn f() { crate::sweep!() }",
            &ring,
        ),
        (
            "octree/tree.rs",
            "use super::*; pub struct Tree;",
            &["glob: octree::tree has super::*"],
        ),
        (
            "octree/mod.rs",
            "mod tree; mod node; pub use tree::Tree; fn f() { node::Node::new() }",
            &["circle: octree, octree::node"],
        ),
        (
            "octree/tree.rs",
            "use super::node::Node; pub struct Tree(Node);",
            &["circle: octree::node, octree::tree"],
        ),
    ];
    for (file, text, expected) in plants {
        let found = all_violations(file, text);
        assert_eq!(found.is_empty(), expected.is_empty(), "{text}: {found:?}");
        for violation in *expected {
            assert!(found.iter().any(|of| of == violation), "{text}: {found:?}");
        }
    }
}

/// What is found in a small house, of which one file says something else.
fn all_violations(file: &str, text: &str) -> Vec<String> {
    const MAP: &str = "```text\nsrc/  floor  what\n  lib.rs, plugin.rs  3  all\n  swept.rs  2\n    part\n  layers.rs  1\ninner ring\n  octree/  1\n```";
    let house = House::read(&|asked| {
        let said = match asked {
            _ if asked == file => text,
            "lib.rs" => {
                "mod plugin; mod octree; mod swept; mod layers; pub use plugin::Plugins; \
                pub mod plugins { pub use crate::plugin::Core; } \
                pub mod prelude { pub use crate::{layers::Layers, octree::Tree}; }"
            }
            "plugin.rs" => {
                "use crate::{octree, swept::Swept}; pub struct Plugins; pub struct Core;"
            }
            "octree/mod.rs" => "mod tree; mod node; pub use tree::Tree;",
            "octree/tree.rs" => "pub struct Tree;",
            "octree/node.rs" => "use crate::octree; pub struct Node(octree::Tree);",
            "octree/checked.rs" | "octree/tree_tests.rs" | "octree/tests.rs" => {
                "use crate::swept::Swept;"
            }
            "swept.rs" => {
                "use crate::layers::Layers; pub struct Swept; #[macro_export] macro_rules! sweep { () => {} }"
            }
            "layers.rs" => "pub struct Layers;",
            "attic.rs" => "",
            _ => return None,
        };
        Some(said.to_owned())
    });
    let circles = circles(&house.imports());
    let found = [
        ("circle", circles.iter().map(|of| of.join(", ")).collect()),
        ("ring", violations_of_rings(&house)),
        ("roof", imports_of_the_roof(&house)),
        ("glob", house.globs()),
        ("nowhere", house.paths_to_nowhere()),
        ("app", parts_of_an_app(&house)),
        ("floor", violations_of_floors(&house, MAP)),
    ];
    found
        .into_iter()
        .flat_map(|(rule, of)| of.into_iter().map(move |what| format!("{rule}: {what}")))
        .collect()
}

fn planted(files: &[(&str, &str)]) -> House {
    House::read(&|asked| {
        let (_, text) = files.iter().find(|(file, _)| *file == asked)?;
        Some((*text).to_owned())
    })
}

fn violations_of_rings(house: &House) -> Vec<String> {
    pairs(&house.imports())
        .filter(|(from, to)| is_inner(from) && !is_inner(to))
        .map(|(from, to)| format!("{from} imports {to}"))
        .collect()
}

fn parts_of_an_app(house: &House) -> Vec<String> {
    house.words(&OF_SYSTEMS, &is_inner)
}

fn is_inner(module: &str) -> bool {
    INNER_RING.contains(&room(module, ""))
}

fn imports_of_the_roof(house: &House) -> Vec<String> {
    pairs(&house.imports())
        .filter(|(from, to)| !ROOF.contains(from) && ROOF.contains(to))
        .map(|(from, to)| format!("{from} imports {to}"))
        .collect()
}

fn violations_of_floors(house: &House, text: &str) -> Vec<String> {
    let (floors, mut violations) = (floors(text), Vec::new());
    let mut rooms = house.imports_among_rooms("");
    for room in floors.keys().filter(|room| !rooms.contains_key(*room)) {
        violations.push(format!("{room} is in the map alone"));
    }
    for room in rooms.keys().filter(|room| !floors.contains_key(*room)) {
        violations.push(format!("{room} has no floor"));
    }
    // The files of the roof are one room.
    let [lib, plugin] = ROOF.map(|room| rooms.remove(room).unwrap_or_default());
    let roof = lib.union(&plugin).filter(|to| !ROOF.contains(&to.as_str()));
    rooms.insert(ROOF[1].to_owned(), roof.cloned().collect());
    for (from, to) in pairs(&rooms) {
        if let (Some(here), Some(there)) = (floors.get(from), floors.get(to))
            && there >= here
        {
            violations.push(format!("{from} on {here} imports {to} on {there}"));
        }
    }
    for (room, imports) in &rooms {
        let highest = imports.iter().filter_map(|to| floors.get(to)).max();
        let floor = highest.map_or(1, |highest| highest + 1);
        if floors.get(room).is_some_and(|told| *told != floor) {
            violations.push(format!("{room} is on {floor}"));
        }
    }
    violations
}

/// The rooms in the map, each with its floor: lines of names with commas, a number, and words.
fn floors(text: &str) -> BTreeMap<String, u32> {
    let map = text.split("```").find(|block| block.contains("floor  "));
    let lines = map.expect("there is a map").lines();
    // What is further in is a part of a room.
    let lines = lines.filter_map(|line| line.strip_prefix("  ").filter(|of| !of.starts_with(' ')));
    lines
        .flat_map(|line| {
            let words: Vec<_> = line.split_whitespace().collect();
            let number = words.iter().position(|word| word.parse::<u32>().is_ok());
            let number = number.unwrap_or_else(|| panic!("no floor in: {line}"));
            let floor: u32 = words[number].parse().unwrap();
            words[..number]
                .iter()
                .map(|name| name.trim_end_matches(',').trim_end_matches('/'))
                .map(|name| (name.trim_end_matches(".rs").to_owned(), floor))
                .collect::<Vec<_>>()
        })
        .collect()
}

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

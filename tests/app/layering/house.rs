//! The sources as modules, and what each file of them imports.

use std::collections::{BTreeMap, BTreeSet};

/// What each file imports of the others.
pub type Imports = BTreeMap<String, BTreeSet<String>>;

/// All modules of the crate but those for tests, by their path; the root has no name.
#[derive(Default)]
pub struct House {
    modules: BTreeMap<String, Module>,
    /// Macros that are exported, which are names of the root, and where they are written.
    macros: BTreeMap<String, String>,
}

/// What a module says that matters here.
#[derive(Default)]
struct Module {
    /// The file that it is in: the path of the file's module, or `lib`.
    file: String,
    /// The names of what it defines.
    defines: BTreeSet<String>,
    uses: Vec<Use>,
    /// Other paths that it mentions.
    mentions: Vec<Vec<String>>,
    /// All names in it, and whether an angle bracket follows.
    words: BTreeSet<(String, bool)>,
}

struct Use {
    /// The name that it has here; `*` if it is all names of something.
    name: String,
    path: Vec<String>,
    /// Whether it is only for others.
    is_handed_on: bool,
}

/// Where a path leads.
#[derive(Clone, PartialEq)]
enum Found {
    /// To a module by itself, which is in a file.
    Module(String),
    /// To something that is defined in a file.
    Item(String),
    /// To another crate, or to what is known where it is mentioned alone.
    Outside,
    Nowhere,
}

impl House {
    /// Reads `lib.rs` and all modules that are declared from there.
    pub fn read(text_of: &dyn Fn(&str) -> Option<String>) -> Self {
        let mut house = Self::default();
        house.read_file("", "lib.rs", text_of);
        house
    }

    fn read_file(&mut self, path: &str, file: &str, text_of: &dyn Fn(&str) -> Option<String>) {
        let text = text_of(file).unwrap_or_else(|| panic!("there is no {file}"));
        let name = if path.is_empty() { "lib" } else { path };
        let tokens = without_tests(&tokens(&text));
        let mut open = vec![(path.to_owned(), tokens)];
        while let Some((path, tokens)) = open.pop() {
            let module = self.modules.entry(path.clone()).or_default();
            name.clone_into(&mut module.file);
            let children = module.parse(&tokens);
            if tokens.iter().any(|token| token == "macro_export") {
                let macros = tokens.windows(3).filter(|of| of[0] == "macro_rules");
                self.macros
                    .extend(macros.map(|of| (of[2].clone(), name.to_owned())));
            }
            for child in children {
                let inside = join(&path, &child.name);
                match (child.body, child.place) {
                    (Some(body), _) => open.push((inside, body)),
                    (None, Some(place)) => {
                        let folder = file.rsplit_once('/').map_or("", |(folder, _)| folder);
                        let file = format!("{folder}/{place}");
                        self.read_file(&inside, file.trim_start_matches('/'), text_of);
                    }
                    (None, None) => {
                        let folder = inside.replace("::", "/");
                        let files = [format!("{folder}.rs"), format!("{folder}/mod.rs")];
                        let file = files.iter().find(|file| text_of(file).is_some());
                        let file = file.unwrap_or_else(|| panic!("there is no file for {inside}"));
                        self.read_file(&inside, file, text_of);
                    }
                }
            }
        }
    }

    pub fn files(&self) -> BTreeSet<&str> {
        self.modules
            .values()
            .map(|module| module.file.as_str())
            .collect()
    }

    pub fn imports(&self) -> Imports {
        let mut imports: Imports = self
            .files()
            .into_iter()
            .map(|file| (file.to_owned(), BTreeSet::new()))
            .collect();
        for (from, to) in self.paths().filter_map(|(from, _, found)| match found {
            Found::Module(to) | Found::Item(to) if to != from => Some((from, to)),
            _ => None,
        }) {
            imports.get_mut(from).unwrap().insert(to);
        }
        imports
    }

    /// The imports from one part of a folder to another.
    pub fn imports_among_rooms(&self, folder: &str) -> Imports {
        let inside = |module: &str| folder.is_empty() || module.starts_with(&format!("{folder}::"));
        let mut rooms = Imports::new();
        for (from, to) in self.imports() {
            if inside(&from) {
                let from = room(&from, folder);
                let to = to.iter().filter(|to| inside(to));
                let others = to.map(|to| room(to, folder)).filter(|to| *to != from);
                rooms
                    .entry(from.to_owned())
                    .or_default()
                    .extend(others.map(str::to_owned));
            }
        }
        rooms
    }

    /// Paths that begin in this crate, and that the rules can say nothing about.
    pub fn paths_to_nowhere(&self) -> Vec<String> {
        self.paths()
            .filter(|(_, _, found)| *found == Found::Nowhere)
            .map(|(from, path, _)| format!("{from} has {path}"))
            .collect()
    }

    /// Imports of all that a module has, but by those who hand on what is their own.
    pub fn globs(&self) -> Vec<String> {
        self.paths()
            .filter(|(_, path, found)| path.ends_with('*') && matches!(found, Found::Module(_)))
            .map(|(from, path, _)| format!("{from} has {path}"))
            .collect()
    }

    /// Where one of these words is in the files that are asked for; one that ends in an angle
    /// bracket counts if there is one.
    pub fn words(&self, words: &[&str], of: &dyn Fn(&str) -> bool) -> Vec<String> {
        let asked = self.modules.values().filter(|module| of(&module.file));
        asked
            .flat_map(|module| words.iter().map(move |word| (module, *word)))
            .filter(|(module, word)| match word.strip_suffix('<') {
                Some(word) => module.words.contains(&(word.to_owned(), true)),
                None => {
                    [true, false].map(|at| module.words.contains(&((*word).to_owned(), at)))
                        != [false; 2]
                }
            })
            .map(|(module, word)| format!("{} has {word}", module.file))
            .collect()
    }

    /// All imports, and paths in the code: the file, the path, and where it leads. Without what a
    /// file only hands on of the modules below it.
    fn paths(&self) -> impl Iterator<Item = (&str, String, Found)> {
        self.modules.iter().flat_map(move |(at, module)| {
            let from = module.file.as_str();
            let uses = module.uses.iter().filter_map(move |import| {
                let found = self.resolve(at, &import.path, 0);
                let is_below = match &found {
                    Found::Module(to) | Found::Item(to) => {
                        from == "lib" || to.starts_with(&format!("{from}::"))
                    }
                    _ => false,
                };
                let glob = if import.name == "*" { "::*" } else { "" };
                let path = import.path.join("::") + glob;
                (!import.is_handed_on || !is_below).then_some((from, path, found))
            });
            let mentions = module
                .mentions
                .iter()
                .map(move |path| (from, path.join("::"), self.resolve(at, path, 0)));
            uses.chain(mentions)
        })
    }

    /// Where a path leads that a module mentions.
    fn resolve(&self, at: &str, path: &[String], depth: usize) -> Found {
        // A name of another crate that has the same name here.
        if depth > 8 || path.is_empty() {
            return Found::Outside;
        }
        match path[0].as_str() {
            "crate" => self.walk("", &path[1..], depth),
            "self" | "super" => self.walk(at, path, depth),
            name if self.knows(at, name) => self.walk(at, path, depth),
            _ => Found::Outside,
        }
    }

    fn knows(&self, at: &str, name: &str) -> bool {
        let module = &self.modules[at];
        self.modules.contains_key(&join(at, name))
            || module.defines.contains(name)
            || module.uses.iter().any(|import| import.name == name)
    }

    fn walk(&self, at: &str, path: &[String], depth: usize) -> Found {
        let module = &self.modules[at];
        let Some(name) = path.first() else {
            return Found::Module(module.file.clone());
        };
        let rest = &path[1..];
        match name.as_str() {
            "self" => return self.walk(at, rest, depth),
            "super" if at.is_empty() => return Found::Nowhere,
            "super" => {
                let parent = at.rsplit_once("::").map_or("", |(parent, _)| parent);
                return self.walk(parent, rest, depth);
            }
            _ => {}
        }
        let child = join(at, name);
        if self.modules.contains_key(&child) {
            return self.walk(&child, rest, depth);
        }
        if let Some(file) = self.macros.get(name).filter(|_| at.is_empty()) {
            return Found::Item(file.clone());
        }
        if module.defines.contains(name) {
            return Found::Item(module.file.clone());
        }
        let through = |import: &Use, path: &[String]| {
            self.resolve(at, &[&import.path, path].concat(), depth + 1)
        };
        let named = module.uses.iter().filter(|import| import.name == *name);
        let globs = module.uses.iter().filter(|import| import.name == "*");
        let found = named
            .map(|import| through(import, rest))
            .find(|found| *found != Found::Nowhere)
            .or_else(|| {
                globs
                    .map(|import| through(import, path))
                    .find(|found| matches!(found, Found::Module(_) | Found::Item(_)))
            });
        match found {
            // Who asks the roof imports the roof, whatever it hands on.
            Some(_) if module.file == "lib" => Found::Item("lib".to_owned()),
            found => found.unwrap_or(Found::Nowhere),
        }
    }
}

/// The part of a folder that a module is in.
pub fn room<'a>(module: &'a str, folder: &str) -> &'a str {
    let inside = module
        .strip_prefix(folder)
        .unwrap_or(module)
        .trim_start_matches("::");
    inside.split("::").next().unwrap_or_default()
}

fn join(module: &str, name: &str) -> String {
    format!("{module}::{name}")
        .trim_start_matches("::")
        .to_owned()
}

/// A module that another declares.
struct Child {
    name: String,
    body: Option<Vec<String>>,
    /// The file that an attribute says it is in.
    place: Option<String>,
}

impl Module {
    fn parse(&mut self, tokens: &[String]) -> Vec<Child> {
        const NONE: &str = "";
        let token = |place: usize| tokens.get(place).map_or(NONE, String::as_str);
        let before = |place: usize, by: usize| place.checked_sub(by).map_or(NONE, token);
        let (mut children, mut mentioned) = (Vec::new(), BTreeSet::new());
        let (mut place, mut depth, mut file) = (0, 0, None);
        let mut is_in_macro = false;
        while place < tokens.len() {
            let next = token(place + 1);
            match token(place) {
                "use" if next != "<" => {
                    let end = tokens[place..].iter().position(|token| token == ";");
                    let end = place + end.expect("an import has an end");
                    let is_public = [")", "pub"].contains(&before(place, 1));
                    self.add_uses(&tokens[place + 1..end], is_public);
                    place = end;
                }
                "mod" if is_name(next) && token(place + 2) == ";" => {
                    children.push(Child {
                        name: next.to_owned(),
                        body: None,
                        place: file.take(),
                    });
                    place += 2;
                }
                "mod" if is_name(next) && token(place + 2) == "{" => {
                    let end = end_of_brackets(tokens, place + 2);
                    children.push(Child {
                        name: next.to_owned(),
                        body: Some(tokens[place + 3..end - 1].to_vec()),
                        place: None,
                    });
                    place = end - 1;
                }
                "path" if before(place, 1) == "[" && next == "=" => {
                    file = Some(token(place + 2).trim_matches('"').to_owned());
                }
                "struct" | "enum" | "trait" | "fn" | "const" | "static" | "type" | "union"
                    if depth == 0 && is_name(next) =>
                {
                    self.defines.insert(next.to_owned());
                }
                "!" if before(place, 1) == "macro_rules" => {
                    self.defines.insert(next.to_owned());
                }
                // What a macro writes may have any name that it is given.
                "!" if depth == 0 && is_name(before(place, 1)) => {
                    is_in_macro = ["{", "(", "["].contains(&next);
                }
                "{" | "(" | "[" => depth += 1,
                "}" | ")" | "]" => {
                    depth -= 1;
                    is_in_macro &= depth > 0;
                }
                // A method, or a part of a path that began before.
                name if is_name(name) && next == "::" && !is_inside(tokens, place) => {
                    let mut end = place + 1;
                    while token(end) == "::" && is_name(token(end + 1)) {
                        end += 2;
                    }
                    mentioned.insert(name);
                    let names = tokens[place..end].iter().filter(|token| is_name(token));
                    self.mentions.push(names.cloned().collect());
                    self.add_words(&tokens[place..=end.min(tokens.len() - 1)]);
                    place = end - 1;
                }
                name if is_name(name) => {
                    if is_in_macro && depth == 1 {
                        self.defines.insert(name.to_owned());
                    }
                    mentioned.insert(name);
                    self.add_words(&tokens[place..=(place + 1).min(tokens.len() - 1)]);
                }
                _ => {}
            }
            place += 1;
        }
        for import in &mut self.uses {
            import.is_handed_on &= !mentioned.contains(import.name.as_str());
        }
        children
    }

    fn add_words(&mut self, tokens: &[String]) {
        let names = tokens
            .windows(2)
            .map(|pair| (pair[0].clone(), pair[1] == "<"));
        self.words.extend(names.filter(|(name, _)| is_name(name)));
    }

    /// Takes apart a tree of imports.
    fn add_uses(&mut self, tree: &[String], is_public: bool) {
        let mut path: Vec<String> = Vec::new();
        let mut alias = None;
        self.add_words(&[tree, &[String::new()]].concat());
        for (place, token) in tree.iter().enumerate() {
            match token.as_str() {
                "{" => {
                    for branch in branches(&tree[place..]) {
                        self.add_uses(&[&tree[..place], branch].concat(), is_public);
                    }
                    return;
                }
                "as" => {
                    alias = tree.get(place + 1).cloned();
                    break;
                }
                part if is_name(part) || part == "*" => path.push(part.to_owned()),
                _ => {}
            }
        }
        // `{self}` is the module itself.
        if path.len() > 1 && path.last().is_some_and(|last| last == "self") {
            path.pop();
        }
        let name = alias.or_else(|| path.last().cloned()).unwrap_or_default();
        if name == "*" {
            path.pop();
        }
        self.uses.push(Use {
            name,
            path,
            is_handed_on: is_public,
        });
    }
}

/// Whether a name is what follows `::` or `.`, or a name that a macro is given.
fn is_inside(tokens: &[String], place: usize) -> bool {
    place > 0
        && match tokens[place - 1].as_str() {
            "::" | "." => true,
            "$" => tokens[place] != "crate",
            _ => false,
        }
}

/// The place behind the bracket that closes the one at `start`.
fn end_of_brackets(tokens: &[String], start: usize) -> usize {
    let mut depth = 0;
    for (place, token) in tokens.iter().enumerate().skip(start) {
        match token.as_str() {
            "{" | "(" | "[" => depth += 1,
            "}" | ")" | "]" if depth == 1 => return place + 1,
            "}" | ")" | "]" => depth -= 1,
            _ => {}
        }
    }
    tokens.len()
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

/// Names, `::`, single marks and plain quotes; without comments, lifetimes, characters and raw
/// quotes.
fn tokens(text: &str) -> Vec<String> {
    let mut tokens = Vec::new();
    let mut rest = text;
    while let Some(first) = rest.chars().next() {
        let length = if rest.starts_with("//") {
            rest.find('\n').unwrap_or(rest.len())
        } else if rest.starts_with("/*") {
            rest.find("*/").map_or(rest.len(), |end| end + 2)
        } else if let Some(length) = length_of_raw_quote(rest) {
            length
        } else if first == '"' {
            let end = end_of_quote(rest);
            tokens.push(rest[..end].to_owned());
            end
        } else if first == '\'' {
            match rest[1..].chars().nth(1) {
                Some('\'') => 2 + rest[1..].chars().next().map_or(0, char::len_utf8),
                _ if rest[1..].starts_with('\\') => 3 + rest[3..].find('\'').unwrap_or(0) + 1,
                // A lifetime.
                _ => 1 + length_of_name(&rest[1..]),
            }
        } else if first.is_alphanumeric() || first == '_' {
            let end = length_of_name(rest);
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

fn length_of_name(rest: &str) -> usize {
    rest.find(|next: char| !next.is_alphanumeric() && next != '_')
        .unwrap_or(rest.len())
}

fn length_of_raw_quote(rest: &str) -> Option<usize> {
    let inside = rest.strip_prefix('r')?.trim_start_matches('#');
    let inside = inside.strip_prefix('"')?;
    let opening = rest.len() - inside.len();
    let end = format!("\"{}", "#".repeat(opening - 2));
    Some(
        inside
            .find(&end)
            .map_or(rest.len(), |at| opening + at + end.len()),
    )
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

/// All but what is for tests only: items, fields, variants, arms and statements.
fn without_tests(tokens: &[String]) -> Vec<String> {
    let is = |place: usize, mark| tokens.get(place).is_some_and(|token| token == mark);
    let mut kept = Vec::new();
    let mut place = 0;
    while place < tokens.len() {
        let mut item = place;
        while is(item, "#") && is(item + 1, "[") {
            item = end_of_brackets(tokens, item + 1);
        }
        let attributes = tokens[place..item].concat();
        if ["#[cfg(test)]", "#[cfg(all(test,"]
            .iter()
            .any(|mark| attributes.contains(mark))
        {
            place = end_of_item(tokens, item);
        } else {
            let end = item.max(place + 1);
            kept.extend_from_slice(&tokens[place..end]);
            place = end;
        }
    }
    kept
}

/// The place behind what begins at `start`, which ends at the latest where that which it is in does.
fn end_of_item(tokens: &[String], start: usize) -> usize {
    const ITEMS: [&str; 14] = [
        "async", "const", "enum", "extern", "fn", "impl", "let", "mod", "static", "struct",
        "trait", "type", "unsafe", "use",
    ];
    let mut kind = start;
    if tokens.get(kind).is_some_and(|token| token == "pub") {
        kind += 1;
        if tokens.get(kind).is_some_and(|token| token == "(") {
            kind = end_of_brackets(tokens, kind);
        }
    }
    // A comma ends a field, but not the parameters of an item.
    let is_item = tokens
        .get(kind)
        .is_some_and(|token| ITEMS.contains(&token.as_str()));
    let mut place = start;
    while let Some(token) = tokens.get(place) {
        match token.as_str() {
            "{" => {
                place = end_of_brackets(tokens, place);
                // The list of an import ends before its semicolon.
                if tokens.get(place).is_none_or(|token| token != ";") {
                    return place;
                }
            }
            "(" | "[" => place = end_of_brackets(tokens, place),
            "}" | ")" | "]" => return place,
            ";" => return place + 1,
            "," if !is_item => return place + 1,
            _ => place += 1,
        }
    }
    place
}

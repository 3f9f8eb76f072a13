//! Nobody imports each other: within every crate neither files nor folders form a circle. (Between
//! crates cargo sees to that.)
//!
//! What counts is code outside `#[cfg(test)]`: `use` declarations, and paths that begin with `crate`,
//! `super`, `self` or a submodule's name. A `pub use` of something that the file does not use itself
//! is a signpost, not an import, and is followed to where the thing is defined.

#![allow(clippy::unwrap_used, reason = "a panic is how a test fails")]

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use proc_macro2::{TokenStream, TokenTree};
use quote::ToTokens;
use syn::{Item, UseTree, Visibility};

/// A module's path from the crate's root, which is empty.
type Module = Vec<String>;
type Graph = BTreeMap<String, BTreeSet<String>>;

/// A file and what it refers to.
#[derive(Default)]
struct Source {
    /// Names that it brings in, and the absolute paths that they stand for.
    imported: BTreeMap<String, Module>,
    /// Those of them that it hands on.
    handed_on: BTreeSet<String>,
    /// Absolute paths in its code.
    paths: Vec<Module>,
    /// Single names in its code.
    names: BTreeSet<String>,
}

#[test]
fn no_file_and_no_folder_imports_what_imports_it() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut crates: Vec<PathBuf> = vec![root.join("shared/src"), root.join("firmware/src")];
    for entry in fs::read_dir(root.join("host")).unwrap() {
        crates.push(entry.unwrap().path().join("src"));
    }
    let mut circles = Vec::new();
    let mut files = 0;
    for folder in crates.iter().filter(|folder| folder.exists()) {
        let sources = read(folder);
        files += sources.len();
        let name = folder.strip_prefix(root).unwrap().display().to_string();
        circles.extend(found_in(&sources).map(|circle| format!("{name}: {circle}")));
    }
    assert!(files > 250, "only {files} files were found");
    assert!(circles.is_empty(), "\n{}", circles.join("\n"));
}

#[test]
fn circles_are_found_and_signposts_are_none() {
    let sources = |files: &[(&str, &str)]| -> BTreeMap<Module, Source> {
        let children = files.iter().map(|(module, _)| split(module)).collect();
        let parse = |(module, text): &(&str, &str)| {
            let module = split(module);
            let source = Source::parse(&module, text, &children);
            (module, source)
        };
        files.iter().map(parse).collect()
    };
    let found = |files: &[(&str, &str)]| found_in(&sources(files)).collect::<Vec<_>>();
    assert_eq!(
        found(&[
            ("", "mod a; mod b; pub use a::A;"),
            ("a", "use super::b::B; pub struct A(B);"),
            ("b", "pub struct B; fn f() { crate::A; }"),
        ]),
        ["files a, b"]
    );
    assert_eq!(
        found(&[
            ("", "mod a; pub use a::A; pub const C: u8 = 0;"),
            (
                "a",
                "use super::C; pub struct A; #[cfg(test)] mod tests { use crate::A; }"
            ),
        ]),
        [""; 0]
    );
    assert_eq!(
        found(&[
            ("", "mod a; use a::A; pub const C: A = A;"),
            ("a", "use super::C; pub struct A;"),
        ]),
        ["files (root), a"]
    );
    assert_eq!(
        found(&[
            ("", "mod x; mod y;"),
            ("x", "mod p; mod q;"),
            ("x::p", "use crate::y::r::R;"),
            ("x::q", "pub struct Q;"),
            ("y", "pub mod r; mod s;"),
            ("y::r", "pub struct R;"),
            ("y::s", "use crate::x::q::Q;"),
        ]),
        ["folders x, y"]
    );
}

/// All files below a crate's `src`.
fn read(folder: &Path) -> BTreeMap<Module, Source> {
    let mut texts = BTreeMap::new();
    collect(folder, &mut Vec::new(), &mut texts);
    let modules: BTreeSet<Module> = texts.keys().cloned().collect();
    let parse = |(module, text): (Module, String)| {
        let source = Source::parse(&module, &text, &modules);
        (module, source)
    };
    texts.into_iter().map(parse).collect()
}

fn collect(folder: &Path, module: &mut Module, texts: &mut BTreeMap<Module, String>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let stem = path.file_stem().unwrap().to_string_lossy().into_owned();
        if path.is_dir() {
            module.push(stem);
            collect(&path, module, texts);
            module.pop();
        } else if path.extension().is_some_and(|e| e == "rs") {
            let mut module = module.clone();
            match stem.as_str() {
                "tests" => continue,
                "mod" | "lib" | "main" => {}
                _ => module.push(stem),
            }
            // A test module's own files stand in a folder `tests`.
            if !module.iter().any(|name| name == "tests") {
                texts.insert(module, fs::read_to_string(&path).unwrap());
            }
        }
    }
}

fn split(path: &str) -> Module {
    path.split("::")
        .filter(|s| !s.is_empty())
        .map(String::from)
        .collect()
}

impl Source {
    fn parse(module: &Module, text: &str, modules: &BTreeSet<Module>) -> Self {
        let mut source = Self::default();
        let file = syn::parse_file(text).unwrap_or_else(|e| panic!("{module:?}: {e}"));
        source.items(&file.items, module, modules);
        source
    }

    fn items(&mut self, items: &[Item], module: &Module, modules: &BTreeSet<Module>) {
        for item in items {
            if is_test(item) {
                continue;
            }
            match item {
                Item::Use(declaration) => {
                    let on = !matches!(declaration.vis, Visibility::Inherited);
                    self.imports(&declaration.tree, &mut Vec::new(), on, module, modules);
                }
                Item::Mod(inline) if inline.content.is_some() => {
                    let mut inner = module.clone();
                    inner.push(inline.ident.to_string());
                    self.items(&inline.content.as_ref().unwrap().1, &inner, modules);
                }
                item => self.tokens(item.to_token_stream(), module, modules),
            }
        }
    }

    fn imports(
        &mut self,
        tree: &UseTree,
        before: &mut Module,
        on: bool,
        module: &Module,
        modules: &BTreeSet<Module>,
    ) {
        let mut note = |before: &Module, last: &str, name: &str| {
            let mut path = before.clone();
            if last != "self" {
                path.push(last.into());
            }
            if let Some(path) = absolute(&path, module, modules) {
                if on {
                    self.handed_on.insert(name.into());
                }
                self.imported.insert(name.into(), path);
            }
        };
        match tree {
            UseTree::Path(path) => {
                before.push(path.ident.to_string());
                self.imports(&path.tree, before, on, module, modules);
                before.pop();
            }
            UseTree::Group(group) => {
                for tree in &group.items {
                    self.imports(tree, before, on, module, modules);
                }
            }
            UseTree::Name(name) => {
                let name = name.ident.to_string();
                let known = if name == "self" {
                    before.last().cloned().unwrap_or_default()
                } else {
                    name.clone()
                };
                note(before, &name, &known);
            }
            UseTree::Rename(rename) => {
                note(
                    before,
                    &rename.ident.to_string(),
                    &rename.rename.to_string(),
                );
            }
            UseTree::Glob(_) => {
                let name = format!("*{}", before.join("::"));
                note(before, "self", &name);
            }
        }
    }

    fn tokens(&mut self, tokens: TokenStream, module: &Module, modules: &BTreeSet<Module>) {
        let mut path: Module = Vec::new();
        let mut colons = 0;
        let mut finish = |path: &mut Module, names: &mut BTreeSet<String>| {
            if let [first, ..] = &path[..] {
                names.insert(first.clone());
                if path.len() > 1
                    && let Some(path) = absolute(path, module, modules)
                {
                    self.paths.push(path);
                }
            }
            path.clear();
        };
        let mut names = BTreeSet::new();
        let mut groups = Vec::new();
        for token in tokens {
            match token {
                TokenTree::Ident(name) => {
                    if colons != 2 {
                        finish(&mut path, &mut names);
                    }
                    path.push(name.to_string());
                    colons = 0;
                }
                TokenTree::Punct(mark) if mark.as_char() == ':' => colons += 1,
                other => {
                    finish(&mut path, &mut names);
                    colons = 0;
                    if let TokenTree::Group(group) = other {
                        groups.push(group.stream());
                    }
                }
            }
        }
        finish(&mut path, &mut names);
        self.names.extend(names);
        for group in groups {
            self.tokens(group, module, modules);
        }
    }

    /// Paths of what the file uses itself.
    fn used(&self) -> impl Iterator<Item = &Module> {
        let own = |(name, _): &(&String, &Module)| {
            !self.handed_on.contains(*name) || self.names.contains(*name)
        };
        let imported = self.imported.iter().filter(own).map(|(_, path)| path);
        imported.chain(&self.paths)
    }
}

fn is_test(item: &Item) -> bool {
    let attributes = match item {
        Item::Mod(item) => &item.attrs,
        Item::Fn(item) => &item.attrs,
        Item::Use(item) => &item.attrs,
        Item::Impl(item) => &item.attrs,
        _ => return false,
    };
    let mut attributes = attributes.iter().map(|a| a.to_token_stream().to_string());
    attributes.any(|text| text.replace(' ', "") == "#[cfg(test)]")
}

/// A path as seen from a module, from the crate's root; `None` if it leads elsewhere.
fn absolute(path: &Module, module: &Module, modules: &BTreeSet<Module>) -> Option<Module> {
    let (first, rest) = path.split_first()?;
    let mut base = match first.as_str() {
        "crate" => return Some(rest.to_vec()),
        "self" => module.clone(),
        "super" => module.split_last()?.1.to_vec(),
        child => {
            let mut inner = module.clone();
            inner.push(child.into());
            if !modules.contains(&inner) {
                return None;
            }
            inner
        }
    };
    for name in rest {
        if name == "super" {
            base.pop()?;
        } else {
            base.push(name.clone());
        }
    }
    Some(base)
}

/// The file in which the thing at a path is defined.
fn home(sources: &BTreeMap<Module, Source>, path: &Module) -> Option<Module> {
    let mut path = path.clone();
    for _ in 0..8 {
        let known = (0..=path.len())
            .rev()
            .find(|n| sources.contains_key(&path[..*n]))?;
        let (module, rest) = path.split_at(known);
        let handed_on = rest
            .first()
            .and_then(|name| sources[module].imported.get(name));
        let Some(target) = handed_on else {
            return Some(module.to_vec());
        };
        path = target.iter().chain(&rest[1..]).cloned().collect();
    }
    None
}

fn found_in(sources: &BTreeMap<Module, Source>) -> impl Iterator<Item = String> {
    let name = |module: &[String]| match module {
        [] => "(root)".to_owned(),
        parts => parts.join("::"),
    };
    let mut files = Graph::new();
    // By the folder that both are in: the entries in it that they belong to.
    let mut folders: BTreeMap<String, Graph> = BTreeMap::new();
    for (from, source) in sources {
        for to in source.used().filter_map(|path| home(sources, path)) {
            if to == *from {
                continue;
            }
            files.entry(name(from)).or_default().insert(name(&to));
            let shared = from.iter().zip(&to).take_while(|(a, b)| a == b).count();
            if shared < from.len() && shared < to.len() {
                let graph = folders.entry(name(&from[..shared])).or_default();
                let entry = graph.entry(name(&from[..=shared])).or_default();
                entry.insert(name(&to[..=shared]));
            }
        }
    }
    let mut found: Vec<String> = Vec::new();
    let in_files = circles(&files);
    let in_folders = folders.values().flat_map(circles);
    let in_folders: Vec<_> = in_folders
        .filter(|circle| !in_files.contains(circle))
        .collect();
    found.extend(
        in_files
            .iter()
            .map(|circle| format!("files {}", circle.join(", "))),
    );
    found.extend(
        in_folders
            .iter()
            .map(|circle| format!("folders {}", circle.join(", "))),
    );
    found.into_iter()
}

/// Groups in which everybody reaches everybody.
fn circles(graph: &Graph) -> Vec<Vec<String>> {
    let reach = |from: &String| {
        let mut seen = BTreeSet::new();
        let mut waiting = vec![from];
        while let Some(next) = waiting.pop() {
            for to in graph.get(next).into_iter().flatten() {
                if seen.insert(to) {
                    waiting.push(to);
                }
            }
        }
        seen
    };
    let reached: BTreeMap<&String, BTreeSet<&String>> =
        graph.keys().map(|from| (from, reach(from))).collect();
    let mut done = BTreeSet::new();
    let mut found = Vec::new();
    for (from, to) in &reached {
        if to.contains(from) && !done.contains(from) {
            let back = |other: &&&String| reached.get(**other).is_some_and(|r| r.contains(from));
            let circle: Vec<_> = to.iter().filter(back).copied().cloned().collect();
            done.extend(to.iter().filter(back).copied());
            found.push(circle);
        }
    }
    found
}

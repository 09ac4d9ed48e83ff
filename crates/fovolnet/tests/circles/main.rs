//! No two source files import each other, neither directly nor through others.
//!
//! A file imports another one if it names an item that the other one defines: in a `use`, or in a path such as
//! `super::name`. Items that a module only re-exports belong to the file that defines them. `mod name;` is no
//! import, and neither is a `pub use` of names that the file itself does not use. Code for tests is left out.

mod tokens;

use std::collections::{BTreeSet, HashMap, HashSet};
use std::path::{Path, PathBuf};
use tokens::{is_word, tokens, without_tests};

#[test]
fn no_files_import_each_other() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").canonicalize().unwrap();
    let sources = ["crates", "apps", "training"].into_iter().flat_map(|kind| {
        std::fs::read_dir(root.join(kind)).unwrap().map(|folder| folder.unwrap().path().join("src"))
    });
    let mut files = Vec::new();
    for source in sources {
        let starts = ["lib.rs", "main.rs"].map(|name| source.join(name));
        for start in starts.into_iter().filter(|file| file.is_file()) {
            read(&mut files, &start, None);
        }
    }
    assert!(files.len() > 300, "the sources were not found: {} files", files.len());
    let name = |at: usize| files[at].path.strip_prefix(&root).unwrap().display().to_string();
    let mut problem = String::new();
    for circle in circles(&imports(&files)) {
        problem += &format!("\n{} files import each other:", circle.len());
        circle.iter().for_each(|&at| problem += &format!("\n  {}", name(at)));
    }
    assert!(problem.is_empty(), "{problem}");
}

/// A source file.
#[derive(Default)]
struct File {
    path: PathBuf,
    parent: Option<usize>,
    /// Files of its modules, by name.
    modules: HashMap<String, usize>,
    /// Names that `use` brings in, with the paths that they stand for, and whether the file passes them on.
    uses: Vec<(String, Vec<String>, bool)>,
    /// Paths of two or more names outside of `use`.
    paths: Vec<Vec<String>>,
    /// All words outside of `use`.
    words: HashSet<String>,
}

/// Reads the file at `path` and, recursively, the files of its modules. Returns its number.
fn read(files: &mut Vec<File>, path: &Path, parent: Option<usize>) -> usize {
    let tokens = without_tests(&tokens(&std::fs::read_to_string(path).unwrap()));
    let number = files.len();
    files.push(File { path: path.to_owned(), parent, ..File::default() });
    let folder = match path.file_stem().unwrap().to_str().unwrap() {
        "lib" | "main" | "mod" => path.parent().unwrap().to_owned(),
        _ => path.with_extension(""),
    };
    let (mut at, mut depth) = (0, 0);
    // Depths of braces at which modules within the file begin.
    let mut inner: Vec<i32> = Vec::new();
    while at < tokens.len() {
        match (tokens[at].as_str(), tokens.get(at + 2).map(String::as_str)) {
            ("use", _) if tokens[at + 1] != "<" => {
                let is_public = at > 0 && ["pub", ")"].contains(&tokens[at - 1].as_str());
                at = use_tree(&tokens, at + 1, &[], &mut |name, path| {
                    files[number].uses.push((name, outward(path, inner.len()), is_public));
                });
            }
            ("mod", Some("{")) => {
                inner.push(depth + 1);
                at += 2;
            }
            ("{", _) => (at, depth) = (at + 1, depth + 1),
            ("}", _) => {
                inner.retain(|&begin| begin < depth);
                (at, depth) = (at + 1, depth - 1);
            }
            ("mod", Some(";")) => {
                let name = tokens[at + 1].clone();
                let places = [folder.join(format!("{name}.rs")), folder.join(&name).join("mod.rs")];
                let file = places.into_iter().find(|file| file.is_file()).expect("modules have a file");
                let module = read(files, &file, Some(number));
                files[number].modules.insert(name, module);
                at += 3;
            }
            _ => {
                let mut end = at + 1;
                while end + 1 < tokens.len() && tokens[end] == "::" && is_word(&tokens[end + 1]) {
                    end += 2;
                }
                let path = outward(tokens[at..end].iter().step_by(2).cloned().collect(), inner.len());
                let is_whole = at == 0 || !["::", "."].contains(&tokens[at - 1].as_str());
                files[number].words.extend(is_whole.then(|| path[0].clone()));
                files[number].paths.extend((is_whole && path.len() > 1).then_some(path));
                at = end;
            }
        }
    }
    number
}

/// Path as the file names it, from a path within as many modules of the file.
fn outward(mut path: Vec<String>, inner: usize) -> Vec<String> {
    path.iter_mut().take(inner).take_while(|name| *name == "super").for_each(|name| *name = "self".into());
    path
}

/// Reads the tree of a `use` from place `at` on, after the names `before`. `each` gets every name with its path.
/// Returns the place after the tree.
fn use_tree(
    tokens: &[String],
    mut at: usize,
    before: &[String],
    each: &mut dyn FnMut(String, Vec<String>),
) -> usize {
    let mut path = before.to_vec();
    loop {
        match tokens[at].as_str() {
            "::" => at += 1,
            "{" => {
                at += 1;
                while tokens[at] != "}" {
                    at = use_tree(tokens, at, &path, each);
                    at += usize::from(tokens[at] == ",");
                }
                return at + 1;
            }
            "as" => {
                each(tokens[at + 1].clone(), path);
                return at + 2;
            }
            "*" => {
                each("*".into(), path);
                return at + 1;
            }
            ";" | "," | "}" => {
                if path.len() > 1 && path[path.len() - 1] == "self" {
                    path.pop();
                }
                each(path[path.len() - 1].clone(), path);
                return at;
            }
            name => {
                path.push(name.to_owned());
                at += 1;
            }
        }
    }
}

/// For each file, the files that it imports.
fn imports(files: &[File]) -> Vec<BTreeSet<usize>> {
    let of = |at: usize| {
        let file = &files[at];
        let is_used = |name: &str| name != "*" && file.words.contains(name);
        let used = file.uses.iter().filter(|(name, _, is_public)| !is_public || is_used(name));
        let used =
            used.filter(|(_, path, _)| path.len() > 1).filter_map(|(name, path, _)| match name.as_str() {
                "*" => module(files, at, path, 0),
                _ => defined(files, at, path, 0),
            });
        let named = file.paths.iter().filter_map(|path| defined(files, at, path, 0));
        used.chain(named).filter(|&to| to != at).collect()
    };
    (0..files.len()).map(of).collect()
}

/// Most re-exports through which an item is looked for.
const MOST_STEPS: usize = 6;

/// File that defines the item `path`, as the file `at` names it. `None` for other crates, and for whole modules:
/// what is used of them is found by the paths that begin with their names.
fn defined(files: &[File], at: usize, path: &[String], depth: usize) -> Option<usize> {
    let (mut at, mut rest, mut is_first) = (at, path, true);
    while let [name, after @ ..] = rest {
        let file = &files[at];
        match name.as_str() {
            "crate" => {
                while let Some(parent) = files[at].parent {
                    at = parent;
                }
            }
            "super" => at = file.parent?,
            "self" => {}
            name if file.modules.contains_key(name) => at = file.modules[name],
            name => {
                let brought = file.uses.iter().find(|(brought, path, _)| brought == name && path.len() > 1);
                let through = |path: &[String]| {
                    let whole: Vec<String> = path.iter().chain(after).cloned().collect();
                    (depth < MOST_STEPS).then(|| defined(files, at, &whole, depth + 1)).flatten()
                };
                if let Some((_, path, _)) = brought {
                    return through(path);
                }
                // Paths begin with a local name or that of a crate; only the former is of interest.
                if is_first || depth > MOST_STEPS {
                    return None;
                }
                let globs = file.uses.iter().filter(|(brought, ..)| brought == "*");
                let has = |module: &usize| files[*module].words.contains(name);
                let by_glob = globs.filter_map(|(_, path, _)| module(files, at, path, depth + 1)).find(has);
                return Some(by_glob.unwrap_or(at));
            }
        }
        (rest, is_first) = (after, false);
    }
    None
}

/// File of the module `path`, as the file `at` names it.
fn module(files: &[File], at: usize, path: &[String], depth: usize) -> Option<usize> {
    let path = [path, &["a name of no item".into()]].concat();
    defined(files, at, &path, depth).filter(|&module| module != at)
}

/// Sets of files that import each other, the largest first.
fn circles(imports: &[BTreeSet<usize>]) -> Vec<BTreeSet<usize>> {
    let reached = |from: usize| {
        let (mut reached, mut open) = (BTreeSet::new(), vec![from]);
        while let Some(at) = open.pop() {
            open.extend(imports[at].iter().filter(|&&to| reached.insert(to)));
        }
        reached
    };
    let reached: Vec<_> = (0..imports.len()).map(reached).collect();
    let circle = |at: usize| reached[at].iter().copied().filter(|&to| reached[to].contains(&at)).collect();
    let circles: BTreeSet<BTreeSet<usize>> = (0..imports.len()).map(circle).collect();
    let mut circles: Vec<_> = circles.into_iter().filter(|circle| circle.len() > 1).collect();
    circles.sort_by_key(|circle| std::cmp::Reverse(circle.len()));
    circles
}

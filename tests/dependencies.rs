//! Which module uses which, as ARCHITECTURE.md draws it.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// Every module of the library with the modules that its code names, tests apart.
const MODULES: [(&str, &[&str]); 18] = [
    ("linear", &[]),
    ("memory", &[]),
    ("live", &[]),
    ("random", &[]),
    ("energy", &[]),
    ("mesh", &[]),
    ("shapes", &["mesh", "random"]),
    ("subdivision", &["mesh"]),
    ("surface", &["energy", "mesh", "subdivision"]),
    ("patch", &["linear", "mesh"]),
    ("io", &["mesh"]),
    (
        "solver",
        &["energy", "linear", "mesh", "subdivision", "surface"],
    ),
    (
        "fill",
        &["energy", "live", "mesh", "patch", "random", "solver"],
    ),
    ("render", &["io", "mesh", "subdivision", "surface"]),
    (
        "refine",
        &[
            "energy",
            "live",
            "memory",
            "mesh",
            "solver",
            "subdivision",
            "surface",
        ],
    ),
    ("analysis", &["energy", "mesh", "subdivision", "surface"]),
    (
        "cli",
        &[
            "analysis", "energy", "fill", "io", "memory", "mesh", "refine", "render", "shapes",
            "solver",
        ],
    ),
    (
        "app",
        &[
            "analysis",
            "energy",
            "fill",
            "io",
            "memory",
            "mesh",
            "refine",
            "render",
            "shapes",
            "solver",
            "subdivision",
            "surface",
        ],
    ),
];

/// Crates only the named modules may use; `main` is the program. An empty list: nobody yet.
const CRATES: [(&str, &[&str]); 10] = [
    ("faer", &["linear"]),
    ("nalgebra_sparse", &["linear", "solver"]),
    ("spade", &["patch"]),
    ("clap", &["cli", "main"]),
    ("anyhow", &["cli", "main"]),
    ("indicatif", &["cli"]),
    ("tempfile", &["app", "io"]),
    ("egui", &["app", "render"]),
    ("eframe", &["app", "render"]),
    ("wgpu", &["app", "render"]),
];

fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).expect("a folder of sources") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            sources(&path, found);
        } else if path.extension().is_some_and(|e| e == "rs") {
            found.push(path);
        }
    }
}

/// The file's code without comments (string literals holding `//` lose their rest, which is no
/// place for a path either).
fn code(text: &str) -> String {
    text.lines()
        .map(|line| line.split("//").next().unwrap_or_default())
        .collect::<Vec<_>>()
        .join("\n")
}

fn is_word(c: char) -> bool {
    c.is_alphanumeric() || c == '_'
}

/// First segments of all paths that start with `crate::`, those of a braced group included.
fn named_modules(code: &str) -> BTreeSet<String> {
    let mut names = BTreeSet::new();
    for (at, _) in code.match_indices("crate::") {
        if code[..at].ends_with(is_word) {
            continue; // another crate whose name ends so
        }
        let rest = &code[at + "crate::".len()..];
        let mut starts = vec![rest];
        if let Some(group) = rest.strip_prefix('{') {
            starts.clear();
            let (mut depth, mut start) = (0, 0);
            for (i, c) in group.char_indices() {
                match c {
                    '{' => depth += 1,
                    '}' | ',' if depth == 0 => {
                        starts.push(&group[start..i]);
                        start = i + 1;
                        if c == '}' {
                            break;
                        }
                    }
                    '}' => depth -= 1,
                    _ => {}
                }
            }
        }
        for path in starts {
            let name: String = path
                .trim_start()
                .chars()
                .take_while(|&c| is_word(c))
                .collect();
            if !name.is_empty() {
                names.insert(name);
            }
        }
    }
    names
}

fn names_crate(code: &str, name: &str) -> bool {
    let path = format!("{name}::");
    code.match_indices(&path)
        .any(|(at, _)| !code[..at].ends_with(|c| is_word(c) || c == ':'))
}

/// The code of every source file with the module it belongs to.
fn modules() -> Vec<(String, PathBuf, String)> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut files = Vec::new();
    sources(&root, &mut files);
    files.sort();
    files
        .into_iter()
        .map(|path| {
            let inside = path.strip_prefix(&root).expect("below src");
            let first = inside.components().next().expect("a name");
            let module = Path::new(first.as_os_str())
                .file_stem()
                .expect("a name")
                .to_string_lossy()
                .into_owned();
            let text = fs::read_to_string(&path).expect("readable");
            (module, path, code(&text))
        })
        .collect()
}

/// The modules that a module's own code names, without its tests.
fn named_by_module() -> BTreeMap<String, BTreeSet<String>> {
    let mut named: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for (module, path, code) in modules() {
        let mut last = path.iter().rev().take(2);
        let is_test = last.any(|part| part.to_string_lossy().contains("test"));
        if module == "lib" || module == "main" || is_test {
            continue;
        }
        let own = code.split("\n#[cfg(test)]\nmod tests {").next();
        let mut used = named_modules(own.unwrap_or_default());
        used.remove(&module);
        named.entry(module).or_default().extend(used);
    }
    named
}

#[test]
fn modules_use_just_what_the_map_has() {
    let map: BTreeMap<String, BTreeSet<String>> = MODULES
        .iter()
        .map(|(module, used)| {
            let used = used.iter().map(|&m| m.to_owned()).collect();
            ((*module).to_owned(), used)
        })
        .collect();
    assert_eq!(named_by_module(), map);
}

#[test]
fn crates_stay_behind_their_module() {
    let mut wrong = Vec::new();
    for (module, path, code) in modules() {
        for (name, may) in CRATES {
            if names_crate(&code, name) && !may.contains(&module.as_str()) {
                wrong.push(format!("{}: {module} names {name}", path.display()));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn the_renderer_knows_egui_in_one_file() {
    for (module, path, code) in modules() {
        if module == "render" && !path.ends_with("callback.rs") {
            for name in ["egui", "eframe", "egui_wgpu"] {
                assert!(!names_crate(&code, name), "{}: {name}", path.display());
            }
        }
    }
}

#[test]
fn the_order_has_no_cycle() {
    // listed after everything it uses
    let mut below: Vec<&str> = Vec::new();
    for (module, may) in MODULES {
        assert!(may.iter().all(|m| below.contains(m)), "{module}");
        below.push(module);
    }
}

#[test]
fn the_reader_sees_what_it_should() {
    let text = "use crate::{mesh::{Mesh, DVec3}, linear as l};\n// crate::cli\nlet x: \
                crate::solver::Flow = my_crate::patch::y;";
    let names: Vec<String> = named_modules(&code(text)).into_iter().collect();
    assert_eq!(names, ["linear", "mesh", "solver"]);
    assert!(names_crate("use faer::Par;", "faer"));
    assert!(!names_crate("use not_faer::Par; a::faer::x", "faer"));
}

//! Dependencies between modules: ARCHITECTURE.md shows exactly what the sources import.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

/// Start of the graph in ARCHITECTURE.md, which ends at the next line of the same kind.
const FENCE: &str = "```";
const PICTURE: &str = "```modules\n";

/// Crates that only the named modules use; `main` is the program.
const CRATES: [(&str, &[&str]); 17] = [
    ("ab_glyph", &["render"]),
    ("epaint_default_fonts", &["render"]),
    ("faer", &["linear"]),
    ("nalgebra_sparse", &["linear", "solver", "symmetry"]),
    ("spade", &["patch"]),
    ("base64", &["io", "mesh"]),
    ("quick_xml", &["io"]),
    ("zip", &["io"]),
    ("image", &["app", "cli", "images", "render"]),
    ("clap", &["cli", "main"]),
    ("anyhow", &["cli"]),
    ("indicatif", &["cli"]),
    ("toml", &["app"]),
    ("egui", &["app", "render"]),
    ("eframe", &["app", "render"]),
    ("egui_wgpu", &["app", "render"]),
    ("wgpu", &["app", "render"]),
];

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("src")
}

/// Source files in a folder and below, tests left out.
fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).expect("a folder of sources") {
        let path = entry.expect("an entry").path();
        let stem = path.file_stem().expect("a name").to_string_lossy();
        if stem == "tests" || stem.ends_with("_tests") || stem.starts_with("test_") {
            continue;
        }
        if path.is_dir() {
            sources(&path, found);
        } else if path.extension().is_some_and(|e| e == "rs") {
            found.push(path);
        }
    }
}

/// The code of a file without its tests and comments. (A string literal with `//` loses its rest,
/// which holds no path.)
fn code(text: &str) -> String {
    let end = text.find("#[cfg(test)]\nmod tests {");
    text[..end.unwrap_or(text.len())]
        .lines()
        .map(|line| line.split("//").next().unwrap_or_default())
        .collect::<Vec<_>>()
        .join("\n")
}

fn is_word(c: char) -> bool {
    c.is_alphanumeric() || c == '_'
}

/// First segments of all paths that start with `prefix::`, those of a braced group included.
fn first_segments(code: &str, prefix: &str) -> BTreeSet<String> {
    let mut names = BTreeSet::new();
    let prefix = format!("{prefix}::");
    for (at, _) in code.match_indices(&prefix) {
        if code[..at].ends_with(is_word) {
            continue; // another crate whose name ends so
        }
        let rest = &code[at + prefix.len()..];
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
        let word = |path: &str| {
            path.trim_start()
                .chars()
                .take_while(|&c| is_word(c))
                .collect()
        };
        names.extend(starts.into_iter().map(word));
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
    let root = root();
    let mut files = Vec::new();
    sources(&root, &mut files);
    files.sort();
    files
        .into_iter()
        .map(|path| {
            let inside = path.strip_prefix(&root).expect("below src");
            let first = inside.components().next().expect("a name");
            let module = Path::new(first.as_os_str()).file_stem().expect("a name");
            let module = module.to_string_lossy().into_owned();
            let text = fs::read_to_string(&path).expect("readable");
            (module, path, code(&text))
        })
        .collect()
}

/// Every module with the modules it uses.
fn used() -> BTreeMap<String, BTreeSet<String>> {
    let files = modules();
    let names: BTreeSet<&String> = files.iter().map(|(module, ..)| module).collect();
    let mut used: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for (module, _, code) in &files {
        if module == "lib" {
            continue;
        }
        let crate_name = if module == "main" {
            "meniscus"
        } else {
            "crate"
        };
        let mut paths = first_segments(code, crate_name);
        paths.retain(|name| name != module && names.contains(name));
        used.entry(module.clone()).or_default().append(&mut paths);
    }
    used
}

/// The modules in floors: each uses only modules of lower floors, and at least one of the next.
///
/// # Panics
/// If the modules have a circular dependency.
fn floors(used: &BTreeMap<String, BTreeSet<String>>) -> Vec<Vec<&String>> {
    let mut floors: Vec<Vec<&String>> = Vec::new();
    let mut placed: BTreeSet<&String> = BTreeSet::new();
    while placed.len() < used.len() {
        let ready = |module: &&String| {
            !placed.contains(module) && used[*module].iter().all(|m| placed.contains(m))
        };
        let floor: Vec<&String> = used.keys().filter(ready).collect();
        let left: Vec<_> = used.keys().filter(|m| !placed.contains(m)).collect();
        assert!(!floor.is_empty(), "a circle among {left:?}");
        placed.extend(&floor);
        floors.push(floor);
    }
    floors
}

/// The [`floors`] as text.
fn picture(used: &BTreeMap<String, BTreeSet<String>>) -> String {
    let floors = floors(used);
    let mut text = String::new();
    for (number, floor) in floors.iter().enumerate().skip(1).rev() {
        for (i, module) in floor.iter().enumerate() {
            let number = if i == 0 {
                number.to_string()
            } else {
                String::new()
            };
            let names: Vec<&str> = used[*module].iter().map(String::as_str).collect();
            let _ = writeln!(text, "{number:1} {module:<12} ──▶ {}", names.join(" "));
        }
    }
    let ground: Vec<&str> = floors[0].iter().map(|m| m.as_str()).collect();
    text + "0 " + &ground.join(" ") + "\n"
}

#[test]
fn architecture_shows_what_the_modules_use() {
    let wanted = picture(&used());
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("ARCHITECTURE.md");
    let text = fs::read_to_string(page).expect("readable");
    let shown = text
        .split_once(PICTURE)
        .and_then(|(_, rest)| rest.split_once(FENCE));
    let shown = shown.map(|(picture, _)| picture).unwrap_or_default();
    assert!(
        shown == wanted,
        "if these uses are meant, put this block into ARCHITECTURE.md:\n{PICTURE}{wanted}{FENCE}"
    );
}

/// The parts of a module, its files and folders, with the others that each uses.
fn parts_of(module: &Path) -> BTreeMap<String, BTreeSet<String>> {
    let mut files = Vec::new();
    sources(module, &mut files);
    let name = module.file_name().expect("a name").to_string_lossy();
    let mut used: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for path in &files {
        let inside = path.strip_prefix(module).expect("below the module");
        let first = Path::new(inside.components().next().expect("a name").as_os_str());
        let part = first
            .file_stem()
            .expect("a name")
            .to_string_lossy()
            .into_owned();
        if part == "mod" {
            continue;
        }
        let is_mod = path.file_stem().is_some_and(|stem| stem == "mod");
        let supers = inside.components().count() - usize::from(is_mod);
        let code = code(&fs::read_to_string(path).expect("readable"));
        let prefixes = [format!("crate::{name}"), vec!["super"; supers].join("::")];
        let names = prefixes
            .iter()
            .flat_map(|prefix| first_segments(&code, prefix));
        let of_part = used.entry(part.clone()).or_default();
        of_part.extend(names.filter(|name| *name != part));
    }
    let all: BTreeSet<String> = used.keys().cloned().collect();
    for names in used.values_mut() {
        names.retain(|name| all.contains(name));
    }
    used
}

/// In `app`, actions, document and runs refer to each other, and so do the parts of its `update`.
#[test]
fn parts_of_a_module_have_no_circular_dependency() {
    for entry in fs::read_dir(root()).expect("a folder of sources") {
        let path = entry.expect("an entry").path();
        if path.is_dir() && !path.ends_with("app") {
            let parts = parts_of(&path);
            assert!(!parts.is_empty());
            floors(&parts);
        }
    }
}

#[test]
fn crates_stay_behind_their_module() {
    let files = modules();
    for (name, wanted) in CRATES {
        let users = files.iter().filter(|(.., code)| names_crate(code, name));
        let users: BTreeSet<&str> = users.map(|(module, ..)| module.as_str()).collect();
        assert_eq!(
            users,
            wanted.iter().copied().collect(),
            "modules that use {name}"
        );
    }
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
fn imports_are_found_and_drawn() {
    let text = "use crate::{mesh::{Mesh, DVec3}, linear as l};\n// crate::cli\nlet x: \
                crate::solver::Flow = my_crate::patch::y;\n#[cfg(test)]\nmod tests {\n    use \
                crate::shapes;\n}\n";
    let found: Vec<String> = first_segments(&code(text), "crate").into_iter().collect();
    assert_eq!(found, ["linear", "mesh", "solver"]);
    assert!(names_crate("use faer::Par;", "faer"));
    assert!(!names_crate("use not_faer::Par; a::faer::x", "faer"));
    let used = |list: &[&str]| list.iter().map(ToString::to_string).collect();
    let map = [
        ("a", used(&["b", "c"])),
        ("b", used(&["c"])),
        ("c", used(&[])),
    ];
    let map = map.map(|(name, list)| (name.to_owned(), list));
    let drawn = picture(&map.into());
    assert_eq!(drawn, "2 a            ──▶ b c\n1 b            ──▶ c\n0 c\n");
}

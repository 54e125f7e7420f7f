//! Loading and the classification of boundary loops on the test models, if `MENISCUS_MODELS` is set
//! to their folder.

use meniscus::mesh::{BoundaryLoop, boundary_loops, build};
use serde_json::Value;
use std::path::Path;

/// `--loops auto` fills exactly the loops that the manifest marks `fill`.
#[test]
fn auto_fills_what_the_manifest_marks() {
    let Some(models) = std::env::var_os("MENISCUS_MODELS") else {
        println!("not run: MENISCUS_MODELS is not set to the folder of the test models");
        return;
    };
    let root = Path::new(&models);
    let text = std::fs::read_to_string(root.join("manifest.json")).expect("manifest.json");
    let manifest: Value = serde_json::from_str(&text).expect("a JSON manifest");
    let mut wrong = Vec::new();
    let mut checked = 0;
    for case in manifest["cases"].as_array().expect("cases") {
        let name = case["name"].as_str().expect("name");
        let path = root.join(case["file"].as_str().expect("file"));
        let loaded = meniscus::io::load(&path)
            .map_err(|e| e.to_string())
            .and_then(|soup| build(&soup).map_err(|e| e.to_string()));
        let (mesh, report) = match loaded {
            Ok(loaded) => loaded,
            Err(error) => {
                println!("{name}: {error}");
                let expect = case["expect"].as_str().unwrap_or("");
                if !expect.contains("error") {
                    wrong.push(format!("{name}: not loaded: {error}"));
                }
                continue;
            }
        };
        if case["expect"] == "error" {
            wrong.push(format!("{name}: loaded in spite of its defect"));
        }
        let loops = boundary_loops(&mesh);
        println!(
            "{name}: {} vertices, {} faces, {} defects listed",
            report.vertices,
            report.faces,
            report.defects.len()
        );
        for one in &loops {
            println!(
                "  #{} {} edges, outer {}: {}",
                one.id,
                one.edges(),
                one.is_outer_boundary,
                one.reason
            );
        }
        // the loops in the manifest of this file belong to a fin that the repair removes
        let Some(wanted) = case["loops"]
            .as_array()
            .filter(|_| !name.contains("nonmanifold"))
        else {
            continue;
        };
        checked += 1;
        for want in wanted.iter().filter(|_| report.file_to_mesh.is_none()) {
            let found = loops.iter().find(|one| same_vertices(one, want));
            let fill = want["fill"].as_bool().expect("fill");
            if found.is_none_or(|one| one.is_outer_boundary == fill) {
                wrong.push(format!(
                    "{name}: {:?} where fill is {fill}",
                    found.map(|l| l.id)
                ));
            }
        }
        let filled = loops.iter().filter(|one| !one.is_outer_boundary).count();
        let fill = wanted.iter().filter(|want| want["fill"] == true).count();
        if loops.len() != wanted.len() || filled != fill {
            wrong.push(format!(
                "{name}: {filled} of {} loops, not {fill}",
                loops.len()
            ));
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
    println!("{checked} models with listed loops");
}

fn same_vertices(one: &BoundaryLoop, want: &Value) -> bool {
    let mut ours: Vec<u64> = one.vertices.iter().map(|v| u64::from(v.0)).collect();
    let list = want["vertices"].as_array().expect("vertices");
    let mut theirs: Vec<u64> = list.iter().filter_map(Value::as_u64).collect();
    ours.sort_unstable();
    theirs.sort_unstable();
    ours == theirs
}

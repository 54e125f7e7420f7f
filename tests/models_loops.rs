//! Load report and outer-rim guess on the shared models, if MENISCUS_MODELS names their folder.

use meniscus::mesh::{DVec3, Soup, boundary_loops, build};
use serde_json::Value;
use std::path::Path;

fn read_obj(path: &Path) -> Option<Soup> {
    let text = std::fs::read_to_string(path).ok()?;
    let text = text.replace("\\\r\n", " ").replace("\\\n", " ");
    let mut soup = Soup {
        offsets: vec![0],
        ..Soup::default()
    };
    for line in text.lines() {
        let mut words = line.split_whitespace();
        match words.next() {
            Some("v") => {
                let x: Vec<f64> = words.map(|w| w.parse().ok()).collect::<Option<_>>()?;
                if x.len() < 3 {
                    return None;
                }
                soup.positions.push(DVec3::new(x[0], x[1], x[2]));
            }
            Some("f") => {
                for w in words {
                    let i: i64 = w.split('/').next()?.parse().ok()?;
                    let n = soup.positions.len() as i64;
                    soup.corners.push(if i > 0 { i - 1 } else { n + i } as u32);
                }
                soup.offsets.push(soup.corners.len() as u32);
            }
            _ => {}
        }
    }
    Some(soup)
}

#[test]
fn table() {
    let Some(models) = std::env::var_os("MENISCUS_MODELS") else {
        println!("MENISCUS_MODELS is not set: not run");
        return;
    };
    let root = Path::new(&models);
    let manifest: Value =
        serde_json::from_str(&std::fs::read_to_string(root.join("manifest.json")).unwrap())
            .unwrap();
    for case in manifest["cases"].as_array().unwrap() {
        let name = case["name"].as_str().unwrap();
        let file = case["file"].as_str().unwrap();
        let Some(soup) = read_obj(&root.join(file)) else {
            println!("{name}: not read");
            continue;
        };
        let (mesh, report) = match build(&soup) {
            Ok(ok) => ok,
            Err(e) => {
                println!("{name}: {e}");
                continue;
            }
        };
        let mut short = report.clone();
        let map = short.file_to_mesh.take().is_some();
        short.defects.truncate(3);
        if short.components.len() > 3 {
            short.components.truncate(3);
        }
        let clean = short.defects.is_empty();
        if case["group"] == "bad" || !clean {
            println!(
                "{name} map {map}: {}",
                serde_json::to_string(&short).unwrap()
            );
        } else {
            println!("{name} {} {}", mesh.vertex_count(), mesh.face_count());
        }
        for l in boundary_loops(&mesh) {
            println!(
                "    #{} {} edges r {:.6} per {:.5} diam {:.4} comp {} rim {} {}",
                l.number,
                l.edges(),
                l.radius,
                l.perimeter,
                l.diameter,
                l.component,
                l.outer_rim,
                l.reason
            );
        }
    }
}

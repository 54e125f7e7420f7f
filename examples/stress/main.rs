//! Applies Meniscus to random inputs of many kinds and counts what is wrong with the results:
//! `cargo run --example stress -- [KIND] [COUNT] [FIRST_SEED] [--write FOLDER]`.
//!
//! The kinds are `fills`, `blends`, `refills`, `refinements` and `bridges`; without one, a few inputs
//! of each. Each seed gives one input and its options. A hole is *sound* if its patch has no
//! intersection, no edge folded by more than 150° and no face without area. It is *said* if it is not
//! sound and a warning says so, and *failed* if an error names it. Everything else is a fault of the
//! program; its seed is printed, and the program ends with status 1. `--write` saves every input that
//! is not sound.

mod inputs;
mod operations;

use std::collections::BTreeMap;
use std::error::Error;
use std::path::{Path, PathBuf};
use std::time::Instant;

use inputs::{Damage, Input, input};
use meniscus::Fill;
use meniscus::fill::{Continuity, Controls, Filled, FilledHole, LoopChoice, Surface};
use meniscus::mesh::{self, FaceId, Mesh, Neighbourhood, boundary_loops};
use meniscus::random::SplitMix;
use meniscus::solver::{End, SurfaceModel};
use meniscus::warning::Warning;

/// The kinds of inputs, and their number without arguments.
const KINDS: [(&str, u64); 5] = [
    ("fills", 22),
    ("blends", 4),
    ("refills", 6),
    ("refinements", 6),
    ("bridges", 10),
];
/// Angle between the normals of neighbours beyond which their edge is folded.
const FOLDED: f64 = 5.0 / 6.0 * std::f64::consts::PI;
/// Intersecting pairs that are counted.
const MAX_PAIRS: usize = 100_000;

/// What became of a hole.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Verdict {
    Sound,
    Said,
    Failed,
    /// An unsound patch without a warning.
    Silent,
    /// The mesh is not valid, or an input vertex was moved.
    Broken,
    Panic,
}

/// The counts of a kind of damage.
#[derive(Default)]
struct Counts {
    /// By verdict: holes whose surroundings have no intersection, and others.
    holes: BTreeMap<Verdict, [usize; 2]>,
    /// Holes whose patches do not join all islands, by their warnings.
    left: usize,
    unconverged: usize,
    raised: usize,
    /// Seconds and seed.
    slowest: (f64, u64),
}

impl Counts {
    /// Takes the time of a seed.
    fn time(&mut self, start: Instant, seed: u64) {
        let seconds = start.elapsed().as_secs_f64();
        if seconds > self.slowest.0 {
            self.slowest = (seconds, seed);
        }
    }

    fn add(&mut self, verdict: Verdict, is_clean: bool) {
        self.holes.entry(verdict).or_default()[usize::from(!is_clean)] += 1;
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut given = Vec::new();
    let mut folder = None;
    let mut arguments = std::env::args().skip(1).peekable();
    let kind = arguments.next_if(|word| KINDS.iter().any(|kind| kind.0 == word));
    while let Some(argument) = arguments.next() {
        if argument == "--write" {
            folder = Some(PathBuf::from(
                arguments.next().ok_or("--write needs a folder")?,
            ));
        } else {
            let wrong = |_| format!("`{argument}` is neither a kind nor a number");
            given.push(argument.parse::<u64>().map_err(wrong)?);
        }
    }
    if given.len() > 2 {
        return Err("at most two numbers".into());
    }
    let mut all: BTreeMap<String, Counts> = BTreeMap::new();
    let mut is_faulty = false;
    for (name, count) in KINDS {
        if kind.as_ref().is_some_and(|kind| kind != name) {
            continue;
        }
        let count = given.first().copied().unwrap_or(count);
        let first = given.get(1).copied().unwrap_or_default();
        for seed in first..first + count {
            let Some((row, mesh, worst)) = tried(name, seed, &mut all) else {
                continue;
            };
            is_faulty |= worst >= Verdict::Silent;
            if worst > Verdict::Sound {
                println!("{name}, seed {seed}: {row}, {worst:?}");
                if let Some(folder) = &folder {
                    write(folder, name, seed, &mesh)?;
                }
            }
        }
    }
    table(&all);
    if is_faulty {
        return Err("some results are faulty".into());
    }
    Ok(())
}

/// Counts the results for a seed of a kind. Returns the row of the table, the input and the worst
/// verdict; `None` if the seed gives no input.
fn tried(
    kind: &str,
    seed: u64,
    all: &mut BTreeMap<String, Counts>,
) -> Option<(String, Mesh, Verdict)> {
    if kind == "fills" {
        let input = input(seed)?;
        let row = format!("{:?}", input.damage);
        let worst = judge(seed, &input, all.entry(row.clone()).or_default());
        return Some((row, input.mesh, worst));
    }
    let case = operations::case(kind, seed)?;
    let counts = all.entry(case.row.clone()).or_default();
    let start = Instant::now();
    let run = std::panic::AssertUnwindSafe(|| case.operation.run(&case.mesh, seed));
    let results = std::panic::catch_unwind(run).unwrap_or_else(|_| vec![(Verdict::Panic, true)]);
    counts.time(start, seed);
    for &(verdict, is_clean) in &results {
        counts.add(verdict, is_clean);
    }
    let worst = results.into_iter().map(|(verdict, _)| verdict).max();
    Some((case.row, case.mesh, worst.unwrap_or(Verdict::Sound)))
}

/// Random options: the defaults for half of the seeds.
fn controls(seed: u64) -> Controls {
    let mut rng = SplitMix::new(seed ^ 0x5eed);
    let mut controls = Controls::default();
    if rng.below(2) == 0 {
        return controls;
    }
    let surfaces = [
        Surface::Auto,
        Surface::Energy,
        Surface::Diffusion,
        Surface::G2,
    ];
    controls.surface = surfaces[rng.below(4)];
    if controls.surface == Surface::Energy {
        let energies = ["H^2", "H^2+K^2", "sqrt(k1^2+k2^2+0.1)", "H^4", "H^2*K^2"];
        energies[rng.below(5)].clone_into(&mut controls.energy);
    }
    if rng.below(4) == 0 {
        controls.density = rng.range(0.5, 2.0);
    }
    if rng.below(8) == 0 {
        controls.continuity = Continuity::G0;
    }
    controls
}

/// Fills an input and counts its holes. Returns the worst verdict.
fn judge(seed: u64, input: &Input, counts: &mut Counts) -> Verdict {
    let mesh = &input.mesh;
    let start = Instant::now();
    let fill = || {
        let fill = Fill::new(mesh).controls(controls(seed));
        let fill = match input.damage {
            Damage::MostGone => fill.loops(LoopChoice::All),
            _ => fill,
        };
        fill.run()
    };
    let filled = std::panic::catch_unwind(fill);
    counts.time(start, seed);
    let mut count = |verdict, is_clean: bool| {
        counts.add(verdict, is_clean);
        verdict
    };
    let filled = match filled {
        Err(_) => return count(Verdict::Panic, true),
        Ok(Err(error)) => {
            println!("seed {seed}: {error}");
            return count(Verdict::Failed, true);
        }
        Ok(Ok(filled)) => filled,
    };
    if let Err(fault) = check(mesh, &filled.mesh) {
        println!("seed {seed}: {fault}");
        return count(Verdict::Broken, true);
    }
    let verdicts = verdicts(mesh, &filled);
    let worst = verdicts
        .iter()
        .map(|&(verdict, is_clean)| count(verdict, is_clean))
        .max();
    let has_left = |hole: &&FilledHole| {
        let mut warnings = hole.warnings.iter();
        warnings.any(|warning| matches!(warning, Warning::IslandsLeft { .. }))
    };
    let left = filled.holes.iter().filter(has_left).count();
    let failed = filled.failed.iter().map(|error| {
        println!("seed {seed}: {error}");
        count(Verdict::Failed, true)
    });
    let worst = failed.max().max(worst);
    counts.left += left;
    for group in filled.groups.iter().flatten() {
        let outcome = &group.outcome;
        counts.unconverged += usize::from(outcome.end != End::Converged);
        let first = group.records.iter().find(|r| !r.is_rejected());
        let last = group.records.iter().rfind(|r| !r.is_rejected());
        // vector flows update their metric, and a replaced surface has another energy
        let is_comparable = group.surface.model.surface == SurfaceModel::Energy
            && !outcome
                .warnings
                .iter()
                .any(|w| matches!(w, Warning::Replaced { .. }));
        let is_raised = first
            .zip(last)
            .is_some_and(|(a, b)| b.energy > 1.000_001 * a.energy);
        let is_raised = is_comparable && is_raised;
        counts.raised += usize::from(is_raised);
    }
    worst.unwrap_or(Verdict::Sound)
}

/// The mesh is valid, and vertices and faces of the input are unchanged.
fn check(before: &Mesh, after: &Mesh) -> Result<(), String> {
    mesh::check_mesh(after)?;
    let bits = |mesh: &Mesh| -> Vec<[u64; 3]> {
        let kept = mesh.positions.iter().take(before.vertex_count());
        kept.map(|p| p.to_array().map(f64::to_bits)).collect()
    };
    if bits(before) != bits(after) {
        return Err("a vertex of the input was moved".into());
    }
    let kept = after.topology.triangles().take(before.face_count());
    if !kept.eq(before.topology.triangles()) {
        return Err("a face of the input was changed".into());
    }
    Ok(())
}

/// The verdict of each filled hole, and whether the faces around it are free of intersections.
fn verdicts(before: &Mesh, filled: &Filled) -> Vec<(Verdict, bool)> {
    let after = &filled.mesh;
    let faces: Vec<[u32; 3]> = after.topology.triangles().collect();
    let old = before.face_count() as u32;
    let new: Vec<u32> = (old..faces.len() as u32).collect();
    let crossings = mesh::self_intersections(&after.positions, &faces, Some(&new), MAX_PAIRS);
    let folds = mesh::folded_edges(&after.positions, &after.topology, FOLDED);
    let is_said = |face: u32| {
        let hole = filled
            .holes
            .iter()
            .find(|hole| hole.faces.contains(&(face as usize)));
        hole.is_some_and(|hole| is_said(filled, hole))
    };
    let mut defect = vec![None; faces.len()];
    for (pairs, kind) in [(folds, "fold"), (crossings, "intersection")] {
        for pair in pairs {
            let said = pair.into_iter().any(is_said);
            for f in pair {
                defect[f as usize] = defect[f as usize].max(Some((!said, kind)));
            }
        }
    }
    for f in new {
        let [a, b, c] = after.corners(FaceId(f));
        if (b - a).cross(c - a) == mesh::DVec3::ZERO {
            defect[f as usize] = Some((!is_said(f), "face without area"));
        }
    }
    let loops = boundary_loops(before);
    let verdict = |hole: &FilledHole| {
        let rims = hole.loops.iter().flat_map(|id| &loops[id.index()].vertices);
        let around = Neighbourhood::small(&before.topology, rims.copied(), 1);
        let around: Vec<u32> = around.faces.iter().map(|f| f.0).collect();
        let given = &faces[..old as usize];
        let clean = mesh::self_intersections(&before.positions, given, Some(&around), 1);
        let defects = defect[hole.faces.clone()].iter().flatten();
        let verdict = match defects.clone().max() {
            None => Verdict::Sound,
            Some((false, kind)) => {
                let (faces, edges) = (defects.count(), hole.edges);
                println!("hole {} of {edges} edges: {faces} faces, {kind}", hole.id());
                Verdict::Said
            }
            Some((true, kind)) => {
                let faces = defects.count();
                println!("hole {}: {faces} faces, {kind}, unsaid", hole.id());
                Verdict::Silent
            }
        };
        (verdict, clean.is_empty())
    };
    filled.holes.iter().map(verdict).collect()
}

/// Whether a warning says that the patch of a hole is unsound.
fn is_said(filled: &Filled, hole: &FilledHole) -> bool {
    let is_about_soundness = |warning: &Warning| {
        matches!(
            warning,
            Warning::SelfIntersection { .. } | Warning::Folded { .. }
        )
    };
    let has_failed = hole.group.is_some_and(|g| filled.groups[g].is_err());
    has_failed || hole.warnings.iter().any(is_about_soundness)
}

fn write(folder: &Path, kind: &str, seed: u64, mesh: &Mesh) -> Result<(), Box<dyn Error>> {
    std::fs::create_dir_all(folder)?;
    meniscus::io::save_mesh(&folder.join(format!("{kind}-{seed}.obj")), mesh)?;
    Ok(())
}

fn table(all: &BTreeMap<String, Counts>) {
    let verdicts = [
        Verdict::Sound,
        Verdict::Said,
        Verdict::Failed,
        Verdict::Silent,
        Verdict::Broken,
        Verdict::Panic,
    ];
    println!(
        "\nHoles whose surroundings are free of intersections + others, holes whose islands were left aside, groups, seconds"
    );
    print!("{:<14}", "");
    for verdict in verdicts {
        print!("{:>12}", format!("{verdict:?}"));
    }
    println!(
        "{:>8}{:>12}{:>8}{:>10}{:>7}",
        "left", "unconverged", "raised", "slowest", "seed"
    );
    for (damage, counts) in all {
        print!("{damage:<14}");
        for verdict in verdicts {
            let [clean, other] = counts.holes.get(&verdict).copied().unwrap_or_default();
            print!("{:>12}", format!("{clean} + {other}"));
        }
        println!(
            "{:>8}{:>12}{:>8}{:>10.1}{:>7}",
            counts.left, counts.unconverged, counts.raised, counts.slowest.0, counts.slowest.1
        );
    }
}

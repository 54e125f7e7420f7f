//! Runs the program over the test models and judges every result.
//!
//! The models are not part of the repository. `MENISCUS_MODELS` is their folder (the one with
//! `manifest.json`); if it is unset, the suite prints a note and passes. `MENISCUS_MODELS_ONLY`
//! restricts it to cases whose name contains one of its comma-separated words, and
//! `MENISCUS_MODELS_PROGRAM` names another program with the same `fill` command, to judge its
//! results by the same measure.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use crate::common::judge::{Keep, Verdict, judge};
use crate::common::manifest::{self, Case};
use crate::common::raw::{self, RawMesh};
use crate::common::truth::Truth;
use serde_json::Value;

/// Time limit of a fill, longer than every successful one. A fill beyond the limit hangs.
const TIMEOUT: Duration = Duration::from_mins(5);
/// Most steps of a hole, and in scans, whose patches are remeshed at the end and continue from there.
const MAX_STEPS: [u64; 2] = [25, 30];
const MAX_REJECTED: u64 = 2;
const MIB: f64 = 1024.0 * 1024.0;
const MAX_MEMORY: f64 = 1024.0 * MIB;
/// A filled sphere of the bad files that is further off (in hole radii) was filled with garbage.
const BAD_LIMIT: f64 = 0.05;

/// Most steps of a blend, and those of the paper's four cylinders.
const MAX_BLEND_STEPS: [u64; 2] = [60, 40];
/// Extra arguments for some cases: the cylinder is stationary only for this energy.
const ARGUMENTS: [(&str, &[&str]); 1] = [(
    "coaxial_equal",
    &["--energy", "(H-H0)^2", "--param", "H0=-1"],
)];

/// Limits of the RMS error in hole radii, and the best that other programs reach.
const LIMITS: [(&str, f64, f64); 26] = [
    ("coaxial_equal", 5e-3, 7e-3),
    ("sphere_zone", 5e-3, f64::NAN),
    ("torus_section", 2e-2, 2.1e-1),
    ("sphere_a25", 5e-4, 2.7e-3),
    ("sphere_a50", 9e-4, 2.4e-2),
    ("sphere_a80", 2.5e-3, 6.3e-2),
    ("sphere_n500", 1e-3, 1.5e-2),
    ("sphere_n5000", 1e-3, 2.8e-2),
    ("sphere_n50000", 2e-3, 3.6e-2),
    ("sphere_a50_ragged", 1.5e-3, 2.2e-2),
    ("sphere_5holes", 3.9e-4, 3.9e-4),
    ("torus_1hole", 1e-3, 1.5e-3),
    ("torus_4holes", 1e-3, 1.2e-3),
    ("catenoid_hole", 4.5e-4, 7.6e-4),
    ("ellipsoid_hole", 5e-3, 6.1e-3),
    ("saddle_hole", 1.8e-3, 2.6e-3),
    ("cylinder_window", 4.5e-4, 4.5e-4),
    ("plane_L", 1e-12, 0.0),
    ("bunny_riddled", 3.5e-2, 3.5e-2),
    ("spot_riddled", 3.15e-2, 3.15e-2),
    ("igea_riddled", 1.76e-2, 1.76e-2),
    ("rocker_arm_riddled", 4.64e-2, 4.64e-2),
    ("cheburashka_riddled", 4.52e-2, 4.52e-2),
    ("homer_riddled", 5.86e-2, 5.86e-2),
    ("lion_riddled", 5.3e-2, 5.3e-2),
    ("fertility_riddled", 3.87e-2, 3.87e-2),
];

/// The outcome of one case.
struct Outcome {
    name: String,
    verdict: Verdict,
    limit: Option<(f64, f64)>,
    /// Most steps of a hole, rejected steps of a hole, holes not converged.
    steps: u64,
    rejected: u64,
    unconverged: usize,
    wall: Duration,
    memory: Option<f64>,
    note: String,
    failures: Vec<String>,
}

/// One run of `meniscus fill`.
struct Run {
    code: Option<i32>,
    stderr: String,
    report: Option<Value>,
    output: PathBuf,
    wall: Duration,
}

#[test]
fn shared_models() {
    let Some(folder) = std::env::var_os("MENISCUS_MODELS").map(PathBuf::from) else {
        println!("not run: MENISCUS_MODELS is not set to the folder of the test models");
        return;
    };
    let only = std::env::var("MENISCUS_MODELS_ONLY").unwrap_or_default();
    let wanted = |case: &Case| {
        let chosen = only.is_empty() || only.split(',').any(|word| case.name.contains(word.trim()));
        chosen && ["analytic", "real", "bad", "blend"].contains(&case.group.as_str())
    };
    let manifest = manifest::read(&folder).expect("the manifest");
    let outcomes: Vec<Outcome> = manifest
        .cases
        .iter()
        .filter(|case| wanted(case))
        .map(|case| {
            let outcome = if case.group == "bad" {
                bad_case(case, &folder)
            } else {
                good_case(case, &folder)
            };
            eprintln!("{}", row(&outcome));
            outcome
        })
        .collect();
    let table = table(&outcomes);
    println!("{table}");
    let failed: Vec<String> = outcomes
        .iter()
        .flat_map(|o| o.failures.iter().map(|f| format!("{}: {f}", o.name)))
        .collect();
    assert!(
        failed.is_empty(),
        "{} requirements not met:\n  {}",
        failed.len(),
        failed.join("\n  ")
    );
}

fn arguments(case: &Case) -> &'static [&'static str] {
    let found = ARGUMENTS.iter().find(|(name, _)| *name == case.name);
    found.map_or(&[], |found| found.1)
}

fn fill(case: &Case, folder: &Path) -> Run {
    let scratch = Path::new(env!("CARGO_TARGET_TMPDIR")).join("models");
    std::fs::create_dir_all(&scratch).expect("a scratch folder");
    let output = scratch.join(format!("{}.filled.obj", case.name));
    let report = scratch.join(format!("{}.json", case.name));
    for old in [&output, &report] {
        if old.exists() {
            std::fs::remove_file(old).expect("an old result that can be removed");
        }
    }
    let program = std::env::var_os("MENISCUS_MODELS_PROGRAM")
        .unwrap_or_else(|| env!("CARGO_BIN_EXE_meniscus").into());
    let start = Instant::now();
    let result = assert_cmd::Command::new(program)
        .arg(if case.group == "blend" {
            "blend"
        } else {
            "fill"
        })
        .arg(folder.join(&case.file))
        .arg("-o")
        .arg(&output)
        .arg("--report")
        .arg(&report)
        .arg("--quiet")
        .args(arguments(case))
        .timeout(TIMEOUT)
        .output()
        .expect("the program starts");
    Run {
        code: result.status.code(),
        stderr: String::from_utf8_lossy(&result.stderr).into_owned(),
        report: std::fs::read_to_string(&report)
            .ok()
            .and_then(|text| serde_json::from_str(&text).ok()),
        output,
        wall: start.elapsed(),
    }
}

impl Outcome {
    fn new(case: &Case, run: &Run) -> Self {
        let mut outcome = Self {
            name: case.name.clone(),
            verdict: Verdict {
                rms: f64::NAN,
                max: f64::NAN,
                ..Verdict::default()
            },
            limit: LIMITS
                .iter()
                .find(|(name, ..)| *name == case.name)
                .map(|&(_, limit, others)| (limit, others)),
            steps: 0,
            rejected: 0,
            unconverged: 0,
            wall: run.wall,
            memory: None,
            note: String::new(),
            failures: Vec::new(),
        };
        match run.code {
            None => outcome.fail(format!("killed after {:.0} s", run.wall.as_secs_f64())),
            Some(code) => outcome.note = format!("exit {code}"),
        }
        if run.stderr.contains("panicked") {
            outcome.fail(format!("panicked: {}", first_line(&run.stderr)));
        }
        outcome
    }

    fn fail(&mut self, what: impl Into<String>) {
        self.failures.push(what.into());
    }

    /// Reads the mesh written and judges it; `None` if there is none.
    fn judge(&mut self, case: &Case, folder: &Path, run: &Run, keep: Keep) -> Option<RawMesh> {
        let input = match raw::read(&folder.join(&case.file)) {
            Ok(mesh) => mesh,
            Err(error) => {
                self.fail(format!("the input could not be read to compare: {error}"));
                return None;
            }
        };
        let output = match raw::read(&run.output) {
            Ok(mesh) => mesh,
            Err(error) => {
                self.fail(format!("no output: {error}"));
                return None;
            }
        };
        let truth = case.truth.as_ref().and_then(|entry| {
            Truth::load(entry, folder)
                .map_err(|error| self.fail(error))
                .ok()
        });
        self.verdict = judge(&input, &output, keep, &case.loops, truth.as_ref());
        self.failures.append(&mut self.verdict.failures);
        Some(output)
    }

    /// Reads steps, rejections, convergence and memory from the report.
    fn read_report(&mut self, report: Option<&Value>) -> Vec<Value> {
        let Some(report) = report else {
            self.fail("no readable report");
            return Vec::new();
        };
        let holes = report["holes"].as_array().cloned().unwrap_or_default();
        let most = |key: &str| holes.iter().filter_map(|h| h[key].as_u64()).max();
        match (most("steps"), most("rejected")) {
            (Some(steps), Some(rejected)) => (self.steps, self.rejected) = (steps, rejected),
            _ => self.fail("the report has no holes with steps and rejected"),
        }
        self.unconverged = holes.iter().filter(|h| h["converged"] == false).count();
        self.memory = find_number(report, "peak_memory");
        holes
    }
}

/// Analytic and real models: everything the table of requirements asks.
fn good_case(case: &Case, folder: &Path) -> Outcome {
    let run = fill(case, folder);
    let mut outcome = Outcome::new(case, &run);
    if run.code != Some(0) {
        outcome.fail(format!("exit {:?}: {}", run.code, first_line(&run.stderr)));
        return outcome;
    }
    let holes = outcome.read_report(run.report.as_ref());
    let is_blend = case.group == "blend";
    let expected = case.holes_to_fill.map(|n| if is_blend { 1 } else { n });
    if let Some(expected) = expected.filter(|&n| n != holes.len()) {
        outcome.fail(format!("{} holes filled, not {expected}", holes.len()));
    }
    if outcome
        .judge(case, folder, &run, Keep::Everything)
        .is_none()
    {
        return outcome;
    }
    let verdict = outcome.verdict.clone();
    if let Some(leave) = case.loops_to_leave.filter(|&n| n != verdict.loops_left) {
        outcome.fail(format!("{} loops left, not {leave}", verdict.loops_left));
    }
    if let Some((limit, _)) = outcome.limit
        && (verdict.rms.is_nan() || verdict.rms > limit)
    {
        outcome.fail(format!("error {:.2e}, limit {limit:.1e}", verdict.rms));
    }
    let [most, fewer] = MAX_BLEND_STEPS;
    let most_steps = match (is_blend, case.name.as_str()) {
        (true, "four_cylinders") => fewer,
        (true, _) => most,
        _ => MAX_STEPS[usize::from(case.group == "real")],
    };
    if is_blend && verdict.components != 1 {
        outcome.fail(format!("{} components, not one", verdict.components));
    }
    if is_blend && outcome.unconverged > 0 {
        outcome.fail("not converged");
    }
    if outcome.steps > most_steps {
        outcome.fail(format!("{} steps", outcome.steps));
    }
    if case.group == "analytic" && outcome.rejected > MAX_REJECTED {
        outcome.fail(format!("{} rejected steps", outcome.rejected));
    }
    if let Some(bytes) = outcome.memory.filter(|&bytes| bytes > MAX_MEMORY) {
        outcome.fail(format!("{:.0} MiB of memory", bytes / MIB));
    }
    outcome
}

/// Bad files: a clear error or a sound result, as the manifest expects.
fn bad_case(case: &Case, folder: &Path) -> Outcome {
    let run = fill(case, folder);
    let mut outcome = Outcome::new(case, &run);
    let must_fail = case.expect == "error";
    let may_fail = must_fail || case.expect.contains("error");
    match run.code {
        Some(0) if must_fail => outcome.fail("filled, though an error was expected"),
        Some(0) => bad_case_filled(case, folder, &run, &mut outcome),
        Some(1) => {
            outcome.note = first_line(&run.stderr);
            if !may_fail {
                let message = format!("error, expected: {}; said: {}", case.expect, outcome.note);
                outcome.fail(message);
            }
            if run.stderr.trim().is_empty() {
                outcome.fail("exit 1 without a message");
            }
            if run.output.exists() {
                outcome.fail("exit 1, but a file was written");
            }
        }
        Some(code) => outcome.fail(format!("exit {code}: {}", first_line(&run.stderr))),
        None => {}
    }
    outcome
}

fn bad_case_filled(case: &Case, folder: &Path, run: &Run, outcome: &mut Outcome) {
    outcome.read_report(run.report.as_ref());
    if outcome.judge(case, folder, run, Keep::Positions).is_none() {
        return;
    }
    let left = outcome.verdict.loops_left;
    // without a number in the manifest, a mesh that must be filled must be closed
    let leave = case
        .loops_to_leave
        .or_else(|| case.expect.starts_with("fill").then_some(0));
    // the manifest counts rims around fins: a fin that was cut off is a sheet with its own rim
    let fins = case.loops.iter().filter(|l| l.edges < 3).count();
    if let Some(leave) = leave.filter(|&n| left < n || left > n + fins) {
        outcome.fail(format!("{left} loops left, not {leave}"));
    }
    if outcome.verdict.rms > BAD_LIMIT {
        let message = format!("error {:.2e}: not the sphere", outcome.verdict.rms);
        outcome.fail(message);
    }
    if case.expect.contains("warning") && run.stderr.trim().is_empty() {
        outcome.fail("a warning was expected on stderr");
    }
}

fn first_line(text: &str) -> String {
    let mut line = text.trim().lines().next().unwrap_or_default().to_owned();
    if line.chars().count() > 90 {
        line = line.chars().take(87).chain("...".chars()).collect();
    }
    line
}

/// The first number, anywhere in the report, whose key starts with `key`.
fn find_number(value: &Value, key: &str) -> Option<f64> {
    match value {
        Value::Object(map) => map.iter().find_map(|(name, inner)| {
            if name.starts_with(key) {
                inner.as_f64()
            } else {
                find_number(inner, key)
            }
        }),
        Value::Array(list) => list.iter().find_map(|inner| find_number(inner, key)),
        _ => None,
    }
}

fn table(outcomes: &[Outcome]) -> String {
    let mut text = format!(
        "\n{:<28} {:>6} {:>8} {:>8} {:>8} {:>8} {:>5} {:>4} {:>4} {:>4} {:>5} {:>5} {:>5} {:>7} {:>5}\n",
        "case (error in hole radii)",
        "new v",
        "rms",
        "limit",
        "others",
        "max",
        "steps",
        "rej",
        "unc",
        "open",
        "cuts",
        "folds",
        "rim°",
        "wall s",
        "MiB",
    );
    for outcome in outcomes {
        let _ = writeln!(text, "{}", row(outcome));
        if outcome.verdict.holes.len() > 1 {
            let each: Vec<String> = outcome
                .verdict
                .holes
                .iter()
                .map(|(edges, rms, _)| format!("{edges}: {rms:.1e}"))
                .collect();
            let _ = writeln!(text, "    by hole (edges: rms) {}", each.join(", "));
        }
    }
    text
}

fn row(outcome: &Outcome) -> String {
    let number = |x: f64| {
        if x.is_nan() {
            "-".to_owned()
        } else {
            format!("{x:.2e}")
        }
    };
    let v = &outcome.verdict;
    let (limit, others) = outcome.limit.unwrap_or((f64::NAN, f64::NAN));
    format!(
        "{:<28} {:>6} {:>8} {:>8} {:>8} {:>8} {:>5} {:>4} {:>4} {:>4} {:>5} {:>5} {:>5.2} {:>7.2} {:>5}  {} {}",
        outcome.name,
        v.new_vertices,
        number(v.rms),
        number(limit),
        number(others),
        number(v.max),
        outcome.steps,
        outcome.rejected,
        outcome.unconverged,
        v.loops_left,
        v.intersections,
        v.folds,
        v.rim_angle,
        outcome.wall.as_secs_f64(),
        outcome
            .memory
            .map_or("-".to_owned(), |bytes| format!("{:.0}", bytes / MIB)),
        if outcome.failures.is_empty() {
            "ok".to_owned()
        } else {
            format!("FAILED ({})", outcome.failures.join("; "))
        },
        outcome.note,
    )
}

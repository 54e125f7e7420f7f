//! `meniscus fill` with several files.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::fs;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError, mpsc};

use anyhow::{Context, Result, anyhow, bail};
use indicatif::ProgressBar;
use rayon::ThreadPoolBuilder;
use serde::Serialize;

use crate::cli::fill::{FillArguments, fill_file};
use crate::cli::flow::{FlowArguments, MeshFiles, Written, write_text};
use crate::cli::print::{complain, kept, print};
use crate::cli::progress::spinner;
use crate::cli::report::FillReport;
use crate::cli::side_by_side::{Place, SideBySide};
use crate::cli::targets::{Named, check_targets};
use crate::cli::{UsageError, message};
use crate::fill::LoopChoice;
use crate::io;

/// The report of all files.
#[derive(Debug, Serialize)]
struct BatchReport {
    version: &'static str,
    files: Vec<FileReport>,
}

/// The report of one file.
#[derive(Debug, Serialize)]
struct FileReport {
    /// File read.
    file: String,
    /// Why the file, or one of its holes, was not filled.
    error: Option<String>,
    /// The report of its fill; null if nothing was written.
    report: Option<FillReport>,
}

/// Fills all input files, each into the folder under its own name, side by side as far as processors and
/// memory allow. A file that fails does not end the batch. What is printed has the order of the files.
pub fn batch(args: &FillArguments, folder: &Path) -> Result<()> {
    args.check()?;
    refuse_options_for_one_mesh(args)?;
    args.flow.check()?;
    let jobs = jobs(args, folder)?;
    let report = args.flow.report.as_deref();
    let flow = FlowArguments {
        report: None,
        ..args.flow.clone()
    };
    let quiet = args.files.options.quiet;
    let (mut rows, mut entries, mut failed) = (vec![HEAD.map(String::from)], Vec::new(), 0);
    let fill = |k: usize, place: Place<'_>| fill_file(args, &jobs[k], &flow, Some(place));
    let progress = Progress::new(&jobs, quiet);
    side_by_side(jobs.len(), &progress, &fill, |k, (written, mut said)| {
        let file = jobs[k].input.display().to_string();
        if !quiet {
            said.insert_str(0, &format!("{} of {}: {file}\n", k + 1, jobs.len()));
        }
        let (report_of_file, result) = match written {
            Ok(written) => (Some(written.report), written.failures),
            Err(error) => (None, Err(error)),
        };
        let error = result.err().map(|e| with_name(&file, message(&e)));
        if let Some(error) = &error {
            said.extend(["meniscus: ", error, "\n"]);
            failed += 1;
        }
        progress.bar.suspend(|| complain(&said));
        rows.push(row(&file, report_of_file.as_ref()));
        if report.is_some() {
            entries.push(FileReport {
                file,
                error,
                report: report_of_file,
            });
        }
    });
    progress.bar.finish_and_clear();
    if let Some(path) = report {
        let version = env!("CARGO_PKG_VERSION");
        let files = entries;
        let text = serde_json::to_string_pretty(&BatchReport { version, files })?;
        write_text(path, &(text + "\n"))?;
    }
    if !quiet {
        print(&table(&rows))?;
    }
    if failed > 0 {
        bail!("{failed} of {} files failed", jobs.len());
    }
    Ok(())
}

/// The result of a file and its messages.
type Done = (Result<Written>, String);

/// Fills `count` files side by side and takes the results in the order of the files.
fn side_by_side(
    count: usize,
    progress: &Progress,
    fill: &(dyn Fn(usize, Place<'_>) -> Result<Written> + Sync),
    mut take: impl FnMut(usize, Done),
) {
    let all = SideBySide::default();
    let next = AtomicUsize::new(0);
    let (sender, receiver) = mpsc::channel();
    let one = |number: usize| -> Done {
        let place = Place { all: &all, number };
        kept(|| {
            let filled = catch_unwind(AssertUnwindSafe(|| fill(number, place)));
            filled.unwrap_or_else(|_| Err(anyhow!("the fill ended by an error of the program")))
        })
    };
    std::thread::scope(|scope| {
        for _ in 0..rayon::current_num_threads().min(count) {
            let (sender, next, one) = (sender.clone(), &next, &one);
            scope.spawn(move || {
                // each in a pool of its own, so that no thread that waits begins with another file
                let pool = ThreadPoolBuilder::new().build();
                loop {
                    let number = next.fetch_add(1, Ordering::Relaxed);
                    if number >= count {
                        return;
                    }
                    progress.begin(number);
                    let done = match &pool {
                        Ok(pool) => pool.install(|| one(number)),
                        Err(_) => one(number),
                    };
                    progress.end(number);
                    if sender.send((number, done)).is_err() {
                        return;
                    }
                }
            });
        }
        drop(sender);
        let taken = catch_unwind(AssertUnwindSafe(|| {
            let (mut waiting, mut concluded) = (BTreeMap::new(), 0);
            for (number, done) in receiver {
                waiting.insert(number, done);
                while let Some(done) = waiting.remove(&concluded) {
                    take(concluded, done);
                    concluded += 1;
                    all.conclude();
                }
            }
        }));
        if let Err(panic) = taken {
            // the scope waits for its threads, and these may wait for their turn
            all.end();
            resume_unwind(panic);
        }
    });
}

/// A line on a terminal with the files that are being filled.
struct Progress<'a> {
    bar: ProgressBar,
    jobs: &'a [MeshFiles],
    /// The number of files that were filled, and those that are being filled.
    state: Mutex<(usize, BTreeSet<usize>)>,
}

impl<'a> Progress<'a> {
    fn new(jobs: &'a [MeshFiles], quiet: bool) -> Self {
        Self {
            bar: spinner(quiet),
            jobs,
            state: Mutex::default(),
        }
    }

    fn begin(&self, number: usize) {
        self.show(|(_, running)| {
            running.insert(number);
        });
    }

    fn end(&self, number: usize) {
        self.show(|(filled, running)| {
            *filled += 1;
            running.remove(&number);
        });
    }

    fn show(&self, change: impl FnOnce(&mut (usize, BTreeSet<usize>))) {
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        change(&mut state);
        let (filled, running) = &*state;
        let names = running
            .iter()
            .map(|&k| self.jobs[k].input.display().to_string());
        let names = names.collect::<Vec<_>>().join(", ");
        let count = self.jobs.len();
        self.bar
            .set_message(format!("{filled} of {count} files; now {names}"));
    }
}

/// Refuses options with places, loop numbers or steps of one mesh, or with one file to write.
fn refuse_options_for_one_mesh(args: &FillArguments) -> Result<()> {
    let listed = matches!(args.loops.loops, LoopChoice::Listed(_));
    let flow = &args.flow;
    let options = [
        ("--loop-at", !args.loops.loop_at.is_empty()),
        ("--loops with numbers", listed),
        ("--part", !args.part.is_empty()),
        ("--bridge-faces", args.bridge_faces.is_some()),
        (
            "--loop-continuity",
            !flow.controls.0.loop_continuity.is_empty(),
        ),
        ("--schedule", flow.schedule.is_some()),
        ("--trace", flow.trace.is_some()),
        ("--picture", flow.picture.path().is_some()),
    ];
    if let Some((name, _)) = options.iter().find(|(_, given)| *given) {
        let text = format!("{name} is for one mesh: use it with -o OUT instead of --out-dir");
        return Err(UsageError(text).into());
    }
    Ok(())
}

/// The input and output of each file, checked so that no output replaces an input, another output
/// or the report.
fn jobs(args: &FillArguments, folder: &Path) -> Result<Vec<MeshFiles>> {
    let inputs = &args.files.inputs;
    let mut by_name: BTreeMap<PathBuf, &Path> = BTreeMap::new();
    let mut jobs = Vec::new();
    for input in inputs {
        let Some(name) = input.file_name() else {
            bail!("{} is not the name of a file", input.display());
        };
        let output = folder.join(name);
        if let Some(other) = by_name.insert(output.clone(), input) {
            bail!(
                "{} and {} would both be written to {}; nothing was filled",
                other.display(),
                input.display(),
                output.display()
            );
        }
        jobs.push(MeshFiles {
            more: Vec::new(),
            input: input.clone(),
            output,
            options: args.files.options.clone(),
        });
    }
    for output in jobs.iter().map(|job| &job.output).filter(|o| o.exists()) {
        if let Some(input) = inputs.iter().find(|i| io::same_file(i, output)) {
            bail!(
                "{} would replace the input {}; choose another --out-dir, nothing was overwritten",
                output.display(),
                input.display()
            );
        }
    }
    fs::create_dir_all(folder)
        .with_context(|| format!("cannot create the folder {}", folder.display()))?;
    let taken: Vec<Named<'_>> = jobs.iter().flat_map(MeshFiles::named).collect();
    check_targets(&taken, &[], &[("--report", args.flow.report.as_deref())])?;
    Ok(jobs)
}

/// The message of an error, with the file if it does not name it.
fn with_name(file: &str, text: String) -> String {
    if text.contains(file) {
        text
    } else {
        format!("{file}: {text}")
    }
}

const HEAD: [&str; 6] = [
    "file",
    "holes",
    "filled",
    "warnings",
    "expected error",
    "seconds",
];

/// A row of the table; a file without a result has empty cells.
fn row(file: &str, report: Option<&FillReport>) -> [String; 6] {
    let Some(report) = report else {
        return [file, "failed", "-", "-", "-", "-"].map(String::from);
    };
    let filled = report.totals.holes;
    let warnings: usize = report.holes.iter().map(|h| h.warnings.iter().count()).sum();
    let expected = report.expected_error();
    [
        file.into(),
        (filled + report.failed.len()).to_string(),
        filled.to_string(),
        warnings.to_string(),
        expected.map_or_else(|| "-".into(), |error| format!("{:.2} %", 100.0 * error)),
        format!("{:.2}", report.totals.seconds),
    ]
}

/// Columns with aligned edges: the first on the left, the others on the right.
fn table(rows: &[[String; 6]]) -> String {
    let width = |c: usize| rows.iter().map(|row| row[c].chars().count()).max();
    let widths: Vec<usize> = (0..6).map(|c| width(c).unwrap_or(0)).collect();
    let mut text = String::new();
    for [file, numbers @ ..] in rows {
        // writing to a String cannot fail
        let _ = write!(text, "{file:<0$}", widths[0]);
        for (cell, width) in numbers.iter().zip(&widths[1..]) {
            let _ = write!(text, "  {cell:>width$}");
        }
        text.push('\n');
    }
    text
}

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::*;

    #[derive(Parser)]
    struct Line {
        #[command(flatten)]
        files: MeshFiles,
    }

    /// The files that wait for their turn end too.
    #[test]
    fn a_panic_while_results_are_taken_ends_the_batch() {
        let job = |_| Line::parse_from(["fill", "in.obj", "-o", "out.obj"]).files;
        let jobs: Vec<MeshFiles> = (0..3).map(job).collect();
        let progress = Progress::new(&jobs, true);
        let fill = |_: usize, place: Place<'_>| {
            place.wait_for_turn();
            bail!("not filled")
        };
        let batch = || side_by_side(jobs.len(), &progress, &fill, |_, _| panic!("not taken"));
        assert!(catch_unwind(AssertUnwindSafe(batch)).is_err());
    }
}

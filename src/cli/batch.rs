//! `meniscus fill` with several files.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use serde::Serialize;

use crate::cli::fill::{FillArguments, fill_file};
use crate::cli::flow::{FlowArguments, MeshFiles, write_text};
use crate::cli::print::print;
use crate::cli::report::FillReport;
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

/// Fills all input files one after the other, each into the folder under its own name. A file that
/// fails does not end the batch.
pub fn batch(args: &FillArguments, folder: &Path) -> Result<()> {
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
    for (k, files) in jobs.iter().enumerate() {
        let file = files.input.display().to_string();
        if !quiet {
            eprintln!("{} of {}: {file}", k + 1, jobs.len());
        }
        let (report_of_file, result) = match fill_file(args, files, &flow) {
            Ok(written) => (Some(written.report), written.failures),
            Err(error) => (None, Err(error)),
        };
        let error = result.err().map(|e| with_name(&file, message(&e)));
        if let Some(error) = &error {
            eprintln!("meniscus: {error}");
            failed += 1;
        }
        rows.push(row(&file, report_of_file.as_ref()));
        if report.is_some() {
            entries.push(FileReport {
                file,
                error,
                report: report_of_file,
            });
        }
    }
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

/// Refuses options with places, loop numbers or steps of one mesh, or with one file to write.
fn refuse_options_for_one_mesh(args: &FillArguments) -> Result<()> {
    let listed = matches!(args.loops.loops, LoopChoice::Listed(_));
    let flow = &args.flow;
    let options = [
        ("--loop-at", !args.loops.loop_at.is_empty()),
        ("--loops with numbers", listed),
        ("--part", !args.part.is_empty()),
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
    let filled = report.holes.len();
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

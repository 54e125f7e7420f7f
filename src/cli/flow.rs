//! Shared parts of the commands that fill with a flow: arguments, checks, and writing the result.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use clap::Args;

use crate::cli::UsageError;
use crate::cli::hints::{invalid_energy, print_warnings, with_memory_hint};
use crate::cli::options::OptionArguments;
use crate::cli::print::{Textures, largest, print, save_with_companions, say, say_notes};
use crate::cli::progress::{Progress, Work};
use crate::cli::report::{FailedHole, FillReport, SkippedLoop, hole_reports, totals};
use crate::cli::result_picture::ResultPicture;
use crate::cli::side_by_side::Place;
use crate::cli::targets::{Named, check_targets};
use crate::cli::trace::Trace;
use crate::energy::Energy;
use crate::fill::{
    Continuity, Controls, ControlsError, Filled, LoopChoice, PreparedFill, RimSet, choose,
    nearest_loop,
};
use crate::io::{self, OpenError, Opened, open_joined, open_welded};
use crate::memory::peak_memory;
use crate::mesh::{Attributes, BoundaryLoop, DVec3, LoopId, Mesh, VertexId, Weld};
use crate::ops::{FlowSpec, OperationError};
use crate::options::Choice;
use crate::runner::{RunControls, Schedule};

use super::parse::point;

/// The files of a command that changes a mesh.
#[derive(Debug, Args)]
pub struct MeshFiles {
    /// The mesh to read (.obj, .ply, .stl, .off, .glb, .gltf, .3mf).
    #[arg(value_name = "IN")]
    pub input: PathBuf,
    /// Further meshes to read, which are joined with the first.
    #[arg(skip)]
    pub more: Vec<PathBuf>,
    /// The mesh to write (.obj, .ply, .stl, .off, .glb, .gltf, .3mf).
    #[arg(short, long, value_name = "OUT")]
    pub output: PathBuf,
    /// How they are read and written.
    #[command(flatten)]
    pub options: FileOptions,
}

/// How meshes are read and written.
#[derive(Clone, Debug, Args)]
pub struct FileOptions {
    /// The distance within which vertices of IN count as one: auto (the rounding of its numbers) or a
    /// length.
    #[arg(long, value_name = "WELD", default_value = "auto", display_order = 999)]
    pub weld: Weld,
    /// What to do with material libraries and images if OUT is in another folder: copy them beside it,
    /// or keep them where they are and refer to them there.
    #[arg(long, value_enum, default_value_t, display_order = 999)]
    pub textures: Textures,
    /// Print only errors.
    #[arg(short, long, display_order = 1000)]
    pub quiet: bool,
}

impl MeshFiles {
    /// Checks that OUT can be written, then opens IN.
    pub fn open(&self) -> Result<Opened> {
        let [input, output] = self.named();
        check_targets(&[input], &[output], &[])?;
        Ok(self.read()?)
    }

    /// Both files with their names on the command line.
    pub fn named(&self) -> [Named<'_>; 2] {
        [("IN", Some(&self.input)), ("OUT", Some(&self.output))]
    }

    /// Opens IN, or all meshes joined, and prints the notes of loading.
    pub fn read(&self) -> Result<Opened, OpenError> {
        let opened = if self.more.is_empty() {
            open_welded(&self.input, self.options.weld)?
        } else {
            let all: Vec<PathBuf> = self.inputs().cloned().collect();
            open_joined(&all, self.options.weld)?
        };
        if !self.options.quiet {
            say_notes(&self.input_names(), &opened.report);
        }
        Ok(opened)
    }

    /// The memory in bytes that reading IN takes at most: binary files become ten times as large.
    pub fn memory_to_read(&self) -> f64 {
        let sizes = self
            .inputs()
            .filter_map(|path| Some(path.metadata().ok()?.len()));
        10.0 * sizes.sum::<u64>() as f64
    }

    fn inputs(&self) -> impl Iterator<Item = &PathBuf> {
        std::iter::once(&self.input).chain(&self.more)
    }

    /// The names of all meshes to read.
    fn input_names(&self) -> String {
        let names: Vec<String> = self.inputs().map(|p| p.display().to_string()).collect();
        names.join(", ")
    }
}

/// The choice of loops.
#[derive(Debug, Default, Args)]
pub struct LoopArguments {
    /// Choose the loop with the vertex nearest to this point, instead of --loops (repeatable).
    #[arg(long, value_name = "X,Y,Z", value_parser = point, allow_hyphen_values = true)]
    pub loop_at: Vec<DVec3>,
    /// The loops to choose: auto (all that are not classified as outer boundaries), all,
    /// all-but-largest, or numbers as listed by `meniscus info`.
    #[arg(
        long,
        value_name = "CHOICE",
        default_value = "auto",
        conflicts_with = "loop_at"
    )]
    pub loops: LoopChoice,
}

impl LoopArguments {
    /// Whether no loop is named.
    pub fn are_auto(&self) -> bool {
        self.loop_at.is_empty() && self.loops == LoopChoice::Auto
    }

    /// Whether loops are chosen one by one.
    pub fn are_named(&self) -> bool {
        !self.loop_at.is_empty() || matches!(self.loops, LoopChoice::Listed(_))
    }

    /// Why a loop is not chosen.
    pub fn reason_to_skip(&self, one: &BoundaryLoop) -> String {
        if self.are_auto() && one.is_outer_boundary {
            one.why_outer()
        } else if self.loop_at.is_empty() && self.loops == LoopChoice::All {
            "the hole around it is filled without this island".into()
        } else {
            "not chosen".into()
        }
    }

    /// The chosen loops in ascending order.
    pub fn chosen(&self, mesh: &Mesh, loops: &[BoundaryLoop]) -> Result<Vec<LoopId>> {
        if self.loop_at.is_empty() {
            return Ok(choose(loops, &self.loops)?);
        }
        let mut chosen = Vec::new();
        for &point in &self.loop_at {
            let Some(id) = nearest_loop(mesh, loops, point) else {
                bail!("--loop-at: the mesh has no boundary loop");
            };
            chosen.push(id);
        }
        chosen.sort_unstable();
        chosen.dedup();
        Ok(chosen)
    }
}

/// The flow, and the files written beside the mesh.
#[derive(Clone, Debug, Default, Args)]
pub struct FlowArguments {
    /// The options of the flow.
    #[command(flatten)]
    pub controls: OptionArguments<Controls>,
    /// Apply these changes during the flow: CSV with the columns attempt,control,value, as copied
    /// by the window.
    #[arg(long, value_name = "FILE.csv")]
    pub schedule: Option<PathBuf>,
    /// Write a report as JSON.
    #[arg(long, value_name = "FILE.json")]
    pub report: Option<PathBuf>,
    /// Write every step as CSV.
    #[arg(long, value_name = "FILE.csv")]
    pub trace: Option<PathBuf>,
    /// The picture of the result.
    #[command(flatten)]
    pub picture: ResultPicture,
}

impl FlowArguments {
    /// Checks the values that the parser of the arguments cannot check alone.
    pub fn check(&self) -> Result<()> {
        self.controls.0.options().map_err(|e| usage(&e))?;
        self.picture.check()
    }
}

/// A command whose arguments are valid.
pub struct FlowCommand<'a> {
    files: &'a MeshFiles,
    args: &'a FlowArguments,
    /// The mesh.
    pub opened: Opened,
    /// The flow.
    pub flow: FlowSpec,
    /// Its place among files that are processed at the same time.
    place: Option<Place<'a>>,
}

impl<'a> FlowCommand<'a> {
    /// Checks the options and output paths, then reads the schedule and the mesh.
    pub fn new(files: &'a MeshFiles, args: &'a FlowArguments) -> Result<Self> {
        args.check()?;
        let [_, output] = files.named();
        let mut read: Vec<Named<'_>> = vec![("--schedule", args.schedule.as_deref())];
        read.extend(files.inputs().map(|path| ("IN", Some(&**path))));
        let controls = args.controls.0.clone();
        check_targets(
            &read,
            &[output],
            &[
                ("--report", args.report.as_deref()),
                ("--trace", args.trace.as_deref()),
                ("--picture", args.picture.path()),
            ],
        )?;
        let schedule = match &args.schedule {
            Some(path) => schedule(path, &controls)?,
            None => Schedule::default(),
        };
        // start the threads of the pool while the file is read
        rayon::spawn(|| ());
        Ok(Self {
            files,
            args,
            opened: files.read()?,
            flow: FlowSpec { schedule, controls },
            place: None,
        })
    }

    /// The same beside other files.
    #[must_use]
    pub fn at(self, place: Option<Place<'a>>) -> Self {
        Self { place, ..self }
    }

    /// Fills holes and writes all requested files. `prepare` makes the first patches over the rims,
    /// `skipped` are the loops left open.
    pub fn fill(
        self,
        rim_sets: &[RimSet<'_>],
        skipped: Vec<SkippedLoop>,
        prepare: impl FnOnce(&Mesh) -> Result<PreparedFill<'_>, OperationError>,
    ) -> Result<Written> {
        if !self.files.options.quiet {
            say_skipped(&skipped);
            if rim_sets.is_empty() {
                say(&nothing_to_do(skipped.len()));
            }
            for message in without_effect(&self.flow, rim_sets) {
                say(&format!("no effect: {message}"));
            }
        }
        let progress = Progress::new(Work::Holes(rim_sets.len()), self.files.options.quiet);
        let prepared = prepare(&self.opened.mesh)?;
        let memory = prepared.memory();
        let share = self.place.map(|place| place.all.memory(memory));
        // both sides of a rim joined without continuous normals are drawn separately
        let controls = &self.flow.controls;
        let creases = prepared.rim_edges(|id| controls.continuity_at(id) == Continuity::G0);
        let filled = prepared.run(&|group, record| {
            progress.step(group, record);
            true
        });
        drop(share);
        let filled = filled.map_err(with_memory_hint)?;
        progress.finish();
        self.save(&filled, skipped, creases)
    }

    /// Writes the mesh and all other requested files, and prints the warnings. `creases` are rim
    /// edges whose two sides a picture draws separately.
    pub fn save(
        self,
        filled: &Filled,
        skipped: Vec<SkippedLoop>,
        creases: Vec<[VertexId; 2]>,
    ) -> Result<Written> {
        let Self {
            files,
            args,
            opened,
            flow,
            place,
        } = self;
        // files that another one copies or writes as well are always those of the first
        if let Some(place) = place.filter(|_| refers_to_files(&filled.mesh.attributes)) {
            place.wait_for_turn();
        }
        let companions = save_with_companions(
            &files.output,
            &filled.mesh,
            files.options.textures,
            files.options.quiet,
        )?;
        let first = filled.mesh.face_count() - filled.faces_added();
        args.picture.save(&filled.mesh, first, creases)?;
        let holes = hole_reports(filled, &flow.controls.options()?);
        let report = FillReport {
            version: env!("CARGO_PKG_VERSION"),
            input: files.input_names(),
            output: files.output.display().to_string(),
            energy: flow.controls.energy.clone(),
            scheme: flow.controls.scheme.name(),
            mode: flow.controls.mode.name(),
            load: opened.report,
            totals: totals(filled, &holes),
            holes,
            failed: failed_holes(filled),
            skipped,
            peak_memory: peak_memory(),
            memory_estimate: filled.memory_estimate,
        };
        if let Some(path) = &args.report {
            let mut text = serde_json::to_string_pretty(&report)?;
            text.push('\n');
            write_text(path, &text)?;
        }
        if let Some(path) = &args.trace {
            write_text(path, Trace::of_fill(filled).text())?;
        }
        if !files.options.quiet {
            for hole in &report.holes {
                print_warnings(&format!("hole {}: ", hole.id), hole.warnings.iter());
            }
        }
        let failures = failures(&report, filled, &files.output).and(companions);
        Ok(Written { report, failures })
    }
}

/// The holes that could not be filled.
pub fn failed_holes(filled: &Filled) -> Vec<FailedHole> {
    let failed = filled.failed.iter().filter_map(|error| {
        let reason = error.to_string();
        error.hole().map(|id| FailedHole { id, reason })
    });
    failed.collect()
}

/// Whether a written mesh has material libraries or images beside it.
fn refers_to_files(all: &Attributes) -> bool {
    let has_libraries = !all.own_materials.is_empty() || !all.material_libraries.is_empty();
    has_libraries || all.gltf_materials.is_some() || all.texture_files().next().is_some()
}

/// A mesh that was filled and written.
pub struct Written {
    /// The report.
    pub report: FillReport,
    /// The error if a chosen hole was not filled, or a file beside the mesh is another one.
    pub failures: Result<()>,
}

impl Written {
    /// Prints a summary, unless `quiet`, and returns the failures.
    pub fn conclude(self, quiet: bool) -> Result<()> {
        if !quiet {
            summary(&self.report)?;
        }
        self.failures
    }
}

/// The error if a chosen hole was not filled.
fn failures(report: &FillReport, filled: &Filled, output: &Path) -> Result<()> {
    if let Some(first) = report.failed.first() {
        let (failed, filled) = (report.failed.len(), report.totals.holes);
        if filled == 0 {
            bail!("no hole could be filled. First error: {}", first.reason);
        }
        bail!(
            "{failed} of {} holes could not be filled; {} contains the others. First error: {}",
            failed + filled,
            output.display(),
            first.reason
        );
    }
    let mut groups = filled.groups.iter().enumerate();
    let failed = groups.find_map(|(g, r)| Some((filled.first_hole(g)?.id(), r.as_ref().err()?)));
    if let Some((id, error)) = failed {
        bail!(
            "hole {id}: {error}. {} contains the first patch there",
            output.display()
        );
    }
    Ok(())
}

fn summary(report: &FillReport) -> Result<()> {
    let t = &report.totals;
    let expected = report.expected_error();
    let expected = expected.map_or_else(String::new, |error| {
        format!("; expected error {:.2} % of the hole radius", 100.0 * error)
    });
    print(&format!(
        "{}: {} {} filled, {} vertices and {} faces added in {:.2} s{expected}\n",
        report.output,
        t.holes,
        if t.holes == 1 { "hole" } else { "holes" },
        t.vertices_added,
        t.faces_added,
        t.seconds
    ))
}

/// The options of a flow that have no effect on a fill of these rims, with the reasons.
fn without_effect(flow: &FlowSpec, rim_sets: &[RimSet<'_>]) -> Vec<String> {
    let FlowSpec { controls, schedule } = flow;
    let mut messages = Vec::new();
    let filled = |id: LoopId| rim_sets.iter().flatten().any(|rim| rim.id == id);
    let open = controls.loop_continuity.keys().filter(|id| !filled(**id));
    messages
        .extend(open.map(|id| format!("--loop-continuity {id}, because loop {id} is not filled")));
    // a schedule may change the surface model and the energy
    if !schedule.entries.is_empty() {
        return messages;
    }
    let unused: Vec<String> = controls
        .unused()
        .iter()
        .map(|name| format!("--{name}"))
        .collect();
    if !unused.is_empty() {
        let surface = controls.surface.name();
        messages.push(format!("{} with --surface {surface}", unused.join(", ")));
    } else if let Ok(energy) = Energy::parse(&controls.energy, &controls.param) {
        let unknown = controls
            .param
            .keys()
            .filter(|name| !energy.params().contains_key(*name));
        let text = &controls.energy;
        messages.extend(
            unknown.map(|name| format!("--param {name}, because `{text}` does not contain it")),
        );
    }
    messages
}

/// Maximum number of open loops that are named.
const MAX_NAMED: usize = 10;

/// Names the longest of the loops left open, and counts the others.
pub fn say_skipped(skipped: &[SkippedLoop]) {
    let (named, others) = largest(skipped, MAX_NAMED, |one| one.edges);
    for (_, SkippedLoop { id, edges, reason }) in named {
        say(&format!("loop {id} ({edges} edges) left open: {reason}"));
    }
    if let Some(most) = others.iter().map(|one| one.edges).max() {
        let count = others.len();
        say(&format!(
            "{count} more loops of at most {most} edges left open; --report lists them with the reasons"
        ));
    }
}

fn nothing_to_do(loops: usize) -> String {
    if loops == 0 {
        "no boundary loops: the mesh is closed and is written unchanged".into()
    } else {
        format!(
            "nothing to fill: all {loops} boundary loops are left open (choose some with --loops or \
             --loop-at); the mesh is written as it is"
        )
    }
}

/// Reads a schedule and checks it against these controls.
pub fn schedule<C: RunControls>(path: &Path, controls: &C) -> Result<Schedule> {
    let text = std::fs::read_to_string(path)
        .with_context(|| format!("cannot read the schedule {}", path.display()))?;
    let schedule = Schedule::parse(&text);
    let checked = schedule.and_then(|s| s.recording(controls).map(|_| s));
    checked.map_err(|error| UsageError(format!("{}: {error}", path.display())).into())
}

/// The error of controls with a value out of range.
pub fn usage(error: &ControlsError) -> UsageError {
    error
        .expression()
        .map_or_else(|| UsageError(error.to_string()), invalid_energy)
}

/// Writes a text file.
pub fn write_text(path: &Path, text: &str) -> Result<()> {
    Ok(io::save_text(path, text)?)
}

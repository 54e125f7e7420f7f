//! A flow: the steps of one method, their step size, and the stopping rules.

use crate::cancel::is_cancelled;
use crate::energy::{Energy, Order};
use crate::mesh::DVec3;
use crate::solver::assembly::{Assembler, EnergySum, MatrixForm};
use crate::solver::control::{
    Attempt, Mode, STAGNATION, STAGNATION_CONSTRAINED, STOP, StagnationTest, StepSizeControl, Tau,
};
use crate::solver::diffusion::DiffusionFlow;
use crate::solver::gradient_term::GradientTerm;
use crate::solver::mixed::MixedFlow;
use crate::solver::normal::NormalFlow;
use crate::solver::options::{FlowOptions, Scheme, SurfaceModel};
use crate::solver::pinch::PinchWatch;
use crate::solver::record::{End, Outcome, StepKind, StepRecord};
use crate::solver::relax::Relaxation;
use crate::solver::stepper::{StepRequest, Stepper};
use crate::solver::unknowns::Unknowns;
use crate::solver::{FlowProblem, Reference, SolverError};
use crate::subdivision::Rule;
use crate::surface::{SurfaceStats, sample_surface};
use crate::warning::{Warning, Warnings};

/// Makes the stepper of a flow at the starting positions of a problem. The energy is that of the
/// options for the problem's radius.
pub type MakeStepper =
    fn(&FlowProblem, &FlowOptions, &Energy) -> Result<Box<dyn Stepper>, SolverError>;

/// Number of attempts at relaxing after a step; each attempt moves half as far as the previous one.
const RELAXATION_TRIES: usize = 3;
/// Number of factorized steps before fast mode keeps the factor.
const FACTORIZED_STEPS: usize = 2;

/// A flow in progress.
pub struct Flow {
    problem: FlowProblem,
    options: FlowOptions,
    /// The options' energy with tension and spontaneous curvature.
    energy: Energy,
    make: MakeStepper,
    stepper: Box<dyn Stepper>,
    control: StepSizeControl,
    /// Computes reported energies; made when needed.
    report: Option<Report>,
    relaxation: Option<Relaxation>,
    stagnation: StagnationTest,
    pinch: PinchWatch,
    steps: usize,
    rejected: usize,
    factorized: usize,
    end: Option<End>,
    energy_start: f64,
    warnings: Warnings,
}

impl Flow {
    /// Starts a flow by the scheme of the options from the problem's starting positions.
    ///
    /// # Errors
    /// An invalid option, an energy that is not finite at the start, or a failed symbolic
    /// factorization.
    pub fn new(problem: FlowProblem, options: FlowOptions) -> Result<Self, SolverError> {
        Self::with_stepper(problem, options, scheme_stepper)
    }

    /// The same with the stepper that `make` constructs.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn with_stepper(
        problem: FlowProblem,
        options: FlowOptions,
        make: MakeStepper,
    ) -> Result<Self, SolverError> {
        options.validate()?;
        let energy = options.energy_at(problem.radius());
        let prepare = || Start::new(&problem, &options, &energy, make);
        let (report, start) = if options.surface == SurfaceModel::Energy {
            let (report, start) = rayon::join(|| Report::new(&problem, &energy, &options), prepare);
            (Some(report), start?)
        } else {
            (None, prepare()?)
        };
        let energy_start = match &report {
            Some((_, start)) => *start,
            None => start.stepper.state().energy.value,
        };
        if !energy_start.is_finite() {
            let stats = stats(&problem, &options, &energy);
            return Err(SolverError::energy_not_finite(&stats));
        }
        Ok(Self {
            control: Self::fresh_control(&options, &*start.stepper, start.tau_ref),
            relaxation: None,
            stagnation: StagnationTest::default(),
            pinch: PinchWatch::new(&problem),
            problem,
            options,
            energy,
            make,
            stepper: start.stepper,
            report: report.map(|report| report.0),
            steps: 0,
            rejected: 0,
            factorized: 0,
            end: None,
            energy_start,
            warnings: start.warnings,
        })
    }

    fn fresh_control(
        options: &FlowOptions,
        stepper: &dyn Stepper,
        tau_ref: f64,
    ) -> StepSizeControl {
        let first = match options.mode {
            Mode::Flow => stepper.first_tau(tau_ref),
            Mode::Fast => tau_ref,
        };
        StepSizeControl::new(options.mode, options.tau, tau_ref, first, options.growth)
    }

    /// The problem.
    pub fn problem(&self) -> &FlowProblem {
        &self.problem
    }

    /// The current options.
    pub fn options(&self) -> &FlowOptions {
        &self.options
    }

    /// Current positions of all vertices of the region, relative to the problem's centre.
    pub fn positions(&self) -> &[DVec3] {
        &self.stepper.state().positions
    }

    /// Current energy by the rule of the steps.
    pub fn energy(&self) -> EnergySum {
        self.stepper.state().energy
    }

    /// The natural time of the hole, `τ_ref`; display τ relative to it.
    pub fn tau_ref(&self) -> f64 {
        self.control.tau_ref
    }

    /// The time step of the next attempt.
    pub fn tau(&self) -> f64 {
        self.control.tau
    }

    /// Warnings so far, as text.
    pub fn warnings(&self) -> &Warnings {
        &self.warnings
    }

    /// Energy at the start of this flow, by the rule of the steps with at least 12 points.
    pub fn energy_start(&self) -> f64 {
        self.energy_start
    }

    /// Energy of the current shape, by the rule of the steps with at least 12 points.
    pub fn fine_energy(&mut self) -> f64 {
        let state = self.stepper.state();
        if self.options.surface != SurfaceModel::Energy {
            return state.energy.value;
        }
        let (problem, energy, options) = (&self.problem, &self.energy, &self.options);
        let report = self
            .report
            .get_or_insert_with(|| Report::new(problem, energy, options).0);
        report.energy(&state.positions, energy)
    }

    /// Numbers of accepted and rejected steps.
    pub fn counts(&self) -> (usize, usize) {
        (self.steps, self.rejected)
    }

    /// Continues the counts from earlier steps of the same shape.
    #[must_use]
    pub fn counting_from(mut self, steps: usize, rejected: usize) -> Self {
        (self.steps, self.rejected) = (steps, rejected);
        self
    }

    /// Why the flow ended, if it has.
    pub fn end(&self) -> Option<End> {
        self.end
    }

    /// Ends the flow and keeps the current shape.
    pub fn cancel(&mut self) {
        self.finish(End::Cancelled);
    }

    /// Ends the flow with the caller's reason, if it has not ended, and keeps the current shape.
    pub fn finish(&mut self, end: End) {
        self.end.get_or_insert(end);
    }

    /// Changes options between steps. The flow continues from the current shape.
    ///
    /// # Errors
    /// Invalid options; the old options stay in force.
    pub fn set_options(&mut self, options: FlowOptions) -> Result<(), SolverError> {
        self.restart(options, self.make)
    }

    /// [`Self::set_options`] with the stepper that `make` constructs.
    ///
    /// # Errors
    /// As [`Self::set_options`].
    pub fn restart(&mut self, options: FlowOptions, make: MakeStepper) -> Result<(), SolverError> {
        options.validate()?;
        let energy = options.energy_at(self.problem.radius());
        let problem = self.problem.clone().with_positions(self.positions());
        let now = Start::new(&problem, &options, &energy, make)?;
        self.control = Self::fresh_control(&options, &*now.stepper, now.tau_ref);
        self.warnings.extend(now.warnings);
        self.stagnation = StagnationTest::default();
        self.factorized = 0;
        self.end = None;
        if energy.gradient() != self.energy.gradient() {
            self.report = None;
        }
        self.stepper = now.stepper;
        self.options = options;
        self.energy = energy;
        self.make = make;
        Ok(())
    }

    /// Continues a flow that has converged, with other reference shapes of the problem.
    pub fn set_references(&mut self, references: Vec<Reference>) {
        self.problem = self.problem.clone().with_references(references);
        self.stepper.set_references(&self.problem);
        self.stagnation = StagnationTest::default();
        self.end = None;
    }

    /// Attempts one step. Does nothing and returns `None` once the flow has ended.
    ///
    /// # Errors
    /// Errors that a smaller step cannot avoid.
    pub fn step(&mut self) -> Result<Option<StepRecord>, SolverError> {
        if is_cancelled() {
            self.cancel();
        }
        if self.end.is_some() {
            return Ok(None);
        }
        // a multiple of K is stationary everywhere (Gauss-Bonnet): its remaining gradient is the
        // error of the quadrature, and an adaptive τ would grow until that error moves the surface
        let still = self.options.surface == SurfaceModel::Energy
            && self.energy.order() == Order::Stationary
            && !matches!(self.options.tau, Tau::Fixed(_));
        if still || self.problem.interior().is_empty() {
            self.end = Some(End::Converged);
            return Ok(None);
        }
        if self.options.max_steps == 0 {
            self.end = Some(End::MaxSteps);
            return Ok(None);
        }
        let tau = self.control.tau;
        let next_tau = self.control.next();
        // constrained vertices follow the others
        let relaxing = self.options.relaxation > 0.0 && self.problem.interpolation().is_none();
        // relaxation moves the vertices for which the factor was computed
        let quick = self.options.mode == Mode::Fast
            && !matches!(self.options.tau, Tau::Fixed(_))
            && !relaxing;
        let before = self.energy();
        let attempt = self.stepper.attempt(&StepRequest {
            tau,
            next_tau,
            may_freeze: quick && self.factorized + 1 >= FACTORIZED_STEPS,
        });
        let mut record = self.record(&attempt, tau);
        if attempt.is_accepted() && relaxing {
            self.relax(before, attempt.max_displacement);
            record.energy = self.energy().value;
        }
        // vertices of a vector flow move along the surface, which changes triangles without a neck
        let has_necks = self.options.surface == SurfaceModel::Energy;
        if attempt.is_accepted() && has_necks && self.problem.interpolation().is_none() {
            self.watch_necks()?;
        }
        Ok(Some(record))
    }

    /// Ends the flow at the last shape with open necks if a neck is closing.
    fn watch_necks(&mut self) -> Result<(), SolverError> {
        let positions = &self.stepper.state().positions;
        let Some(place) = self.pinch.check(&self.problem, positions) else {
            return Ok(());
        };
        let open = self.problem.clone().with_positions(self.pinch.last_open());
        self.stepper = (self.make)(&open, &self.options, &self.energy)?;
        self.end = Some(End::Pinched);
        self.warnings.push(Warning::Pinched {
            at: place + self.problem.centre(),
            order: self.energy.order(),
        });
        Ok(())
    }

    /// Slides the vertices along the surface after a step from energy `before`, by at most the
    /// largest displacement of the step. The sliding therefore ends with the flow and does not
    /// prevent convergence.
    fn relax(&mut self, before: EnergySum, longest: f64) {
        let relaxation = self
            .relaxation
            .get_or_insert_with(|| Relaxation::new(&self.problem));
        let mut weight = self.options.relaxation;
        for _ in 0..RELAXATION_TRIES {
            let Some((vertices, normals)) = self.stepper.normals() else {
                return;
            };
            let positions = &self.stepper.state().positions;
            let moved = relaxation.propose(positions, vertices, normals, weight, longest);
            if moved.is_none_or(|moved| self.stepper.slide(moved, before)) {
                return;
            }
            weight *= 0.5;
        }
    }

    /// Counts an attempt, updates τ and decides whether the flow has ended.
    fn record(&mut self, attempt: &Attempt, tau: f64) -> StepRecord {
        let radius = self.problem.radius();
        let mut residual = f64::NAN;
        if attempt.is_accepted() {
            self.steps += 1;
            residual = match attempt.kind {
                StepKind::QuasiNewton => attempt.max_displacement / radius,
                _ => self.control.residual(attempt.max_displacement, tau, radius),
            };
            if attempt.kind != StepKind::QuasiNewton {
                self.factorized += 1;
                self.control.accept();
            }
            if attempt.needs_refactorization {
                // compute one new matrix, then take quasi-Newton steps again
                self.factorized = FACTORIZED_STEPS - 1;
            }
            // adaptive steps in true time may alternate between a stable and an unstable τ although
            // the shape is stationary to rounding
            let is_adaptive = !matches!(self.options.tau, Tau::Fixed(_));
            let energy = self.energy();
            let least = if self.options.mode == Mode::Flow {
                Some(STAGNATION)
            } else {
                self.problem.interpolation().map(|_| STAGNATION_CONSTRAINED)
            };
            let rests = least
                .filter(|_| is_adaptive)
                .is_some_and(|part| self.stagnation.has_stagnated(energy, part));
            if residual < STOP || rests {
                self.end = Some(End::Converged);
            } else if self.steps >= self.options.max_steps {
                self.end = Some(End::MaxSteps);
            }
        } else {
            self.rejected += 1;
            if attempt.needs_refactorization {
                self.factorized = FACTORIZED_STEPS - 1;
            } else if self.control.reject() {
                self.end = Some(End::StepSizeCollapsed);
            }
        }
        StepRecord {
            step: self.steps,
            tau,
            energy: self.energy().value,
            residual,
            rejection: attempt.rejection.clone(),
            kind: attempt.kind,
            iterations: attempt.linear.map(|l| l.iterations),
            linear_residual: attempt.linear.map(|l| l.relative_residual),
        }
    }

    /// Steps until the flow ends. `observe` is called after every attempt and returns whether to
    /// continue.
    ///
    /// # Errors
    /// As [`Self::step`].
    pub fn run(
        &mut self,
        mut observe: impl FnMut(&Self, &StepRecord) -> bool,
    ) -> Result<Outcome, SolverError> {
        while let Some(record) = self.step()? {
            if !observe(self, &record) {
                self.cancel();
            }
        }
        Ok(self.outcome())
    }

    /// The record of the whole flow so far.
    pub fn outcome(&mut self) -> Outcome {
        let energy_end = self.fine_energy();
        let mut warnings = self.warnings.clone();
        let vertices = self.stepper.frozen();
        if vertices > 0 {
            warnings.push(Warning::Frozen { vertices });
        }
        match self.end {
            Some(End::StepSizeCollapsed) => warnings.push(Warning::StepSizeCollapsed),
            Some(End::MaxSteps) => warnings.push(Warning::StepLimit {
                steps: self.steps,
                mixed: self.options.scheme == Scheme::Mixed,
            }),
            _ => {}
        }
        Outcome {
            end: self.end.unwrap_or(End::Cancelled),
            steps: self.steps,
            rejected: self.rejected,
            energy_start: self.energy_start,
            energy_end,
            warnings,
        }
    }
}

/// What a flow starts with.
struct Start {
    stepper: Box<dyn Stepper>,
    tau_ref: f64,
    warnings: Warnings,
}

impl Start {
    fn new(
        problem: &FlowProblem,
        options: &FlowOptions,
        energy: &Energy,
        make: MakeStepper,
    ) -> Result<Self, SolverError> {
        if options.surface != SurfaceModel::Energy {
            return Ok(Self {
                stepper: make(problem, options, energy)?,
                tau_ref: options.surface.natural_time(problem.radius()),
                warnings: Warnings::default(),
            });
        }
        let stats = stats(problem, options, energy);
        Ok(Self {
            stepper: make(problem, options, energy)?,
            tau_ref: stats.tau_ref,
            warnings: warnings(problem, energy, &stats),
        })
    }
}

/// Computes reported energies by at least twelve points (steps may use fewer).
struct Report {
    assembler: Assembler,
    gradient_term: Option<GradientTerm>,
}

impl Report {
    /// The report, and the energy at the starting positions.
    fn new(problem: &FlowProblem, energy: &Energy, options: &FlowOptions) -> (Self, f64) {
        let rule = options.quadrature.max(Rule::Twelve);
        let nothing = Unknowns::none(problem.positions().len());
        let elements = problem.discretization().elements(rule);
        let mut report = Self {
            assembler: Assembler::new(elements, rule, nothing),
            gradient_term: GradientTerm::of(problem, energy, rule),
        };
        let start = report.energy(problem.positions(), energy);
        (report, start)
    }

    fn energy(&mut self, positions: &[DVec3], energy: &Energy) -> f64 {
        let mut sum = self.assembler.energy(positions, energy);
        if let Some(term) = &mut self.gradient_term {
            sum += term.evaluate(positions);
        }
        sum.value
    }
}

/// Makes the stepper of the surface model and scheme in the options.
///
/// # Errors
/// [`SolverError::BadOption`] for the mixed schemes under constraints, and the errors of the
/// schemes.
pub fn scheme_stepper(
    problem: &FlowProblem,
    options: &FlowOptions,
    energy: &Energy,
) -> Result<Box<dyn Stepper>, SolverError> {
    if options.surface != SurfaceModel::Energy {
        let flow = DiffusionFlow::new(problem, options.surface, options.tension)?;
        return Ok(Box::new(flow));
    }
    if options.scheme == Scheme::Normal {
        let form = match options.mode {
            Mode::Flow => MatrixForm::Flow,
            Mode::Fast => MatrixForm::Stationary,
        };
        let flow = NormalFlow::new(problem, energy, options.quadrature, form)?;
        return Ok(Box::new(flow));
    }
    if problem.interpolation().is_some() {
        return Err(SolverError::BadOption {
            option: "scheme",
            value: "mixed".into(),
            expected: "a surface held at given points needs the scheme `normal`",
        });
    }
    let corrected = options.scheme == Scheme::MixedCorrected;
    let flow = MixedFlow::new(problem, energy, options.linear, corrected)?;
    Ok(Box::new(flow))
}

/// Curvature ranges and natural time at the problem's starting positions.
fn stats(problem: &FlowProblem, options: &FlowOptions, energy: &Energy) -> SurfaceStats {
    let elements = problem.discretization().elements(options.quadrature);
    sample_surface(elements, problem.positions(), energy, problem.radius())
}

/// Warnings for an energy on the surface with these `stats`.
fn warnings(problem: &FlowProblem, energy: &Energy, stats: &SurfaceStats) -> Warnings {
    let stationary = energy.order() == Order::Stationary;
    let posed = stats.warning(problem.centre()).into_iter();
    posed
        .chain(stationary.then_some(Warning::StationaryEnergy))
        .collect()
}

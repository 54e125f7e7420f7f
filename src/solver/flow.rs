//! A flow that is advanced step by step, by either scheme.

use crate::mesh::DVec3;
use crate::solver::assembly::{Assembler, EnergySum};
use crate::solver::control::{Attempt, Control, Mode, Progress, STOP, Tau};
use crate::solver::energy::{Energy, Order};
use crate::solver::guarded::GuardedFlow;
use crate::solver::mixed::{LinearSolver, MixedFlow};
use crate::solver::normal::NormalFlow;
use crate::solver::survey::{Survey, survey};
use crate::solver::unknowns::Unknowns;
use crate::solver::{FlowProblem, SolverError};
use crate::subdivision::{Elements, Rule, TableCache, elements};

/// Which of the two methods computes the steps.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Scheme {
    /// Scheme B, the linearly implicit normal flow.
    #[default]
    Normal,
    /// Descent of all three components in scheme B's metric, guarded against folds: for coarse
    /// irregular meshes, on which vertices have to slide along the surface as well.
    Guarded,
    /// Scheme A, the paper's mixed finite elements (21)-(23).
    Mixed,
    /// Scheme A with the exact gradient as right-hand side: the same matrix, another fixed point.
    MixedCorrected,
}

/// Everything about a flow that may be chosen.
#[derive(Clone, Debug)]
pub struct FlowOptions {
    /// f(H, K).
    pub energy: Energy,
    /// The method.
    pub scheme: Scheme,
    /// Stationary shape or true time.
    pub mode: Mode,
    /// Time step.
    pub tau: Tau,
    /// Steps after which the flow ends, converged or not.
    pub max_steps: usize,
    /// Scheme A's linear solver.
    pub linear: LinearSolver,
    /// Quadrature of scheme B's steps. Three interior points give the same errors as twelve on
    /// scans (measured) at a third of the cost; scheme A and reported energies always use twelve.
    pub quadrature: Rule,
}

impl FlowOptions {
    /// The defaults with the given energy: scheme B, fast mode, adaptive τ, at most 200 steps.
    pub fn new(energy: Energy) -> Self {
        Self {
            energy,
            scheme: Scheme::default(),
            mode: Mode::default(),
            tau: Tau::default(),
            max_steps: 200,
            linear: LinearSolver::default(),
            quadrature: Rule::Three,
        }
    }

    /// # Errors
    /// [`SolverError::BadOption`] naming the option that is out of range.
    pub fn validate(&self) -> Result<(), SolverError> {
        if let Tau::Fixed(t) | Tau::From(t) = self.tau
            && !(t.is_finite() && t > 0.0)
        {
            return Err(SolverError::BadOption {
                option: "tau",
                value: t.to_string(),
                expected: "a time step is a positive number (or `auto`)",
            });
        }
        Ok(())
    }
}

/// One line of the record of a flow.
#[derive(Clone, Debug, PartialEq)]
pub struct StepRecord {
    /// Accepted steps so far, this one included if it was accepted.
    pub step: usize,
    /// Its time step (for quasi-Newton steps that of the factor).
    pub tau: f64,
    /// Energy after it, by the quadrature rule of the steps.
    pub energy: f64,
    /// Displacement brought to `τ_ref`, over the hole radius; NaN if rejected.
    pub residual: f64,
    /// Whether it was rejected.
    pub rejected: bool,
    /// How it was computed.
    pub progress: Progress,
    /// Scheme A: iterations of GMRES.
    pub iterations: Option<usize>,
    /// Scheme A: relative residual of the linear solve.
    pub linear_residual: Option<f64>,
}

/// Why a flow ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// The stopping rule was met.
    Converged,
    /// `max_steps` were taken.
    Steps,
    /// τ collapsed: no step lowers the energy.
    Stuck,
    /// It was told to.
    Cancelled,
}

/// How a flow went.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// Why it ended.
    pub end: End,
    /// Accepted steps.
    pub steps: usize,
    /// Rejected steps.
    pub rejected: usize,
    /// Energy at the start, by the 12-point rule.
    pub energy_start: f64,
    /// Energy at the end, by the 12-point rule.
    pub energy_end: f64,
    /// Warnings in plain words.
    pub warnings: Vec<String>,
}

enum Stepper {
    Normal(Box<NormalFlow>),
    Guarded(Box<GuardedFlow>),
    Mixed(Box<MixedFlow>),
}

/// Factorized steps before fast mode goes over to the frozen factor.
const FACTORIZED_STEPS: usize = 2;

/// A flow in progress.
pub struct Flow {
    problem: FlowProblem,
    options: FlowOptions,
    stepper: Stepper,
    control: Control,
    report: Assembler,
    local: Elements,
    steps: usize,
    rejected: usize,
    factorized: usize,
    end: Option<End>,
    energy_start: f64,
    warnings: Vec<String>,
}

impl Flow {
    /// Sets a flow up at the problem's starting positions.
    ///
    /// # Errors
    /// A bad option, an energy that is not finite at the start, a failed symbolic factorization.
    pub fn new(problem: FlowProblem, options: FlowOptions) -> Result<Self, SolverError> {
        options.validate()?;
        let (topology, faces) = (problem.topology(), problem.active_faces());
        // the reported energies' twelve points beside the steps' own
        let ((report, energy_start), prepared) = rayon::join(
            || {
                let rule = Rule::Twelve;
                let fine = elements(topology, faces, rule, &mut TableCache::default());
                let nothing = Unknowns::none(problem.positions().len());
                let mut report = Assembler::new(&fine, rule, nothing);
                let start = report.gradient(problem.positions(), &options.energy, &mut Vec::new());
                (report, start.value)
            },
            || {
                let rule = options.quadrature;
                let local = elements(topology, faces, rule, &mut TableCache::default());
                let start = survey(
                    &local,
                    problem.positions(),
                    &options.energy,
                    problem.radius(),
                );
                let stepper = Self::stepper(&problem, &options, &local)?;
                Ok::<_, SolverError>((local, start, stepper))
            },
        );
        let (local, start, stepper) = prepared?;
        if !energy_start.is_finite() {
            return Err(start.not_finite());
        }
        let warnings = warnings(&problem, &options.energy, &start);
        let mut flow = Self {
            control: Control::new(options.mode, options.tau, start.tau_ref, start.tau_ref),
            problem,
            options,
            stepper,
            report,
            local,
            steps: 0,
            rejected: 0,
            factorized: 0,
            end: None,
            energy_start,
            warnings,
        };
        flow.restart_control(&start);
        Ok(flow)
    }

    fn stepper(
        problem: &FlowProblem,
        options: &FlowOptions,
        local: &Elements,
    ) -> Result<Stepper, SolverError> {
        let is_mixed = matches!(options.scheme, Scheme::Mixed | Scheme::MixedCorrected);
        if is_mixed && problem.interpolation().is_some() {
            return Err(SolverError::BadOption {
                option: "scheme",
                value: "mixed".into(),
                expected: "a surface held at given points needs the scheme `normal`",
            });
        }
        Ok(match options.scheme {
            Scheme::Normal => Stepper::Normal(Box::new(NormalFlow::new(
                problem,
                local,
                options.quadrature,
                &options.energy,
                options.mode == Mode::Flow,
            )?)),
            Scheme::Guarded => Stepper::Guarded(Box::new(GuardedFlow::new(
                problem,
                local,
                options.quadrature,
                &options.energy,
            )?)),
            Scheme::Mixed | Scheme::MixedCorrected => Stepper::Mixed(Box::new(MixedFlow::new(
                problem,
                &options.energy,
                options.linear,
                options.scheme == Scheme::MixedCorrected,
            )?)),
        })
    }

    fn restart_control(&mut self, survey: &Survey) {
        let gentle = match (&self.stepper, self.options.mode) {
            (Stepper::Normal(flow), Mode::Flow) => flow.gentle_tau(self.problem.topology()),
            (Stepper::Mixed(_), _) => 1e-3 * survey.tau_ref,
            _ => survey.tau_ref,
        };
        self.control = Control::new(self.options.mode, self.options.tau, survey.tau_ref, gentle);
        self.factorized = 0;
        self.end = None;
    }

    /// The problem.
    pub fn problem(&self) -> &FlowProblem {
        &self.problem
    }

    /// The options in force.
    pub fn options(&self) -> &FlowOptions {
        &self.options
    }

    /// Current positions of all vertices of the region, relative to the problem's centre.
    pub fn positions(&self) -> &[DVec3] {
        match &self.stepper {
            Stepper::Normal(flow) => flow.positions(),
            Stepper::Guarded(flow) => flow.positions(),
            Stepper::Mixed(flow) => flow.positions(),
        }
    }

    /// Current energy by the rule of the steps.
    pub fn energy(&self) -> EnergySum {
        match &self.stepper {
            Stepper::Normal(flow) => flow.energy(),
            Stepper::Guarded(flow) => flow.energy(),
            Stepper::Mixed(flow) => flow.energy(),
        }
    }

    /// The natural time of the hole, `τ_ref`; show τ relative to it.
    pub fn tau_ref(&self) -> f64 {
        self.control.tau_ref
    }

    /// Why the flow ended, if it has.
    pub fn end(&self) -> Option<End> {
        self.end
    }

    /// Ends the flow; the current shape stays.
    pub fn cancel(&mut self) {
        self.end.get_or_insert(End::Cancelled);
    }

    /// Changes options between steps; the flow goes on from the current shape.
    ///
    /// # Errors
    /// The new options are refused and the old ones stay in force.
    pub fn set_options(&mut self, options: FlowOptions) -> Result<(), SolverError> {
        options.validate()?;
        let problem = self.problem.clone().with_positions(self.positions());
        let fresh = (options.quadrature != self.options.quadrature).then(|| {
            elements(
                problem.topology(),
                problem.active_faces(),
                options.quadrature,
                &mut TableCache::default(),
            )
        });
        let local = fresh.as_ref().unwrap_or(&self.local);
        let now = survey(
            local,
            problem.positions(),
            &options.energy,
            problem.radius(),
        );
        self.stepper = Self::stepper(&problem, &options, local)?;
        if let Some(fresh) = fresh {
            self.local = fresh;
        }
        self.warnings
            .extend(warnings(&problem, &options.energy, &now));
        self.options = options;
        self.restart_control(&now);
        Ok(())
    }

    /// Attempts one step. Does nothing and returns `None` once the flow has ended.
    ///
    /// # Errors
    /// Only what a smaller step cannot mend.
    pub fn step(&mut self) -> Result<Option<StepRecord>, SolverError> {
        if self.end.is_some() {
            return Ok(None);
        }
        // a multiple of K is stationary everywhere (Gauss-Bonnet): what is left of its gradient is
        // the quadrature's error, and an adaptive τ would grow until that error moves the surface
        let still = self.options.energy.order() == Order::Stationary
            && !matches!(self.options.tau, Tau::Fixed(_));
        if still || self.problem.interior().is_empty() {
            self.end = Some(End::Converged);
            return Ok(None);
        }
        if self.options.max_steps == 0 {
            self.end = Some(End::Steps);
            return Ok(None);
        }
        let tau = self.control.tau;
        let next = self.control.next();
        let quick = self.options.mode == Mode::Fast && !matches!(self.options.tau, Tau::Fixed(_));
        let attempt = match &mut self.stepper {
            Stepper::Normal(flow) => {
                flow.attempt(tau, next, quick && self.factorized + 1 >= FACTORIZED_STEPS)
            }
            Stepper::Guarded(flow) => flow.attempt(tau),
            Stepper::Mixed(flow) => flow.attempt(tau),
        };
        Ok(Some(self.book(&attempt, tau)))
    }

    /// Counts an attempt, moves τ and decides whether the flow has ended.
    fn book(&mut self, attempt: &Attempt, tau: f64) -> StepRecord {
        let radius = self.problem.radius();
        let mut residual = f64::NAN;
        if attempt.accepted {
            self.steps += 1;
            residual = match attempt.progress {
                Progress::QuasiNewton => attempt.longest / radius,
                _ => self.control.residual(attempt.longest, tau, radius),
            };
            if attempt.progress != Progress::QuasiNewton {
                self.factorized += 1;
                self.control.accept();
            }
            if attempt.stale {
                // one fresh matrix, then quasi-Newton steps again
                self.factorized = FACTORIZED_STEPS - 1;
            }
            if residual < STOP {
                self.end = Some(End::Converged);
            } else if self.steps >= self.options.max_steps {
                self.end = Some(End::Steps);
            }
        } else {
            self.rejected += 1;
            if attempt.stale {
                self.factorized = FACTORIZED_STEPS - 1;
            } else if self.control.reject() {
                self.end = Some(End::Stuck);
            }
        }
        StepRecord {
            step: self.steps,
            tau,
            energy: self.energy().value,
            residual,
            rejected: !attempt.accepted,
            progress: attempt.progress,
            iterations: attempt.linear.map(|l| l.iterations),
            linear_residual: attempt.linear.map(|l| l.relative_residual),
        }
    }

    /// Steps until the flow ends; `observe` is called after every attempt and returns whether to
    /// go on.
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

    /// The record of the whole flow up to now.
    pub fn outcome(&mut self) -> Outcome {
        let positions = match &self.stepper {
            Stepper::Normal(flow) => flow.positions(),
            Stepper::Guarded(flow) => flow.positions(),
            Stepper::Mixed(flow) => flow.positions(),
        };
        let energy_end = self
            .report
            .gradient(positions, &self.options.energy, &mut Vec::new())
            .value;
        let mut warnings = self.warnings.clone();
        match self.end {
            Some(End::Stuck) => warnings.push(
                "not converged: the time step collapsed, no step lowers the energy any more; \
                 the last good shape is kept (try another energy, or --tau with a fixed value)"
                    .into(),
            ),
            Some(End::Steps) => warnings.push(format!(
                "not converged after {} steps; allow more with --steps{}",
                self.steps,
                if self.options.scheme == Scheme::Mixed {
                    ", or take --scheme mixed-corrected, which does not creep along the surface"
                } else {
                    ""
                }
            )),
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

/// What is to be said of an energy on the surface of a survey.
fn warnings(problem: &FlowProblem, energy: &Energy, survey: &Survey) -> Vec<String> {
    let mut warnings: Vec<String> = survey.warning(problem.centre()).into_iter().collect();
    if energy.order() == Order::Stationary {
        warnings.push(
            "this energy is a multiple of K, whose integral depends on the rim alone: every \
             surface is stationary and the first patch stays as it is"
                .into(),
        );
    }
    warnings
}

//! Scheme A: the paper's mixed finite element method, equations (18)-(23) corrected.
//!
//! The curvature normals `h = 2Hn` and `k = 2Kn` are unknowns of their own in piecewise linears on
//! rings 0 and 1, beside the positions of ring 0. All matrices are those of the present surface;
//! one linear system gives all unknowns at the new time. See [`assembly`] for the system,
//! [`splitting`] for what is taken implicitly.
//!
//! The system is solved for increments. With `h(x)`, `k(x)` the solutions of the second and third
//! rows at the present positions, these rows have right-hand side 0, and the first has
//!
//! - `−(l^p x + l^m h(x) + l^g k(x) + b)`: this is (23), written from the present state;
//! - in the residual-corrected variant `−δE`, the exact gradient (12).
//!
//! The plain scheme takes terms without `α..δ, ω, ϖ` explicitly and is unstable for energies that
//! have only such terms (`f = K`, for which the corrected variant stands still as it should).

mod assembly;
mod kernel;
mod pattern;
mod precond;
mod splitting;

use crate::linear::{GmresOptions, GmresReport, SparseLu, gmres};
use crate::mesh::{DVec3, FaceId};
use crate::solver::assembly::{Assembler, EnergySum, Unknowns};
use crate::solver::control::{Attempt, Progress};
use crate::solver::energy::Energy;
use crate::solver::survey::survey;
use crate::solver::{FlowProblem, SolverError};
use crate::subdivision::{Rule, TableCache, elements};

use assembly::{System, Units};
use precond::{BlockElimination, SchurKind};

/// How the linear system (23) is solved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LinearSolver {
    /// Restarted GMRES with block elimination as preconditioner, to a relative residual.
    Gmres {
        /// Wanted relative residual.
        tolerance: f64,
    },
    /// Sparse LU.
    Lu,
}

impl Default for LinearSolver {
    fn default() -> Self {
        Self::Gmres { tolerance: 1e-10 }
    }
}

/// State of scheme A.
pub struct MixedFlow {
    system: System,
    precond: BlockElimination,
    assembler: Assembler,
    energy: Energy,
    linear: LinearSolver,
    corrected: bool,
    positions: Vec<DVec3>,
    /// Curvature normals per vertex of the region; zero beyond ring 2.
    h: Vec<DVec3>,
    k: Vec<DVec3>,
    current: EnergySum,
    gradient: Vec<DVec3>,
    /// Whether the matrices and `force` are those of the present positions.
    assembled: bool,
    /// `δE`, exact or by the mixed form.
    force: Vec<DVec3>,
    trial: Vec<DVec3>,
    trial_gradient: Vec<DVec3>,
    position_block: Vec<f64>,
    rhs: Vec<f64>,
    solution: Vec<f64>,
}

impl MixedFlow {
    /// Sets the scheme up: elements of the 12-point rule, patterns, fixed curvature normals of
    /// ring 2 from the starting surface. `corrected` asks for the residual-corrected variant.
    ///
    /// # Errors
    /// [`SolverError::EnergyNotFinite`] if the energy is not finite at the start, or a failed
    /// symbolic factorization.
    pub fn new(
        problem: &FlowProblem,
        energy: &Energy,
        linear: LinearSolver,
        corrected: bool,
    ) -> Result<Self, SolverError> {
        let mut tables = TableCache::default();
        let (topology, faces) = (problem.topology(), problem.active_faces());
        let fine = elements(topology, faces, Rule::Twelve, &mut tables);
        let start = survey(&fine, problem.positions(), energy, problem.radius());
        let (h, k) = fixed_curvatures(problem, &mut tables);
        let length = problem.radius();
        let units = Units {
            length,
            force: length * length * length / start.tau_ref,
        };
        let moving = Unknowns::new(&fine, problem.positions(), problem.interior());
        let mut assembler = Assembler::new(&fine, Rule::Twelve, moving);
        let mut gradient = Vec::new();
        let current = assembler.gradient(problem.positions(), energy, &mut gradient);
        if !current.value.is_finite() {
            return Err(start.not_finite());
        }
        let system = System::new(problem, fine, units);
        Ok(Self {
            precond: BlockElimination::new(&system)?,
            rhs: vec![0.0; system.dimension()],
            solution: vec![0.0; system.dimension()],
            system,
            assembler,
            energy: energy.clone(),
            linear,
            corrected,
            positions: problem.positions().to_vec(),
            h,
            k,
            current,
            gradient,
            assembled: false,
            force: Vec::new(),
            trial: problem.positions().to_vec(),
            trial_gradient: Vec::new(),
            position_block: Vec::new(),
        })
    }

    /// Positions of all vertices of the region, relative to the problem's centre.
    pub fn positions(&self) -> &[DVec3] {
        &self.positions
    }

    /// Energy at the current positions, by the 12-point rule.
    pub fn energy(&self) -> EnergySum {
        self.current
    }

    /// The curvature normals `2Hn` and `2Kn` of all vertices of the region: unknowns of the last
    /// accepted step on rings 0 and 1, fixed on ring 2, zero beyond (and before the first step).
    pub fn curvature_normals(&self) -> (&[DVec3], &[DVec3]) {
        (&self.h, &self.k)
    }

    /// Number of scalar unknowns of the linear system.
    pub fn dimension(&self) -> usize {
        self.system.dimension()
    }

    /// One step of time `tau`. If it is rejected the state is what it was.
    ///
    /// # Errors
    /// Only what cannot be mended by a smaller step.
    pub fn attempt(&mut self, tau: f64) -> Result<Attempt, SolverError> {
        if !self.assembled {
            if let Err(note) = self.assemble() {
                return Ok(Attempt::rejected(Some(note)));
            }
            self.assembled = true;
        }
        self.system.position_block(tau, &mut self.position_block);
        let report = match self.solve() {
            Ok(report) => report,
            Err(note) => return Ok(Attempt::rejected(Some(note))),
        };
        if let Some(report) = report
            && !report.converged
        {
            return Ok(Attempt {
                linear: Some(report),
                ..Attempt::rejected(Some(format!(
                    "GMRES stopped at a relative residual of {:.1e} after {} iterations",
                    report.relative_residual, report.iterations
                )))
            });
        }
        let progress = match report {
            Some(_) => Progress::Krylov,
            None => Progress::Factorized,
        };
        let longest = self.displace();
        let mut attempt = Attempt {
            linear: report,
            progress,
            ..Attempt::rejected(None)
        };
        if !longest.is_finite() {
            return Ok(attempt);
        }
        let sum = self
            .assembler
            .gradient(&self.trial, &self.energy, &mut self.trial_gradient);
        if self.current.admits(&sum) {
            self.accept(sum);
            attempt.accepted = true;
            attempt.longest = longest;
        }
        Ok(attempt)
    }

    /// Matrices, `h(x)`, `k(x)` and the force at the present positions.
    fn assemble(&mut self) -> Result<(), String> {
        self.system
            .assemble(&self.positions, &self.h, &self.k, &self.energy);
        if !self.system.is_finite() {
            return Err("second derivatives of the energy are not finite on the surface".into());
        }
        self.precond
            .factorize_mass(&self.system)
            .map_err(|e| e.to_string())?;
        let system = &mut self.system;
        for (rhs, field) in [(&mut system.rhs_h, &mut self.h), (&mut system.rhs_k, &mut self.k)] {
            // m is held in units of r²
            self.precond.solve_mass(rhs, 3);
            let scale = system.units.length.powi(-2);
            let m = system.numbering.h.len();
            for (j, &v) in system.numbering.h.vertex.iter().enumerate() {
                field[v as usize] = DVec3::new(rhs[j], rhs[m + j], rhs[2 * m + j]) * scale;
            }
        }
        if self.corrected {
            self.force.clone_from(&self.gradient);
        } else {
            system.residual(
                &self.positions,
                &self.h,
                &self.k,
                &self.energy,
                &mut self.force,
            );
        }
        Ok(())
    }

    /// Solves the linear system for the present position block.
    fn solve(&mut self) -> Result<Option<GmresReport>, String> {
        let system = &self.system;
        let n = system.numbering.x.len();
        self.rhs.fill(0.0);
        for (i, force) in self.force.iter().enumerate() {
            for axis in 0..3 {
                self.rhs[axis * n + i] = -force[axis] / system.units().force;
            }
        }
        match self.linear {
            LinearSolver::Gmres { tolerance } => {
                let kind = match std::env::var("SCHUR").as_deref() {
                    Ok("full") => SchurKind::Full,
                    Ok("lu") => SchurKind::ScalarLu,
                    _ => SchurKind::Scalar,
                };
                let t0 = std::time::Instant::now();
                self.precond
                    .factorize(system, &self.position_block, kind)
                    .map_err(|e| e.to_string())?;
                let t1 = t0.elapsed();
                let precond = &mut self.precond;
                let position = &self.position_block;
                self.solution.fill(0.0);
                let report = gmres(
                    &mut |v, out| system.multiply(position, v, out),
                    &mut |v, out| precond.apply(system, v, out),
                    &self.rhs,
                    &mut self.solution,
                    &GmresOptions {
                        tolerance,
                        restart: 200,
                        ..GmresOptions::default()
                    },
                );
                if std::env::var("TIMES").is_ok() {
                    println!("factor {:?} gmres {:?} {:?}", t1, t0.elapsed() - t1, report);
                }
                Ok(Some(report))
            }
            LinearSolver::Lu => {
                let matrix = system.to_csc(&self.position_block);
                let mut lu = SparseLu::new(&matrix).map_err(|e| e.to_string())?;
                self.solution.copy_from_slice(&self.rhs);
                lu.solve_in_place(&mut self.solution, 1);
                let mut residual = vec![0.0; self.rhs.len()];
                system.multiply(&self.position_block, &self.solution, &mut residual);
                for (r, b) in residual.iter_mut().zip(&self.rhs) {
                    *r = b - *r;
                }
                lu.solve_in_place(&mut residual, 1);
                for (x, r) in self.solution.iter_mut().zip(&residual) {
                    *x += r;
                }
                Ok(None)
            }
        }
    }

    /// `trial = positions + δx`; returns the largest displacement.
    fn displace(&mut self) -> f64 {
        let n = self.system.numbering.x.len();
        let r = self.system.units().length;
        let mut longest = 0.0f64;
        for (i, &v) in self.system.numbering.x.vertex.iter().enumerate() {
            let s = &self.solution;
            let d = DVec3::new(s[i], s[n + i], s[2 * n + i]) * r;
            self.trial[v as usize] = self.positions[v as usize] + d;
            // f64::max would hide a NaN
            let length = d.length();
            longest = if length <= longest { longest } else { length };
        }
        longest
    }

    fn accept(&mut self, sum: EnergySum) {
        let r = self.system.units().length;
        let (n, m) = (self.system.numbering.x.len(), self.system.numbering.h.len());
        for (j, &v) in self.system.numbering.h.vertex.iter().enumerate() {
            let get = |begin: usize| {
                let s = &self.solution[begin + j..];
                DVec3::new(s[0], s[m], s[2 * m])
            };
            self.h[v as usize] += get(3 * n) / r;
            self.k[v as usize] += get(3 * n + 3 * m) / (r * r);
        }
        self.current = sum;
        std::mem::swap(&mut self.positions, &mut self.trial);
        std::mem::swap(&mut self.gradient, &mut self.trial_gradient);
        self.assembled = false;
    }
}

/// `2Hn` and `2Kn` of the starting surface at ring 2, by the L2 projection with lumped mass over all
/// faces around; zero elsewhere.
fn fixed_curvatures(problem: &FlowProblem, tables: &mut TableCache) -> (Vec<DVec3>, Vec<DVec3>) {
    let (topology, ring) = (problem.topology(), problem.ring());
    let faces: Vec<FaceId> = (0..topology.face_count())
        .map(FaceId::from)
        .filter(|&f| topology.face_vertices(f).iter().any(|v| ring[v.index()] == 2))
        .collect();
    let around = elements(topology, &faces, Rule::Twelve, tables);
    let count = problem.positions().len();
    let (mut h, mut k) = (vec![DVec3::ZERO; count], vec![DVec3::ZERO; count]);
    let mut area = vec![0.0; count];
    let mut x = Vec::new();
    for e in 0..around.len() {
        let vertices = around.vertices_of(e);
        x.clear();
        x.extend(vertices.iter().map(|&v| problem.positions()[v as usize]));
        let moments = kernel::curvature_moments(around.table(e), &x);
        for (&v, (a, mh, mk)) in vertices.iter().zip(moments) {
            if ring[v as usize] == 2 {
                area[v as usize] += a;
                h[v as usize] += mh;
                k[v as usize] += mk;
            }
        }
    }
    for v in 0..count {
        if area[v] > 0.0 {
            h[v] /= area[v];
            k[v] /= area[v];
        }
    }
    (h, k)
}

#[cfg(test)]
mod debug {
    use super::*;
    #[test]
    fn dbg() {
        let (pts, faces) = {
            let data = include_str!("../../../tests/data/icosphere3.obj");
            let (mut points, mut faces) = (Vec::new(), Vec::new());
            for line in data.lines() {
                let mut words = line.split_whitespace();
                match words.next() {
                    Some("v") => { let x: Vec<f64> = words.map(|w| w.parse().unwrap()).collect(); points.push(DVec3::new(x[0], x[1], x[2])); }
                    Some("f") => { let f: Vec<u32> = words.map(|w| w.split('/').next().unwrap().parse::<u32>().unwrap() - 1).collect(); faces.push([f[0], f[1], f[2]]); }
                    _ => {}
                }
            }
            (points, faces)
        };
        let interior: Vec<u32> = (0..pts.len() as u32).filter(|&i| pts[i as usize].z > 0.766).collect();
        let p = FlowProblem::new(&pts, &faces, &interior, 0.64).unwrap();
        let e = Energy::parse("1", &Default::default()).unwrap();
        let mut f = MixedFlow::new(&p, &e, LinearSolver::default(), true).unwrap();
        f.assemble().unwrap();
        f.system.position_block(1e-3, &mut f.position_block);
        f.precond.factorize(&f.system, &f.position_block, SchurKind::Scalar).unwrap();
        let d = f.system.dimension();
        let v: Vec<f64> = (0..d).map(|i| ((i * 7919) % 101) as f64 / 50.0 - 1.0).collect();
        let (mut w, mut z) = (vec![0.0; d], vec![0.0; d]);
        f.precond.apply(&f.system, &v, &mut w);
        f.system.multiply(&f.position_block, &w, &mut z);
        let n = f.system.numbering.x.len();
        let m = f.system.numbering.h.len();
        for r in [0..n, n..2*n, 3*n..3*n+m, 3*n+3*m..d] {
            let err = r.clone().map(|i| (z[i]-v[i]).abs()).fold(0.0, f64::max);
            println!("{r:?} {err:e}");
        }
        // M total, m total
        let ones = vec![1.0; n];
        let mut y = vec![0.0; n];
        f.system.x_pattern.multiply(&f.system.mass, &ones, &mut y);
        println!("mass {}  tau {}", y.iter().sum::<f64>(), f.system.units.force);
        f.system.x_pattern.multiply(&f.system.stiffness, &ones, &mut y);
        println!("stiff rows {:?}", &y[..6]);
        println!("{:?}", f.system.lumped.iter().sum::<f64>());
        let max_b = f.system.coupling.values().iter().map(|c| c.b.to_cols_array().iter().fold(0.0f64, |a, b| a.max(b.abs()))).fold(0.0, f64::max);
        println!("b {max_b:e}");
    }
}

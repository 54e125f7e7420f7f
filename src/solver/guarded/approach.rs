//! From a surface near the points it is to pass to one that passes them.

use super::GuardedFlow;
use crate::mesh::{DVec3, VertexId};
use crate::solver::fold_guard::FoldState;

/// Part of its way that a held point goes at once, at most.
const STRIDE: f64 = 0.34;
/// Shortest part; a point that can go no further without a fold waits.
const SHORTEST: f64 = 1e-3;
/// Factors on the part after a fold and after a free step.
const SHRINK: f64 = 0.4;
const GROW: f64 = 1.6;
/// Rounds at most, and steps of descent after each.
const ROUNDS: usize = 60;
const DESCENTS: usize = 2;
/// Trial points of one round.
const TRIALS: usize = 40;

impl GuardedFlow {
    /// Leads the held points from where the surface passes now to `goals`, each as far at once as
    /// nothing folds, the surface following as the metric spreads the move and relaxing between.
    /// Points that cannot arrive without a fold are set there at the end. Returns how many.
    pub fn approach(&mut self, goals: &[DVec3], tau: f64) -> usize {
        let Some(held) = &self.held else { return 0 };
        let start = held.targets().to_vec();
        let count = start.len();
        let mut reached = vec![0.0f64; count];
        let mut stride = vec![STRIDE; count];
        for _ in 0..ROUNDS {
            if reached.iter().all(|&r| r >= 1.0) {
                return 0;
            }
            if self.age.is_none() && self.factorize(tau).is_err() {
                break;
            }
            self.advance(&start, goals, &mut reached, &mut stride);
            for _ in 0..DESCENTS {
                if !self.attempt(tau).accepted {
                    break;
                }
            }
            self.age = None;
        }
        let late = reached.iter().filter(|&&r| r < 1.0).count();
        if late > 0 {
            self.hold_at(goals.to_vec());
        }
        late
    }

    /// One move of the held points; those at a fold go less far, or wait.
    fn advance(
        &mut self,
        start: &[DVec3],
        goals: &[DVec3],
        reached: &mut [f64],
        stride: &mut [f64],
    ) -> bool {
        let mut went: Vec<f64> = reached
            .iter()
            .zip(stride.iter())
            .map(|(&r, &s)| s.min(1.0 - r))
            .collect();
        let mut marked = vec![false; self.positions.len()];
        let mut slowed = vec![false; went.len()];
        for _ in 0..TRIALS {
            let Some(held) = &mut self.held else {
                return false;
            };
            let shifts: Vec<DVec3> = went
                .iter()
                .zip(start.iter().zip(goals))
                .map(|(&w, (a, b))| w * (*b - *a))
                .collect();
            let n = self.gradient.len();
            let mut step = vec![0.0; 3 * n];
            held.pull(&shifts, &mut step);
            self.cholesky.solve_in_place(&mut step, 3);
            let mut positions = self.positions.clone();
            for (i, &v) in self.assembler.unknowns().vertex.iter().enumerate() {
                positions[v as usize] += DVec3::new(step[i], step[n + i], step[2 * n + i]);
            }
            let now = held.targets().to_vec();
            let targets = (0..now.len())
                .map(|i| {
                    if reached[i] + went[i] >= 1.0 {
                        goals[i]
                    } else {
                        now[i] + shifts[i]
                    }
                })
                .collect();
            held.retarget(targets);
            held.settle(&mut positions);
            let folds = FoldState::new(&self.topology, &self.watched, &positions);
            marked.fill(false);
            let any = self
                .folds
                .mark_folds(&folds, &self.topology, &self.watched, &mut marked);
            if !any {
                self.positions = positions;
                self.folds = folds;
                self.refresh();
                for i in 0..went.len() {
                    reached[i] += went[i];
                    if !slowed[i] {
                        stride[i] = (GROW * stride[i]).min(STRIDE);
                    }
                }
                return true;
            }
            held.retarget(now);
            let unknowns = held.unknowns().to_vec();
            let mut any = false;
            for (i, &u) in unknowns.iter().enumerate() {
                let v = self.assembler.unknowns().vertex[u as usize];
                let near = marked[v as usize]
                    || self
                        .topology
                        .neighbours(VertexId(v))
                        .any(|w| marked[w.index()]);
                if near && went[i] > 0.0 {
                    any = true;
                    slowed[i] = true;
                    stride[i] = (SHRINK * stride[i]).max(SHORTEST);
                    went[i] *= SHRINK;
                    if went[i] < SHORTEST {
                        went[i] = 0.0;
                    }
                }
            }
            if !any {
                return false;
            }
        }
        false
    }

    /// Holds the points elsewhere at once.
    fn hold_at(&mut self, targets: Vec<DVec3>) {
        if let Some(held) = &mut self.held {
            held.retarget(targets);
            held.settle(&mut self.positions);
        }
        self.folds = FoldState::new(&self.topology, &self.watched, &self.positions);
        self.refresh();
    }

    /// Energy and gradient at the present positions.
    fn refresh(&mut self) {
        self.current = self
            .assembler
            .gradient(&self.positions, &self.energy, &mut self.gradient);
        if let Some(held) = &self.held {
            held.pull_back(self.assembler.unknowns(), &mut self.gradient);
        }
        self.memory.clear();
    }
}

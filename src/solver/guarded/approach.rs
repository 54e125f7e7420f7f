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

/// How far the held points are on their way.
struct Way<'a> {
    start: Vec<DVec3>,
    goals: &'a [DVec3],
    /// Part of the way behind each.
    reached: Vec<f64>,
    /// Part that each may go at once.
    stride: Vec<f64>,
}

impl Way<'_> {
    /// Points that have not arrived.
    fn late(&self) -> usize {
        self.reached.iter().filter(|&&r| r < 1.0).count()
    }

    /// The part each point goes next.
    fn next(&self) -> Vec<f64> {
        let parts = self.reached.iter().zip(&self.stride);
        parts.map(|(&r, &s)| s.min(1.0 - r)).collect()
    }

    /// Where the points are after going these parts.
    fn after(&self, parts: &[f64]) -> Vec<DVec3> {
        (0..parts.len())
            .map(|i| match self.reached[i] + parts[i] {
                part if part >= 1.0 => self.goals[i],
                part => self.start[i].lerp(self.goals[i], part),
            })
            .collect()
    }
}

impl GuardedFlow {
    /// Leads the held points from where the surface passes now to `goals`, each as far at once as
    /// nothing folds, the surface following as the metric spreads the move and relaxing between.
    /// Points that cannot arrive without a fold are set there at the end. Returns how many.
    pub fn approach(&mut self, goals: &[DVec3], tau: f64) -> usize {
        let Some(held) = &self.constraints else {
            return 0;
        };
        let mut way = Way {
            start: held.targets().to_vec(),
            goals,
            reached: vec![0.0; goals.len()],
            stride: vec![STRIDE; goals.len()],
        };
        for _ in 0..ROUNDS {
            if way.late() == 0 || self.factorize(tau).is_err() {
                break;
            }
            self.advance(&mut way);
            for _ in 0..DESCENTS {
                if !self.attempt(tau).accepted {
                    break;
                }
            }
        }
        let late = way.late();
        if late > 0 {
            self.hold_at(goals.to_vec());
        }
        late
    }

    /// One move of the held points; those at a fold go less far, or wait.
    fn advance(&mut self, way: &mut Way<'_>) {
        let mut parts = way.next();
        let whole = parts.clone();
        let mut marked = vec![false; self.positions.len()];
        for _ in 0..TRIALS {
            let Some(positions) = self.led(&way.after(&parts)) else {
                return;
            };
            let folds = FoldState::new(&self.topology, &self.watched, &positions);
            marked.fill(false);
            let folded = self
                .folds
                .mark_folds(&folds, &self.topology, &self.watched, &mut marked);
            if !folded {
                if let Some(held) = &mut self.constraints {
                    held.retarget(way.after(&parts));
                }
                self.positions = positions;
                self.folds = folds;
                self.refresh();
                for i in 0..parts.len() {
                    way.reached[i] += parts[i];
                    way.stride[i] = if parts[i] < whole[i] {
                        (SHRINK * way.stride[i]).max(SHORTEST)
                    } else {
                        (GROW * way.stride[i]).min(STRIDE)
                    };
                }
                return;
            }
            if !self.slow_down(&marked, &mut parts) {
                return;
            }
        }
    }

    /// The surface led to `targets`, which the metric spreads, and passing them.
    fn led(&mut self, targets: &[DVec3]) -> Option<Vec<DVec3>> {
        let held = self.constraints.as_ref()?;
        let shifts: Vec<DVec3> = targets
            .iter()
            .zip(held.targets())
            .map(|(to, from)| *to - *from)
            .collect();
        let n = self.gradient.len();
        let mut step = vec![0.0; 3 * n];
        held.pull(&shifts, &mut step);
        self.cholesky.solve_in_place(&mut step, 3);
        let mut positions = self.positions.clone();
        for (i, &v) in self.assembler.unknowns().vertex.iter().enumerate() {
            positions[v as usize] += DVec3::new(step[i], step[n + i], step[2 * n + i]);
        }
        held.settle_at(targets, &mut positions);
        Some(positions)
    }

    /// Shortens the parts of the points next to marked vertices; whether there were any that went.
    fn slow_down(&self, marked: &[bool], parts: &mut [f64]) -> bool {
        let Some(held) = &self.constraints else {
            return false;
        };
        let mut any = false;
        for (&u, part) in held.unknowns().iter().zip(parts) {
            let v = self.assembler.unknowns().vertex[u as usize];
            let mut around = self.topology.neighbours(VertexId(v));
            if *part > 0.0 && (marked[v as usize] || around.any(|w| marked[w.index()])) {
                any = true;
                *part *= SHRINK;
                if *part < SHORTEST {
                    *part = 0.0;
                }
            }
        }
        any
    }

    /// Holds the points elsewhere at once.
    fn hold_at(&mut self, targets: Vec<DVec3>) {
        if let Some(held) = &mut self.constraints {
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
        if let Some(held) = &self.constraints {
            held.pull_back(self.assembler.unknowns(), &mut self.gradient);
        }
        self.memory.clear();
    }
}

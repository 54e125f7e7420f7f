//! Noise on a start surface, which shows that a flow smooths it (Fig. 2(b) of the paper).

use crate::mesh::{DVec3, VertexId};
use crate::random::SplitMix;
use crate::solver::FlowProblem;

/// The problem with every interior vertex moved along its normal by a pseudo-random distance of at
/// most `amplitude` mean edge lengths. Equal problems give equal results.
pub(super) fn roughened(problem: FlowProblem, amplitude: f64) -> FlowProblem {
    if amplitude == 0.0 {
        return problem;
    }
    let (topology, start) = (problem.topology(), problem.positions());
    let (mut sum, mut count) = (0.0, 0.0);
    for &v in problem.interior() {
        for w in topology.neighbours(VertexId(v)) {
            sum += start[v as usize].distance(start[w.index()]);
            count += 1.0;
        }
    }
    let reach = amplitude * sum / count;
    let mut random = SplitMix::new(problem.interior().len() as u64);
    let mut positions = start.to_vec();
    for &v in problem.interior() {
        let normal: DVec3 = topology
            .outgoing(VertexId(v))
            .map(|h| {
                topology
                    .face_vertices(topology.face(h))
                    .map(|c| start[c.index()])
            })
            .map(|[a, b, c]| (b - a).cross(c - a))
            .sum();
        positions[v as usize] += random.range(-reach, reach) * normal.normalize_or_zero();
    }
    problem.with_positions(&positions)
}

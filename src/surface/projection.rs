//! L2 projection to continuous piecewise linear functions, with lumped mass.

use crate::subdivision::{Elements, Rule};

/// Sums for the projection. A function's value at a vertex is the average of its samples around it,
/// weighted with the vertex's hat function.
///
/// `sample` returns the weight of an element's quadrature point (its area, up to a common factor)
/// and the value there. It returns `None` to skip the point. `add` receives for each corner the
/// vertex, the weight times the hat function, and the value, element by element and point by point.
pub fn project_to_vertices<T>(
    elements: &Elements,
    rule: Rule,
    sample: impl Fn(usize, usize) -> Option<(f64, T)>,
    mut add: impl FnMut(u32, f64, &T),
) {
    for e in 0..elements.len() {
        for (q, &[v, w]) in rule.points().iter().enumerate() {
            let Some((weight, value)) = sample(e, q) else {
                continue;
            };
            let corners = &elements.vertices_of(e)[..3];
            for (&corner, hat) in corners.iter().zip([1.0 - v - w, v, w]) {
                add(corner, hat * weight, &value);
            }
        }
    }
}

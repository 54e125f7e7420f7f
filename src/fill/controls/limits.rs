//! Limits of the loops that are filled without being named.

use crate::mesh::BoundaryLoop;
use crate::options::options;

options! {
    /// Limits of the loops that are filled without being named.
    pub struct LoopLimits {
        /// Leave loops with more edges open, unless they are named.
        max_edges("N"): Option<usize> = None,
        /// Leave loops with a longer perimeter open, unless they are named.
        max_perimeter("LENGTH"): Option<f64> = None,
        /// Leave loops with a larger diameter open, unless they are named.
        max_diameter("LENGTH"): Option<f64> = None,
    }
}

impl LoopLimits {
    /// Checks the lengths.
    ///
    /// # Errors
    /// One is not positive.
    pub fn check(&self) -> Result<(), String> {
        let lengths = [
            ("max-perimeter", self.max_perimeter),
            ("max-diameter", self.max_diameter),
        ];
        let is_wrong =
            |(_, most): &(&str, Option<f64>)| most.is_some_and(|most| most.is_nan() || most <= 0.0);
        match lengths.into_iter().find(is_wrong) {
            Some((name, _)) => Err(format!("{name} must be a positive length")),
            None => Ok(()),
        }
    }

    /// Why a loop is left open; `None` if it is within all limits.
    pub fn exceeded(&self, one: &BoundaryLoop) -> Option<String> {
        let edges = self.max_edges.filter(|&most| one.edges() > most);
        if let Some(most) = edges {
            return Some(format!("it has more than {most} edges"));
        }
        let lengths = [
            ("perimeter", one.perimeter, self.max_perimeter),
            ("diameter", one.diameter, self.max_diameter),
        ];
        lengths.into_iter().find_map(|(name, length, most)| {
            let most = most.filter(|&most| length > most)?;
            Some(format!("its {name} is {length:.5e}, more than {most}"))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{Mesh, boundary_loops};
    use crate::shapes;

    #[test]
    fn lengths_that_are_not_positive_are_refused() {
        for (length, is_valid) in [
            (1.0, true),
            (f64::INFINITY, true),
            (0.0, false),
            (-1.0, false),
            (f64::NAN, false),
        ] {
            let [mut perimeter, mut diameter] = [LoopLimits::default(), LoopLimits::default()];
            perimeter.max_perimeter = Some(length);
            diameter.max_diameter = Some(length);
            assert_eq!(perimeter.check().is_ok(), is_valid, "{length}");
            assert_eq!(diameter.check().is_ok(), is_valid, "{length}");
        }
        assert_eq!(LoopLimits::default().check(), Ok(()));
    }

    #[test]
    fn each_limit_leaves_larger_loops_open() {
        let (positions, triangles) = shapes::cut_where(&shapes::sphere(300, 1), |p| p.z > 0.6);
        let one =
            boundary_loops(&Mesh::from_triangles(positions, &triangles).expect("a cup")).remove(0);
        let within = LoopLimits {
            max_edges: Some(one.edges()),
            max_perimeter: Some(one.perimeter),
            max_diameter: Some(one.diameter),
        };
        assert_eq!(within.exceeded(&one), None);
        let none = LoopLimits::default();
        for (limits, word) in [
            (
                LoopLimits {
                    max_edges: Some(one.edges() - 1),
                    ..none.clone()
                },
                "edges",
            ),
            (
                LoopLimits {
                    max_perimeter: Some(0.99 * one.perimeter),
                    ..none.clone()
                },
                "perimeter",
            ),
            (
                LoopLimits {
                    max_diameter: Some(0.99 * one.diameter),
                    ..none.clone()
                },
                "diameter",
            ),
        ] {
            let reason = limits.exceeded(&one).expect("a reason");
            assert!(reason.contains(word), "{reason}");
        }
    }
}

//! Vectors as the right-hand sides of a linear system: all x, then all y, then all z.

use glam::DVec3;

/// The components one after the other.
pub fn flat(vectors: impl ExactSizeIterator<Item = DVec3>) -> Vec<f64> {
    let n = vectors.len();
    let mut out = vec![0.0; 3 * n];
    for (i, v) in vectors.enumerate() {
        (out[i], out[n + i], out[2 * n + i]) = (v.x, v.y, v.z);
    }
    out
}

/// The vector `i` of [`flat`] components.
pub fn vector(components: &[f64], i: usize) -> DVec3 {
    let n = components.len() / 3;
    DVec3::new(components[i], components[n + i], components[2 * n + i])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn vectors_return_from_their_components() {
        let vectors = [DVec3::X, DVec3::new(1.0, 2.0, 3.0)];
        let components = flat(vectors.iter().copied());
        assert_eq!(components, [1.0, 1.0, 0.0, 2.0, 0.0, 3.0]);
        assert_eq!([0, 1].map(|i| vector(&components, i)), vectors);
    }
}

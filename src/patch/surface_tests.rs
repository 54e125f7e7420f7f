//! Tests that edits keep the links of a patch valid.

use super::*;

impl Surface {
    /// Twins are mutual and opposite; `out` and `valence` agree with the triangles.
    fn check(&self) {
        let mut valence = vec![0; self.points.len()];
        for h in (0..self.corner.len() as u32).filter(|&h| !self.is_dead(h)) {
            let (v, g) = (self.from(h), self.twin(h));
            valence[v as usize] += 1;
            if g == NONE {
                assert_eq!(self.to(h), (v + 1) % self.rim as u32, "rim edge");
                assert_eq!(self.out[v as usize], h, "rim first");
                valence[self.to(h) as usize] += 1;
            } else {
                assert_eq!(self.twin(g), h);
                assert_eq!((self.from(g), self.to(g)), (self.to(h), v));
            }
        }
        for v in 0..self.points.len() {
            if self.out[v] == NONE {
                assert_eq!(valence[v], 0);
                continue;
            }
            assert_eq!(self.from(self.out[v]), v as u32);
            assert_eq!(self.valence[v], valence[v]);
            let mut reached = 0;
            self.for_neighbours(v as u32, |_| reached += 1);
            assert_eq!(reached, valence[v], "fan of {v}");
        }
    }
}

#[test]
fn every_edit_keeps_the_links() {
    let n = 40u32;
    let points: Vec<_> = (0..n)
        .map(|i| f64::from(i) * std::f64::consts::TAU / f64::from(n))
        .map(|t| DVec3::new(t.cos(), t.sin(), 0.0))
        .collect();
    let fan: Vec<_> = (1..n - 1).map(|i| [0, i, i + 1]).collect();
    let mut s = Surface::new(points, vec![0.1; n as usize], n as usize, &fan);
    s.check();
    // a fixed stream of numbers picks the edits
    let mut state = 1u32;
    let mut pick = |bound: usize| {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) % bound as u32
    };
    let (mut flips, mut collapses) = (0, 0);
    for round in 0..4000 {
        let h = pick(s.corner.len());
        if s.is_dead(h) || s.twin(h) == NONE {
            continue;
        }
        let (a, b) = (s.from(h), s.to(h));
        match pick(3) {
            0 if s.points.len() < 800 => {
                s.split(h, s.point(a).midpoint(s.point(b)));
            }
            1 if s.may_collapse(h) => {
                s.collapse(h, s.point(b));
                collapses += 1;
            }
            _ => {
                let (c, d) = (s.apex(h), s.apex(s.twin(h)));
                let spare = |v: u32| s.valence[v as usize] > if s.is_rim(v) { 2 } else { 3 };
                if spare(a) && spare(b) && !s.joined(c, d) {
                    s.flip(h);
                    flips += 1;
                }
            }
        }
        if round % 50 == 0 {
            s.check();
        }
    }
    s.check();
    assert!(flips > 100 && collapses > 100, "{flips} {collapses}");
}

#[test]
fn reordering_changes_numbers_only() {
    let n = 5000u32;
    let points: Vec<_> = (0..n)
        .map(|i| f64::from(i) * std::f64::consts::TAU / f64::from(n))
        .map(|t| DVec3::new(t.cos(), t.sin(), 0.0))
        .collect();
    let fan: Vec<_> = (1..n - 1).map(|i| [0, i, i + 1]).collect();
    let mut s = Surface::new(points, vec![0.1; n as usize], n as usize, &fan);
    for h in (1..3000).step_by(3).filter(|&h| h % 7 == 0) {
        if s.twin(h) != NONE {
            s.split(h, s.point(s.from(h)).midpoint(s.point(s.to(h))));
        }
    }
    let sorted = |s: &Surface| {
        let corner = |h: &u32| s.point(*h).to_array().map(f64::to_bits);
        let mut all: Vec<_> = s
            .corner
            .chunks_exact(3)
            .map(|t| [0, 1, 2].map(|k| corner(&t[k])))
            .collect();
        for t in &mut all {
            let least = (0..3).min_by_key(|&k| t[k]).expect("three corners");
            t.rotate_left(least);
        }
        all.sort_unstable();
        all
    };
    let before = sorted(&s);
    s.reorder();
    s.check();
    assert_eq!(before, sorted(&s));
}

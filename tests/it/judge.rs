//! Tests of the judge: correct results pass, and every kind of defect is found.

use crate::common::judge::{Keep, Verdict, judge, loops_of};
use crate::common::raw::RawMesh;
use crate::common::truth::Truth;
use meniscus::mesh::DVec3;
use meniscus::shapes::{Hole, HoleShape, cut_holes, sphere};

/// A sphere with two holes, and the sphere filled with the removed parts.
fn cut_and_whole() -> (RawMesh, RawMesh) {
    let whole = sphere(2000, 3);
    let hole = |centre: DVec3, radius: f64| Hole {
        centre,
        shape: HoleShape::Ragged { radius },
        turn: 0.0,
        seed: 1,
    };
    let cut = cut_holes(&whole, &[hole(DVec3::Z, 0.5), hole(DVec3::X, 0.3)]);
    // original vertices first: the others are moved behind them
    let bits = |p: &DVec3| p.to_array().map(f64::to_bits);
    let mut positions = cut.0.clone();
    let known: std::collections::HashMap<_, u32> = cut.0.iter().map(bits).zip(0..).collect();
    let new_index: Vec<u32> = whole
        .0
        .iter()
        .map(|p| {
            known.get(&bits(p)).copied().unwrap_or_else(|| {
                positions.push(*p);
                positions.len() as u32 - 1
            })
        })
        .collect();
    let faces: Vec<[u32; 3]> = whole
        .1
        .iter()
        .map(|t| t.map(|v| new_index[v as usize]))
        .collect();
    (
        RawMesh::from_triangles(&cut.0, &cut.1),
        RawMesh::from_triangles(&positions, &faces),
    )
}

fn verdict(input: &RawMesh, output: &RawMesh, keep: Keep) -> Verdict {
    let loops = loops_of(input).expect("manifold");
    let truth = Truth::Sphere {
        centre: DVec3::ZERO,
        radius: 1.0,
    };
    judge(input, output, keep, &loops, Some(&truth))
}

#[test]
fn true_filling_is_accepted() {
    let (input, output) = cut_and_whole();
    for keep in [Keep::Everything, Keep::Positions] {
        let v = verdict(&input, &output, keep);
        assert_eq!(v.failures, [""; 0]);
        assert_eq!(v.loops_left, 0);
        assert_eq!(
            v.new_vertices,
            output.positions.len() - input.positions.len()
        );
        assert_eq!(v.new_faces, output.faces.len() - input.faces.len());
        assert_eq!(v.holes.len(), 2);
        assert!(v.rms < 1e-15 && v.max < 1e-15);
    }
}

#[test]
fn error_is_in_radii_of_the_own_hole() {
    let (input, mut output) = cut_and_whole();
    let loops = loops_of(&input).expect("manifold");
    let n = input.positions.len();
    // the first hole (at z) is off by 1 % of its radius, the second by 2 %
    let (z, x) = if loops[0].radius > loops[1].radius {
        (&loops[0], &loops[1])
    } else {
        (&loops[1], &loops[0])
    };
    for p in &mut output.positions[n..] {
        let at_z = p.z > p.x;
        let off = if at_z {
            0.01 * z.radius
        } else {
            0.02 * x.radius
        };
        *p *= 1.0 + off;
    }
    let v = verdict(&input, &output, Keep::Everything);
    assert_eq!(v.failures, [""; 0]);
    assert!((v.max - 0.02).abs() < 1e-12);
    let count_z = output.positions[n..].iter().filter(|p| p.z > p.x).count() as f64;
    let count = v.new_vertices as f64;
    let rms = ((count_z * 1e-4 + (count - count_z) * 4e-4) / count).sqrt();
    assert!((v.rms - rms).abs() < 1e-12);
}

#[test]
fn everything_wrong_is_found() {
    let (input, good) = cut_and_whole();
    let n = input.positions.len();
    let says = |change: &dyn Fn(&mut RawMesh), what: &str| {
        let mut output = good.clone();
        change(&mut output);
        let v = verdict(&input, &output, Keep::Everything);
        let all = v.failures.join("; ");
        assert!(all.contains(what), "expected {what:?} in {all:?}");
    };
    let nudge = |x: f64| f64::from_bits(x.to_bits() + 1);
    says(&|m| m.positions[7].x = nudge(m.positions[7].x), "vertex 7");
    says(&|m| m.positions[n].y = f64::NAN, "not finite");
    says(&|m| m.faces[0].swap(0, 1), "same direction");
    says(&|m| m.faces[0].swap(0, 1), "1 original faces lost");
    says(&|m| m.positions[n] = -m.positions[n], "self-intersections");
    says(&|m| m.faces.clear(), "no faces");
    let fold = |m: &mut RawMesh| {
        // push a new vertex over the far edge of one of its faces, a little above the surface
        let face = m.faces.iter().find(|f| f.contains(&(n as u32)));
        let face = face.expect("a face of the new vertex").clone();
        let others: Vec<DVec3> = face
            .iter()
            .filter(|&&v| v as usize != n)
            .map(|&v| m.positions[v as usize])
            .collect();
        let middle = (others[0] + others[1]) / 2.0;
        m.positions[n] = 1.001 * m.positions[n].lerp(middle, 1.4);
    };
    says(&fold, "folded");

    let mut open = good.clone();
    open.faces.pop();
    assert_eq!(verdict(&input, &open, Keep::Positions).loops_left, 1);
}

#[test]
fn repair_may_reorder_but_not_lose() {
    let (input, good) = cut_and_whole();
    let mut turned = good.clone();
    turned.positions.reverse();
    let last = good.positions.len() as u32 - 1;
    for v in turned.faces.iter_mut().flatten() {
        *v = last - *v;
    }
    let v = verdict(&input, &turned, Keep::Positions);
    assert!(!v.failures.iter().any(|f| f.contains("lost")));
    turned.positions[last as usize].x += 1e-9;
    let v = verdict(&input, &turned, Keep::Positions);
    assert!(v.failures.iter().any(|f| f.contains("1 vertices lost")));
}

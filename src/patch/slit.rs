//! Rims with edges of no length, and rims without area.

use super::data::{Patch, Rim};
use crate::mesh::sides;

/// A patch without new vertices over a rim along a line: its triangles, which have no area, join the
/// two ways from one end of the line to the other. `None` if an edge of the mesh joins two rim
/// vertices where the patch would have one.
pub(super) fn stitch(rim: &Rim) -> Option<Patch> {
    let n = rim.points.len();
    let farthest = |from: usize| {
        let distance = |&i: &usize| rim.points[i].distance_squared(rim.points[from]);
        let longer = |i: usize, j: usize| if distance(&j) > distance(&i) { j } else { i };
        (0..n).fold(from, longer)
    };
    let start = farthest(0);
    let end = match farthest(start) {
        // all at one point
        end if end == start => (start + n / 2) % n,
        end => end,
    };
    let along = |i: usize| rim.points[i].distance_squared(rim.points[start]);
    // the two ways from the start to the end: with the rim and against it
    let (p, q) = ((end + n - start) % n, (start + n - end) % n);
    let (with, against) = (|i: usize| (start + i) % n, |j: usize| (start + n - j) % n);
    let mut triangles = Vec::with_capacity(n - 2);
    let mut push = |t: [usize; 3]| triangles.push(t.map(|v| v as u32));
    if p == 1 {
        (0..q - 1).for_each(|j| push([against(j + 1), against(j), end]));
    } else if q == 1 {
        (0..p - 1).for_each(|i| push([with(i), with(i + 1), end]));
    } else {
        push([start, with(1), against(1)]);
        let (mut i, mut j) = (1, 1);
        while i < p - 1 || j < q - 1 {
            if j == q - 1 || (i < p - 1 && along(with(i + 1)) <= along(against(j + 1))) {
                push([with(i), with(i + 1), against(j)]);
                i += 1;
            } else {
                push([against(j + 1), against(j), with(i)]);
                j += 1;
            }
        }
        push([with(i), end, against(j)]);
    }
    let mut edges = triangles.iter().flat_map(|&t| sides(t));
    if edges.any(|[a, b]| rim.chords().any(|pair| pair == [a.min(b), a.max(b)])) {
        return None;
    }
    Some(Patch {
        rim: n,
        points: rim.points.clone(),
        triangles,
    })
}

/// The rim with one vertex for consecutive vertices at the same place, and for each vertex left its
/// index in `rim`.
pub(super) fn without_zero_edges(rim: &Rim) -> (Rim, Vec<u32>) {
    let n = rim.points.len();
    let (before, after) = (|i: usize| (i + n - 1) % n, |i: usize| (i + 1) % n);
    let starts = (0..n).filter(|&i| rim.points[i] != rim.points[before(i)]);
    let last_of_run = |first: usize| {
        let mut last = first;
        while rim.points[after(last)] == rim.points[first] {
            last = after(last);
        }
        last
    };
    // the first vertex of a run, or its last if the mesh joins the first to the next place already
    let representative = |first: usize| {
        let last = last_of_run(first);
        let next = after(last);
        if last != first && is_forbidden(rim, first, next) {
            last
        } else {
            first
        }
    };
    let mut kept: Vec<usize> = starts.map(representative).collect();
    kept.sort_unstable();
    // the vertex left at the place of each vertex
    let stands = |v: u32| {
        let same = |&i: &usize| rim.points[i] == rim.points[v as usize];
        let at = kept.partition_point(|&i| i <= v as usize);
        let around = [at + kept.len() - 1, at].map(|k| k % kept.len());
        around.into_iter().find(|&k| same(&kept[k])).unwrap_or(0) as u32
    };
    let pairs = rim.forbidden.iter().map(|pair| pair.map(stands));
    let mut forbidden: Vec<[u32; 2]> = pairs
        .map(|[i, j]| [i.min(j), i.max(j)])
        .filter(|[i, j]| i != j)
        .collect();
    forbidden.sort_unstable();
    forbidden.dedup();
    // the face at the edge from the last vertex at a place
    let opposite = |&first: &usize| rim.opposite[last_of_run(first)];
    let reduced = Rim {
        points: kept.iter().map(|&i| rim.points[i]).collect(),
        opposite: kept.iter().map(opposite).collect(),
        forbidden,
    };
    (reduced, kept.into_iter().map(|i| i as u32).collect())
}

/// The patch over `rim` from that over [`without_zero_edges`]: triangles without area join the
/// vertices between two that are left. `None` if the mesh has one of their edges already.
pub(super) fn with_zero_edges(rim: &Rim, patch: &Patch, kept: &[u32]) -> Option<Patch> {
    let n = rim.points.len() as u32;
    let whole = |v: u32| match kept.get(v as usize) {
        Some(&i) => i,
        None => n + (v - kept.len() as u32),
    };
    let mut triangles: Vec<[u32; 3]> = patch.triangles.iter().map(|t| t.map(whole)).collect();
    for (k, &first) in kept.iter().enumerate() {
        let end = kept[(k + 1) % kept.len()];
        let mut chain = vec![first];
        while *chain.last()? != end {
            chain.push((chain.last()? + 1) % n);
        }
        // fans from either end
        let [to_end, to_first] = [end, first].map(|apex| {
            let fan = chain.windows(2).map(move |w| [w[0], w[1], apex]);
            fan.filter(|[a, b, c]| a != c && b != c).collect::<Vec<_>>()
        });
        let is_free = |fan: &Vec<[u32; 3]>| {
            let inner =
                |&[a, b, c]: &[u32; 3]| [[b, c], [c, a]].map(|[a, b]| [a as usize, b as usize]);
            let on_rim =
                |[a, b]: [usize; 2]| (a + 1) % n as usize == b || (b + 1) % n as usize == a;
            let mut edges = fan.iter().flat_map(inner).filter(|&edge| !on_rim(edge));
            !edges.any(|[a, b]| is_forbidden(rim, a, b))
        };
        triangles.extend([to_end, to_first].into_iter().find(is_free)?);
    }
    let new = patch.new_points().iter();
    Some(Patch {
        rim: n as usize,
        points: rim.points.iter().chain(new).copied().collect(),
        triangles,
    })
}

/// Whether an edge of the mesh that is not on the rim joins two rim vertices.
fn is_forbidden(rim: &Rim, i: usize, j: usize) -> bool {
    rim.forbidden.contains(&[i.min(j) as u32, i.max(j) as u32])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{DVec3, Topology};
    use crate::patch::{PatchOptions, fill};

    fn rim(points: Vec<DVec3>) -> Rim {
        Rim {
            opposite: points.iter().map(|&p| p + DVec3::Z).collect(),
            points,
            forbidden: Vec::new(),
        }
    }

    /// A disc whose boundary is the rim, in its direction.
    fn is_disc(patch: &Patch) {
        let topology = Topology::from_triangles(patch.points.len(), &patch.triangles);
        let topology = topology.expect("a manifold");
        let loops = topology.boundary_loops();
        assert_eq!((loops.len(), loops[0].len()), (1, patch.rim));
        // boundary half-edges of the patch run against the rim
        for &h in &loops[0] {
            let (a, b) = (topology.origin(h).0, topology.target(h).0);
            assert_eq!((b + 1) % patch.rim as u32, a);
        }
    }

    #[test]
    fn slits_are_stitched() {
        let at = |x: f64| DVec3::new(1.0, 2.0, 3.0) * x;
        let slits: [&[f64]; 6] = [
            &[0.0, 1.0, 2.0],
            &[0.0, 2.0, 1.0],
            &[0.0, 3.0, 2.0, 1.0],
            &[0.0, 1.0, 2.0, 5.0, 4.0, 3.0, 2.5, 0.5],
            &[1.0, 2.0, 3.0, 2.5, 0.0],
            &[1.0, 1.0, 1.0, 1.0],
        ];
        for slit in slits {
            for turn in 0..slit.len() {
                let mut points: Vec<DVec3> = slit.iter().map(|&x| at(x)).collect();
                points.rotate_left(turn);
                let patch = fill(&rim(points), PatchOptions::default()).expect("stitched");
                assert!(patch.new_points().is_empty());
                assert_eq!(patch.triangles.len(), slit.len() - 2);
                is_disc(&patch);
            }
        }
    }

    #[test]
    fn edges_of_no_length_stay_in_the_rim() {
        let circle = |i: u32| {
            let (sin, cos) = (std::f64::consts::TAU * f64::from(i) / 12.0).sin_cos();
            DVec3::new(cos, sin, 0.0)
        };
        for repeated in [vec![0], vec![11, 11], vec![3, 4, 4, 4]] {
            for turn in [0, 1, 5, 11] {
                let mut order: Vec<u32> = (0..12).chain(repeated.iter().copied()).collect();
                order.sort_unstable();
                order.rotate_left(turn);
                let rim = rim(order.iter().map(|&i| circle(i)).collect());
                let patch = fill(&rim, PatchOptions::default()).expect("filled");
                is_disc(&patch);
                assert_eq!(patch.points[..patch.rim], rim.points);
                assert!(patch.new_points().len() > 4);
            }
        }
    }

    /// The mesh joins both vertices at a place to the next place already, as a triangle without area
    /// does at the pole of a sphere.
    #[test]
    fn edges_of_the_mesh_are_not_repeated() {
        let mut points: Vec<DVec3> = [[0.0, 0.0], [0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]
            .map(|[x, y]| DVec3::new(x, y, 0.0))
            .to_vec();
        let mut slit = rim(points.clone());
        slit.forbidden = vec![[0, 2]];
        let patch = fill(&slit, PatchOptions::default()).expect("filled");
        is_disc(&patch);
        let has = |a: u32, b: u32| {
            patch
                .triangles
                .iter()
                .any(|t| t.contains(&a) && t.contains(&b))
        };
        assert!(!has(0, 2) && has(1, 2));
        points.rotate_left(1);
        let mut slit = rim(points);
        slit.forbidden = vec![[1, 4]];
        is_disc(&fill(&slit, PatchOptions::default()).expect("filled"));
    }
}

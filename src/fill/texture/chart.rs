//! A chart for patches: their triangles in a disc, whose border is the outer rim.

use std::collections::{BTreeMap, BTreeSet};

use super::laplace::Texels;
use super::{Light, RimEdge};
use crate::fill::harmonic::Harmonic;
use crate::mesh::{DVec3, sides};

/// Texels around the disc, so that filters do not reach other charts.
const PADDING: f64 = 4.0;
/// Texels this far from a rim have the colour of the rim. Every sample at the rim lies between these.
const BAND: f64 = 1.5;
/// Minimum number of texels of an edge.
const MIN_TEXELS: f64 = 2.0;
/// Smallest radius of the inner of two loops beside that of the outer one, where possible.
const INNER: f64 = 0.4;
/// Smallest and largest radius of a chart in texels.
const RADII: [f64; 2] = [4.0, 512.0];

/// A chart.
pub struct Chart<'a> {
    /// The place of each vertex in texels, from the upper left corner.
    pub places: BTreeMap<u32, [f64; 2]>,
    /// Width and height in texels.
    pub size: [usize; 2],
    /// Edges with colours, as places.
    rim: Vec<([[f64; 2]; 2], &'a RimEdge)>,
}

impl<'a> Chart<'a> {
    /// The chart of connected triangles, drawn `scale` times as large as the images around it. `colors`
    /// are those along directed edges of their border. `None` if no loop of the border has colours, or
    /// the border is not simple.
    pub fn new(
        triangles: &[[u32; 3]],
        positions: &[DVec3],
        scale: f64,
        colors: impl Fn([u32; 2]) -> Option<&'a RimEdge>,
    ) -> Option<Self> {
        let mut loops = border(triangles)?;
        let of_edges = |one: &[u32]| -> Vec<Option<&'a RimEdge>> {
            let edges = (0..one.len()).map(|i| [one[i], one[(i + 1) % one.len()]]);
            edges.map(&colors).collect()
        };
        let length = |one: &[u32]| -> f64 {
            let edges = (0..one.len()).map(|i| [one[i], one[(i + 1) % one.len()]]);
            let lengths = edges.map(|e| distance(positions, e));
            lengths.sum()
        };
        // the longest loop with colours is outside
        let has_colors = |one: &[u32]| of_edges(one).iter().any(Option::is_some);
        let ranked = loops.iter().enumerate();
        let ranked = ranked.filter(|(_, one)| has_colors(one));
        let outer = ranked.max_by(|a, b| length(a.1).total_cmp(&length(b.1)).then(b.0.cmp(&a.0)));
        let outer = outer?.0;
        loops.swap(0, outer);
        let texels: Vec<Vec<f64>> = loops
            .iter()
            .map(|one| texels_of(one, positions, &of_edges(one)))
            .collect();
        let unit = disc(triangles, positions, &loops, &texels[0]);
        let unit = match &loops[..] {
            [outer, inner] => widened(unit, triangles, outer, inner),
            _ => unit,
        };
        let needed = |(one, texels): (&Vec<u32>, &Vec<f64>)| {
            let places = one.iter().map(|v| unit[v]).collect::<Vec<_>>();
            let sides = (0..places.len()).map(|i| apart(places[i], places[(i + 1) % places.len()]));
            let sum: f64 = sides.sum();
            texels.iter().sum::<f64>() / sum.max(f64::MIN_POSITIVE)
        };
        let with_colors = loops.iter().zip(&texels);
        let with_colors = with_colors.filter(|(one, _)| has_colors(one));
        let radius = scale * with_colors.map(needed).fold(0.0, f64::max);
        let radius = radius.clamp(RADII[0], RADII[1]);
        let corners = loops[0].iter().map(|v| unit[v]);
        let least = |k: usize| corners.clone().map(|p| p[k]).fold(f64::INFINITY, f64::min);
        let most = |k: usize| {
            corners
                .clone()
                .map(|p| p[k])
                .fold(f64::NEG_INFINITY, f64::max)
        };
        let [low, high] = [[least(0), least(1)], [most(0), most(1)]];
        let place = |p: &[f64; 2]| [0, 1].map(|k| PADDING + radius * (p[k] - low[k]));
        let places: BTreeMap<u32, [f64; 2]> = unit.iter().map(|(&v, p)| (v, place(p))).collect();
        let side = |k: usize| (2.0 * PADDING + radius * (high[k] - low[k])).ceil() as usize;
        let mut rim = Vec::new();
        for one in &loops {
            for (i, edge) in of_edges(one).into_iter().enumerate() {
                let ends = [one[i], one[(i + 1) % one.len()]];
                rim.extend(edge.map(|edge| (ends.map(|v| places[&v]), edge)));
            }
        }
        Some(Self {
            size: [side(0), side(1)],
            places,
            rim,
        })
    }

    /// Its texels, row by row from the top.
    pub fn texels(&self) -> Vec<Light> {
        let [width, height] = self.size;
        let mut texels = Texels::new(width, height);
        let mut nearest = vec![f64::INFINITY; width * height];
        for (ends, edge) in &self.rim {
            let range = |k: usize, count: usize| {
                let [a, b] = [ends[0][k], ends[1][k]];
                let first = (a.min(b) - BAND - 0.5).max(0.0) as usize;
                first..((a.max(b) + BAND + 0.5).max(0.0) as usize).min(count)
            };
            for y in range(1, height) {
                for x in range(0, width) {
                    let centre = [x as f64 + 0.5, y as f64 + 0.5];
                    let t = nearest_on(*ends, centre);
                    let foot = [0, 1].map(|k| ends[0][k] + t * (ends[1][k] - ends[0][k]));
                    let (far, at) = (apart(foot, centre), y * width + x);
                    if far <= BAND && far < nearest[at] {
                        nearest[at] = far;
                        texels.known[at] = true;
                        texels.lights[at] = edge.at(t);
                    }
                }
            }
        }
        texels.continue_known();
        texels.lights
    }
}

fn apart(a: [f64; 2], b: [f64; 2]) -> f64 {
    (b[0] - a[0]).hypot(b[1] - a[1])
}

fn distance(positions: &[DVec3], [a, b]: [u32; 2]) -> f64 {
    positions[a as usize].distance(positions[b as usize])
}

/// Where on a segment, in 0..=1, the point nearest to `p` is.
fn nearest_on([a, b]: [[f64; 2]; 2], p: [f64; 2]) -> f64 {
    let side = [b[0] - a[0], b[1] - a[1]];
    let square = side[0] * side[0] + side[1] * side[1];
    let along = (p[0] - a[0]) * side[0] + (p[1] - a[1]) * side[1];
    (along / square.max(f64::MIN_POSITIVE)).clamp(0.0, 1.0)
}

/// The border of triangles as loops of vertices, in the direction of the triangles; `None` if it touches
/// itself.
fn border(triangles: &[[u32; 3]]) -> Option<Vec<Vec<u32>>> {
    let all: BTreeSet<[u32; 2]> = triangles.iter().flat_map(|&t| sides(t)).collect();
    let mut next = BTreeMap::new();
    for &[a, b] in all.iter().filter(|[a, b]| !all.contains(&[*b, *a])) {
        if next.insert(a, b).is_some() {
            return None;
        }
    }
    let mut loops = Vec::new();
    while let Some((first, mut v)) = next.pop_first() {
        let mut one = vec![first];
        while v != first {
            one.push(v);
            v = next.remove(&v)?;
        }
        loops.push(one);
    }
    (!loops.is_empty()).then_some(loops)
}

/// The places with a wider inner loop, if it is narrow and no triangle is turned over: in a long tube the
/// inner loop is exponentially small, and its texture would be coarse.
fn widened(
    places: BTreeMap<u32, [f64; 2]>,
    triangles: &[[u32; 3]],
    outer: &[u32],
    inner: &[u32],
) -> BTreeMap<u32, [f64; 2]> {
    let of = |one: &[u32]| one.iter().map(|v| places[v]).collect::<Vec<_>>();
    let (outer, inner) = (of(outer), of(inner));
    let centre = [0, 1].map(|k| inner.iter().map(|p| p[k]).sum::<f64>() / inner.len() as f64);
    let radius =
        |one: &[[f64; 2]]| one.iter().map(|&p| apart(centre, p)).sum::<f64>() / one.len() as f64;
    let (whole, ratio) = (radius(&outer), radius(&inner) / radius(&outer));
    if ratio >= INNER || ratio <= 0.0 {
        return places;
    }
    let power = INNER.ln() / ratio.ln();
    let wide = |p: &[f64; 2]| {
        let far = (apart(centre, *p) / whole).max(f64::MIN_POSITIVE);
        [0, 1].map(|k| centre[k] + (p[k] - centre[k]) * far.powf(power - 1.0))
    };
    let new: BTreeMap<u32, [f64; 2]> = places.iter().map(|(&v, p)| (v, wide(p))).collect();
    let is_kept = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|v| new[&v]);
        // downwards, triangles seen from outside have a negative area
        (b[0] - a[0]) * (c[1] - a[1]) < (b[1] - a[1]) * (c[0] - a[0])
    };
    if triangles.iter().all(is_kept) {
        new
    } else {
        places
    }
}

/// The length in texels of each edge of a loop. Edges without colours have the density of the others.
fn texels_of(one: &[u32], positions: &[DVec3], edges: &[Option<&RimEdge>]) -> Vec<f64> {
    let length = |i: usize| distance(positions, [one[i], one[(i + 1) % one.len()]]);
    let (mut texels, mut lengths) = (0.0, 0.0);
    for (i, edge) in edges.iter().enumerate() {
        if let Some(edge) = edge.filter(|edge| edge.texels > 0.0) {
            texels += edge.texels;
            lengths += length(i);
        }
    }
    let density = if lengths > 0.0 { texels / lengths } else { 0.0 };
    let of_edge = |(i, edge): (usize, Option<&RimEdge>)| match edge {
        Some(edge) if edge.texels > 0.0 => edge.texels.max(MIN_TEXELS),
        _ => (density * length(i)).max(MIN_TEXELS),
    };
    edges.iter().copied().enumerate().map(of_edge).collect()
}

/// Places of vertices in the unit disc, without overlaps: those of the first loop are on the circle, their
/// distances in proportion to `texels`. Every other vertex is at the mean of its neighbours. (W. T. Tutte,
/// *How to draw a graph*, 1963; other loops are closed by a vertex each.)
fn disc(
    triangles: &[[u32; 3]],
    positions: &[DVec3],
    loops: &[Vec<u32>],
    texels: &[f64],
) -> BTreeMap<u32, [f64; 2]> {
    let outer = &loops[0];
    let mut number: BTreeMap<u32, u32> = (0..).zip(outer).map(|(i, &v)| (v, i)).collect();
    let mut order = outer.clone();
    for &v in triangles.as_flattened() {
        number.entry(v).or_insert_with(|| {
            order.push(v);
            order.len() as u32 - 1
        });
    }
    let mut local: Vec<[u32; 3]> = triangles.iter().map(|t| t.map(|v| number[&v])).collect();
    let mut points: Vec<DVec3> = order.iter().map(|&v| positions[v as usize]).collect();
    for one in &loops[1..] {
        let centre = points.len() as u32;
        let sum: DVec3 = one.iter().map(|&v| positions[v as usize]).sum();
        points.push(sum / one.len() as f64);
        let ends = (0..one.len()).map(|i| [one[(i + 1) % one.len()], one[i]]);
        local.extend(ends.map(|e| [number[&e[0]], number[&e[1]], centre]));
    }
    let whole: f64 = texels.iter().sum();
    let mut passed = 0.0;
    let mut circle = Vec::new();
    for texels in texels {
        let angle = std::f64::consts::TAU * passed / whole;
        // downwards, so that the patch is seen from outside
        circle.push([angle.cos(), -angle.sin()]);
        passed += texels;
    }
    let mut places = circle.clone();
    if points.len() > circle.len() {
        let mut equation = Harmonic::new(local.into_iter(), circle.len()..points.len(), &points);
        let of = |k: usize| circle.iter().map(|p| p[k]).collect::<Vec<f64>>();
        let [x, y] = [0, 1].map(|k| equation.solve(&of(k)));
        places.extend(x.into_iter().zip(y).map(|(x, y)| [x, y]));
    }
    order.into_iter().zip(places).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shapes;

    fn edge() -> RimEdge {
        RimEdge {
            lights: vec![[0.5, 0.25, 0.0, 1.0]; 2],
            texels: 20.0,
        }
    }

    fn area(places: &BTreeMap<u32, [f64; 2]>, t: &[u32; 3]) -> f64 {
        let [a, b, c] = t.map(|v| places[&v]);
        (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
    }

    /// A dome and a long tube lie in the plane without overlaps, inside their padding; the edges of the
    /// longest rim have the texels they need, and those of the other nearly.
    #[test]
    fn charts_do_not_overlap_and_have_the_texels_of_their_rims() {
        let ball = shapes::sphere(900, 5);
        let dome = shapes::cut_where(&ball, |p| p.z < 0.1);
        let tube = shapes::cylinder(1.0, 3.0, 24, 6);
        for ((positions, triangles), rims) in [(dome, 1), (tube, 2)] {
            let edge = edge();
            let chart = Chart::new(&triangles, &positions, 1.0, |_| Some(&edge));
            let chart = chart.expect("a chart");
            assert!(triangles.iter().all(|t| area(&chart.places, t) < 0.0));
            for place in chart.places.values() {
                for k in 0..2 {
                    let inside = PADDING - 1e-9..chart.size[k] as f64 - PADDING + 1e-9;
                    assert!(inside.contains(&place[k]), "{place:?} in {:?}", chart.size);
                }
            }
            let loops = border(&triangles).expect("simple");
            assert_eq!(loops.len(), rims);
            let length: f64 = chart.rim.iter().map(|(e, _)| apart(e[0], e[1])).sum();
            let mean = length / chart.rim.len() as f64;
            // the chart is so large that no rim has less
            assert!(mean > 19.0 && mean < 45.0, "{mean}");
            let [r, g, b, a] = chart.texels()[chart.size[0] * chart.size[1] / 2];
            let off = [r - 0.5, g - 0.25, b, a - 1.0].map(f32::abs);
            assert!(off.iter().all(|&x| x < 1e-3), "{off:?}");
        }
    }

    #[test]
    fn borders_are_loops_and_do_not_touch_themselves() {
        let two = [[0, 1, 2], [2, 1, 3]];
        assert_eq!(border(&two), Some(vec![vec![0, 1, 3, 2]]));
        // two triangles at one vertex
        assert_eq!(border(&[[0, 1, 2], [0, 3, 4]]), None);
        assert!(border(&[[0, 1, 2], [0, 2, 1]]).is_none());
    }
}

//! Counts, areas, volumes and energies.

use serde::Serialize;

use crate::energy::Energy;
use crate::mesh::{DVec3, FaceId, Mesh, Topology, components};
use crate::subdivision::{Elements, Rule, elements};
use crate::surface::{Interpolation, MeanVariation, each_point};

/// The meaning of the vertices of a mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Vertices {
    /// Control points of the limit surface.
    #[default]
    Control,
    /// Points the limit surface passes.
    OnSurface,
}

/// Counts and integrals.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ShapeReport {
    /// Vertices.
    pub vertices: usize,
    /// Triangles.
    pub faces: usize,
    /// Edges.
    pub edges: usize,
    /// Connected components of the triangles.
    pub components: usize,
    /// Boundary loops.
    pub boundary_loops: usize,
    /// Vertices − edges + triangles, isolated vertices left out.
    pub euler: i64,
    /// Sum of the genera of the components, holes thought filled: `c − (χ + b) / 2`.
    pub genus: i64,
    /// Area of the triangles.
    pub mesh_area: f64,
    /// Volume the triangles enclose, positive for outward normals; null for an open mesh.
    pub mesh_volume: Option<f64>,
    /// Area of the limit surface.
    pub area: f64,
    /// Volume the limit surface encloses; null for an open mesh.
    pub volume: Option<f64>,
    /// Energies of the limit surface.
    pub energies: Energies,
}

/// Integrals over the limit surface, 12-point rule.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Energies {
    /// `∫ H² dA`.
    pub willmore: f64,
    /// `∫ K dA`, on a closed surface 2π times its Euler number.
    pub total_curvature: f64,
    /// `∫ K² dA`.
    pub gauss_squared: f64,
    /// `∫ k1² + k2² dA`.
    pub bending: f64,
    /// Of the energy given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub given: Option<f64>,
}

/// Control points of the surface a mesh stands for.
pub fn control_points(mesh: &Mesh, vertices: Vertices) -> Vec<DVec3> {
    let mut control = mesh.positions.clone();
    if vertices == Vertices::OnSurface {
        let used = mesh.topology.vertices();
        let held: Vec<(u32, DVec3)> = used
            .filter(|&v| mesh.topology.has_faces(v))
            .map(|v| (v.0, mesh.position(v)))
            .collect();
        Interpolation::new(&mesh.topology, &held).enforce(&mut control);
    }
    control
}

/// The stencils of all faces.
pub(super) fn all_elements(topology: &Topology, rule: Rule) -> Elements {
    let faces: Vec<FaceId> = topology.faces().collect();
    elements(topology, &faces, rule)
}

/// Counts and integrals of a mesh and the limit surface of the `control` points.
pub fn shape(mesh: &Mesh, control: &[DVec3], energy: Option<&Energy>) -> ShapeReport {
    let topology = &mesh.topology;
    let used = topology.vertices().filter(|&v| topology.has_faces(v));
    let [v, e, f] = [used.count(), topology.edges().len(), topology.face_count()];
    let signed = |n: usize| i64::try_from(n).unwrap_or(i64::MAX);
    let euler = signed(v) - signed(e) + signed(f);
    let boundary_loops = topology.boundary_loops().len();
    let parts = components(topology).count;
    let is_closed = boundary_loops == 0 && f > 0;
    // relative to a vertex, so that nothing is lost far from the origin
    let origin = mesh.positions.first().copied().unwrap_or_default();
    let (mut mesh_area, mut mesh_volume) = (0.0, 0.0);
    for face in topology.faces() {
        let [a, b, c] = mesh.corners(face).map(|p| p - origin);
        mesh_area += 0.5 * (b - a).cross(c - a).length();
        mesh_volume += a.dot(b.cross(c)) / 6.0;
    }
    let integrals = Integrals::over(topology, control, origin, energy);
    ShapeReport {
        vertices: topology.vertex_count(),
        faces: f,
        edges: e,
        components: parts,
        boundary_loops,
        euler,
        // 2 (parts − genus) = V − E + F of the surface with its loops closed
        genus: (2 * signed(parts) - euler - signed(boundary_loops)) / 2,
        mesh_area,
        mesh_volume: is_closed.then_some(mesh_volume),
        area: integrals.area,
        volume: is_closed.then_some(integrals.volume),
        energies: integrals.energies,
    }
}

struct Integrals {
    area: f64,
    volume: f64,
    energies: Energies,
}

impl Integrals {
    fn over(
        topology: &Topology,
        control: &[DVec3],
        origin: DVec3,
        energy: Option<&Energy>,
    ) -> Self {
        let elements = all_elements(topology, Rule::Twelve);
        let (mut area, mut volume) = (0.0, 0.0);
        let mut sums = [0.0; 4];
        let mut given = 0.0;
        for e in 0..elements.len() {
            each_point(&elements, e, control, |x, p| {
                let d_area = Rule::Twelve.weight() * 0.5 * p.sqrt_g;
                if !(d_area > 0.0 && p.mean.is_finite()) {
                    return; // a degenerate point has no curvature and no area
                }
                let (h, k) = (p.mean, p.gauss);
                area += d_area;
                volume += d_area * (x - origin).dot(p.normal) / 3.0;
                let values = [h * h, k, k * k, 4.0 * h * h - 2.0 * k];
                for (sum, value) in sums.iter_mut().zip(values) {
                    *sum += d_area * value;
                }
                if let Some(energy) = energy {
                    given += d_area * energy.jet(h, k).f;
                }
            });
        }
        if let Some(energy) = energy.filter(|energy| energy.gradient() != 0.0) {
            let faces: Vec<FaceId> = topology.faces().collect();
            let mut variation = MeanVariation::new(topology, &faces, |_| false, Rule::Twelve);
            given += energy.gradient() * variation.evaluate(control).0;
        }
        let [willmore, total_curvature, gauss_squared, bending] = sums;
        Self {
            area,
            volume,
            energies: Energies {
                willmore,
                total_curvature,
                gauss_squared,
                bending,
                given: energy.map(|_| given),
            },
        }
    }
}

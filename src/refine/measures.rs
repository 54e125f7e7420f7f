//! Measures of the surfaces of a refinement.

use crate::energy::Energy;
use crate::mesh::{DVec3, FaceId, Mesh, Topology, rms_distance};
use crate::solver::{Assembler, Unknowns};
use crate::subdivision::{Rule, elements};

/// `∫ f dA` over the whole Loop limit surface, 12-point rule.
pub fn surface_energy(topology: &Topology, control: &[DVec3], energy: &Energy) -> f64 {
    let faces: Vec<FaceId> = topology.faces().collect();
    let elements = elements(topology, &faces, Rule::Twelve);
    Assembler::new(&elements, Rule::Twelve, Unknowns::none(control.len()))
        .energy(control, energy)
        .value
}

/// RMS distance of the vertices of triangles from their mean, the unit of length of a refinement.
/// It is 1 if all vertices coincide.
pub fn radius(mesh: &Mesh) -> f64 {
    let topology = &mesh.topology;
    let used: Vec<DVec3> = topology
        .vertices()
        .filter(|&v| topology.has_faces(v))
        .map(|v| mesh.position(v))
        .collect();
    let n = used.len().max(1) as f64;
    let origin = used.first().copied().unwrap_or_default();
    let mean = origin + used.iter().map(|&p| p - origin).sum::<DVec3>() / n;
    let radius = rms_distance(used.iter().copied(), mean);
    if radius > 0.0 { radius } else { 1.0 }
}

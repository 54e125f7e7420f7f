//! The state of a whole fill.

use std::ops::Range;
use std::sync::Arc;

use crate::fill::assemble::Assembly;
use crate::fill::patch_topology::PatchTopology;
use crate::mesh::{DVec3, LoopId, Mesh, Topology};
use crate::runner::TimelineState;
use crate::warning::Warning;

/// The state of one group after an accepted step.
#[derive(Clone, Debug)]
pub struct GroupState {
    /// Accepted steps.
    pub step: usize,
    /// The run's clock after the step.
    pub clock: usize,
    /// Positions of the group's new vertices.
    pub positions: Arc<[DVec3]>,
    /// Energy by the quadrature rule of the steps; NaN if there is no flow.
    pub energy: f64,
    /// Residual of the step; `None` before the first.
    pub residual: Option<f64>,
    /// Its time step; `None` before the first.
    pub tau: Option<f64>,
    /// Smallest angle of a triangle of the patches, in degrees.
    pub worst_angle: f64,
    pub(in crate::fill) patches: Arc<PatchTopology>,
}

/// The state of a whole fill.
#[derive(Clone, Debug)]
pub struct FillState {
    /// The state of every group.
    pub groups: Vec<Arc<GroupState>>,
    pub(super) given: Arc<Mesh>,
    /// The whole filled mesh but for positions; the same `Arc` while no triangulation changes.
    pub(super) assembly: Arc<Assembly>,
}

impl FillState {
    /// Connectivity of the whole filled mesh, the given vertices and faces first. The same `Arc`
    /// while no triangulation changes.
    pub fn topology(&self) -> &Arc<Topology> {
        &self.assembly.topology
    }

    /// Positions of all vertices of the filled mesh.
    pub fn positions(&self) -> Vec<DVec3> {
        self.assembly.positions(&self.given, self.group_positions())
    }

    /// The patch faces, as a range of faces of the filled mesh.
    pub fn patch_faces(&self) -> Range<usize> {
        self.assembly.patch_faces()
    }

    /// The whole filled mesh with the attributes of the given one, the old part first.
    pub fn mesh(&self) -> Mesh {
        self.mesh_with_warnings().0
    }

    /// The whole filled mesh, and warnings about the attributes of patches, by hole.
    pub fn mesh_with_warnings(&self) -> (Mesh, Vec<(LoopId, Warning)>) {
        self.assembly.mesh(&self.given, self.group_positions())
    }

    /// Whether the patches may get texture images of their own, which take time to make.
    pub fn makes_images(&self) -> bool {
        self.assembly.makes_images(&self.given)
    }

    fn group_positions(&self) -> impl Iterator<Item = &[DVec3]> {
        self.groups.iter().map(|group| &group.positions[..])
    }
}

impl TimelineState for FillState {
    fn bytes(&self, before: Option<&Self>) -> usize {
        let groups = self.groups.iter().enumerate().map(|(g, group)| {
            let earlier = before.map(|s| &s.groups[g]);
            if earlier.is_some_and(|e| Arc::ptr_eq(e, group)) {
                return 0;
            }
            let own_patches = earlier.is_none_or(|e| !Arc::ptr_eq(&e.patches, &group.patches));
            let patches = if own_patches {
                group.patches.bytes()
            } else {
                0
            };
            patches + group.positions.len() * size_of::<DVec3>()
        });
        let is_stored = before.is_some_and(|s| Arc::ptr_eq(&s.assembly, &self.assembly));
        let assembly = if is_stored { 0 } else { self.assembly.bytes() };
        groups.sum::<usize>() + assembly
    }
}

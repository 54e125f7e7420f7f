//! Data shared by all computations on one region.

use std::sync::{Arc, OnceLock};

use crate::mesh::{FaceId, Topology};
use crate::subdivision::{Elements, Rule, Stencils};

/// Connectivity of a region, the faces over which the energy is integrated, and their elements by
/// quadrature rule. Stencils are gathered once; the tables of a rule are made at its first use.
#[derive(Debug)]
pub struct Discretization {
    topology: Arc<Topology>,
    active: Vec<FaceId>,
    stencils: OnceLock<Arc<Stencils>>,
    elements: [OnceLock<Elements>; Rule::ALL.len()],
}

impl Discretization {
    /// The energy is integrated over the `active` faces.
    pub fn new(topology: Arc<Topology>, active: Vec<FaceId>) -> Self {
        Self {
            topology,
            active,
            stencils: OnceLock::new(),
            elements: Default::default(),
        }
    }

    /// Connectivity of the region.
    pub fn topology(&self) -> &Arc<Topology> {
        &self.topology
    }

    /// The faces over which the energy is integrated.
    pub fn active_faces(&self) -> &[FaceId] {
        &self.active
    }

    /// The elements of the active faces with tables for `rule`.
    pub fn elements(&self, rule: Rule) -> &Elements {
        self.elements[rule as usize].get_or_init(|| {
            let gather = || Arc::new(Stencils::new(&self.topology, &self.active));
            Elements::new(Arc::clone(self.stencils.get_or_init(gather)), rule)
        })
    }
}

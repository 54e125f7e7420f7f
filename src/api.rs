//! Filling holes with one call or with a few options.

use crate::fill::{Continuity, Controls, ControlsError, Filled, LoopChoice, Surface, choose};
use crate::mesh::{Mesh, boundary_loops};
use crate::ops::{BlendSpec, Faces, FillSpec, FlowSpec, OperationError};
use crate::solver::StepRecord;

/// Fills the holes of a mesh as `meniscus fill` does without options. Every boundary loop that is
/// not assumed to be an outer boundary gets a patch. The patch continues the surface smoothly. Its
/// surface model is chosen by prediction of known parts of the mesh around the hole.
///
/// # Errors
/// [`OperationError::Fill`] if the result would not be a manifold. Failures of single holes are
/// reported in the result ([`Filled::complete`]).
pub fn fill(mesh: &Mesh) -> Result<Filled, OperationError> {
    Fill::new(mesh).run()
}

type StepObserver<'a> = Box<dyn Fn(&StepRecord) -> bool + Sync + 'a>;

/// A fill with options. The defaults are those of [`fn@fill`].
///
/// ```
/// use meniscus::{Fill, mesh, shapes::Sample};
///
/// let sample = Sample::named("sphere").expect("a built-in sample");
/// let (sphere, _) = mesh::build(&sample.soup())?;
/// let filled = Fill::new(&sphere).energy("H^2+K^2")?.density(1.5).run()?;
/// assert!(filled.complete());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Fill<'a> {
    mesh: &'a Mesh,
    loops: LoopChoice,
    joined: bool,
    controls: Controls,
    observer: StepObserver<'a>,
}

impl<'a> Fill<'a> {
    /// Starts with the defaults for a mesh.
    pub fn new(mesh: &'a Mesh) -> Self {
        Self {
            mesh,
            loops: LoopChoice::default(),
            joined: false,
            controls: Controls::default(),
            observer: Box::new(|_| true),
        }
    }

    /// The boundary loops to fill.
    #[must_use]
    pub fn loops(mut self, loops: LoopChoice) -> Self {
        self.loops = loops;
        self
    }

    /// Joins all of these loops, at least two, by one patch instead of filling each.
    #[must_use]
    pub fn joined(mut self) -> Self {
        self.joined = true;
        self
    }

    /// A parameter of the energy; set it before the energy.
    #[must_use]
    pub fn param(mut self, name: &str, value: f64) -> Self {
        self.controls.param.insert(name.to_owned(), value);
        self
    }

    /// The energy `f(H, K)`, such as `H^2`, `(H-H0)^2` or `k1^4+k2^4`. `H` is negative on a sphere with
    /// outward normals; lengths are in the units of the mesh. It makes [`Surface::Energy`] the surface model.
    ///
    /// # Errors
    /// [`ControlsError::Energy`] with the place in the text.
    pub fn energy(mut self, text: &str) -> Result<Self, ControlsError> {
        text.clone_into(&mut self.controls.energy);
        self.controls.surface = Surface::Energy;
        self.controls.options()?;
        Ok(self)
    }

    /// Density of the patches: 2 halves the edge length of the rim.
    #[must_use]
    pub fn density(mut self, density: f64) -> Self {
        self.controls.density = density;
        self
    }

    /// How patches join the mesh.
    #[must_use]
    pub fn continuity(mut self, continuity: Continuity) -> Self {
        self.controls.continuity = continuity;
        self
    }

    /// Sets all options at once. Replaces every previous choice except the loops.
    #[must_use]
    pub fn controls(mut self, controls: Controls) -> Self {
        self.controls = controls;
        self
    }

    /// Calls `observer` after every attempted step of every group of holes, from several threads.
    /// It returns whether to continue.
    #[must_use]
    pub fn on_step(mut self, observer: impl Fn(&StepRecord) -> bool + Sync + 'a) -> Self {
        self.observer = Box::new(observer);
        self
    }

    /// Runs the fill.
    ///
    /// # Errors
    /// A loop that does not exist, invalid options, fewer than two loops to join, or a result that
    /// would not be a manifold. Failures of single holes are reported in the result.
    pub fn run(self) -> Result<Filled, OperationError> {
        let mesh = self.mesh;
        let loops = choose(&boundary_loops(mesh), &self.loops)?;
        let flow = FlowSpec::from(self.controls);
        let observe = |_, record: &StepRecord| (self.observer)(record);
        let prepared = if self.joined {
            BlendSpec { loops, flow }.prepare(mesh)?
        } else {
            let spec = FillSpec {
                loops,
                islands: true,
                bridges: Faces::default(),
                flow,
            };
            spec.prepare(mesh)?
        };
        Ok(prepared.run(&observe)?)
    }
}

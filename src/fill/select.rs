//! The choice of loops to fill.

use crate::mesh::{BoundaryLoop, DVec3, LoopId, Mesh};

/// A choice of loops.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum LoopChoice {
    /// Every loop that is not classified as an outer boundary.
    #[default]
    Auto,
    /// Every loop.
    All,
    /// Every loop except the one with the largest perimeter.
    AllButLargest,
    /// These loops.
    Listed(Vec<LoopId>),
}

impl std::str::FromStr for LoopChoice {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "auto" => Ok(Self::Auto),
            "all" => Ok(Self::All),
            "all-but-largest" => Ok(Self::AllButLargest),
            _ => text
                .split(',')
                .map(|word| {
                    word.trim().parse().map_err(|_| {
                        format!(
                            "`{word}` is not a loop number; write auto, all, all-but-largest, or \
                             numbers from `meniscus info` such as 1,3"
                        )
                    })
                })
                .collect::<Result<_, _>>()
                .map(Self::Listed),
        }
    }
}

/// The error of a loop that does not exist.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("loop {id} does not exist: the mesh has {loops} boundary loops")]
pub struct NoSuchLoop {
    /// The number given.
    pub id: LoopId,
    /// Number of loops of the mesh.
    pub loops: usize,
}

/// The chosen loops in ascending order, each once.
///
/// # Errors
/// A chosen loop does not exist.
pub fn choose(loops: &[BoundaryLoop], choice: &LoopChoice) -> Result<Vec<LoopId>, NoSuchLoop> {
    let all = loops.iter();
    Ok(match choice {
        LoopChoice::Auto => all.filter(|l| !l.is_outer_boundary).map(|l| l.id).collect(),
        LoopChoice::All => all.map(|l| l.id).collect(),
        LoopChoice::AllButLargest => {
            let largest = all
                .clone()
                .max_by(|a, b| a.perimeter.total_cmp(&b.perimeter))
                .map(|l| l.id);
            all.map(|l| l.id)
                .filter(|&id| Some(id) != largest)
                .collect()
        }
        LoopChoice::Listed(chosen) => {
            let count = loops.len();
            if let Some(&id) = chosen.iter().find(|id| id.index() >= count) {
                return Err(NoSuchLoop { id, loops: count });
            }
            let mut chosen = chosen.clone();
            chosen.sort_unstable();
            chosen.dedup();
            chosen
        }
    })
}

/// The loop with the vertex nearest to `point`; `None` if there are no loops.
pub fn nearest_loop(mesh: &Mesh, loops: &[BoundaryLoop], point: DVec3) -> Option<LoopId> {
    let distance = |l: &BoundaryLoop| {
        l.vertices
            .iter()
            .map(|&v| mesh.position(v).distance_squared(point))
            .fold(f64::INFINITY, f64::min)
    };
    loops
        .iter()
        .map(|l| (l.id, distance(l)))
        .min_by(|a, b| a.1.total_cmp(&b.1))
        .map(|(id, _)| id)
}

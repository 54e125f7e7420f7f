//! Which loops to fill.

use crate::mesh::{BoundaryLoop, DVec3, Mesh};

/// A choice of loops.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum LoopChoice {
    /// Every loop not guessed an outer rim.
    #[default]
    Auto,
    /// Every loop.
    All,
    /// Every loop but the one of the greatest perimeter.
    AllButLargest,
    /// These loop numbers (1-based).
    Numbers(Vec<usize>),
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
                .map(|word| match word.trim().parse::<usize>() {
                    Ok(n) if n > 0 => Ok(n),
                    _ => Err(format!(
                        "`{word}` is not a loop number; give auto, all, all-but-largest, or \
                         numbers from `meniscus info` such as 1,3"
                    )),
                })
                .collect::<Result<_, _>>()
                .map(Self::Numbers),
        }
    }
}

/// A loop number that does not exist.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("there is no loop {number}: this mesh has {loops} (see `meniscus info`)")]
pub struct NoSuchLoop {
    /// The number asked for.
    pub number: usize,
    /// How many loops there are.
    pub loops: usize,
}

/// Indices of the chosen loops, ascending, each once.
///
/// # Errors
/// A number that no loop has.
pub fn choose(loops: &[BoundaryLoop], choice: &LoopChoice) -> Result<Vec<usize>, NoSuchLoop> {
    let all = 0..loops.len();
    Ok(match choice {
        LoopChoice::Auto => all.filter(|&i| !loops[i].outer_rim).collect(),
        LoopChoice::All => all.collect(),
        LoopChoice::AllButLargest => {
            let largest = all
                .clone()
                .max_by(|&a, &b| loops[a].perimeter.total_cmp(&loops[b].perimeter));
            all.filter(|&i| Some(i) != largest).collect()
        }
        LoopChoice::Numbers(numbers) => {
            let mut chosen = Vec::new();
            for &number in numbers {
                if number == 0 || number > loops.len() {
                    return Err(NoSuchLoop {
                        number,
                        loops: loops.len(),
                    });
                }
                chosen.push(number - 1);
            }
            chosen.sort_unstable();
            chosen.dedup();
            chosen
        }
    })
}

/// Index of the loop with the vertex nearest to `point`; `None` if there are no loops.
pub fn nearest_loop(mesh: &Mesh, loops: &[BoundaryLoop], point: DVec3) -> Option<usize> {
    let distance = |l: &BoundaryLoop| {
        l.vertices
            .iter()
            .map(|&v| mesh.position(v).distance_squared(point))
            .fold(f64::INFINITY, f64::min)
    };
    loops
        .iter()
        .map(distance)
        .enumerate()
        .min_by(|a, b| a.1.total_cmp(&b.1))
        .map(|(i, _)| i)
}

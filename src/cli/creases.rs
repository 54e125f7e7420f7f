//! Sharp edges on the command line.

use std::path::PathBuf;

use clap::Args;

use crate::cli::UsageError;

/// Edges that are to stay sharp: all that one of the options names.
#[derive(Debug, Args)]
pub struct CreaseArguments {
    /// Keep edges sharp at which the triangles differ by more than this, in degrees.
    #[arg(long, value_name = "DEG")]
    pub crease_angle: Option<f64>,
    /// Keep the edges between these vertices sharp, one after the other: their numbers, counted from 1
    /// in the order of the file (repeatable).
    #[arg(long, value_name = "V,W,...")]
    pub crease: Vec<String>,
    /// Read such chains from a file, one a line, as the window writes them.
    #[arg(long, value_name = "FILE")]
    pub creases_from: Option<PathBuf>,
}

impl CreaseArguments {
    /// The edges named, by the indices of their ends.
    ///
    /// # Errors
    /// A chain that cannot be read.
    pub fn edges(&self) -> Result<Vec<[u32; 2]>, UsageError> {
        let mut edges = Vec::new();
        for text in &self.crease {
            let chain = chain(text).map_err(|fault| UsageError(format!("--crease: {fault}")))?;
            edges.extend(chain);
        }
        if let Some(path) = &self.creases_from {
            let name = path.display();
            let text = std::fs::read_to_string(path)
                .map_err(|e| UsageError(format!("cannot read {name}: {e}")))?;
            let chains = lines(&text).map_err(|fault| UsageError(format!("{name}, {fault}")))?;
            edges.extend(chains);
        }
        Ok(edges)
    }
}

/// The edges of all chains of a file.
fn lines(text: &str) -> Result<Vec<[u32; 2]>, String> {
    let mut edges = Vec::new();
    for (n, line) in text.lines().enumerate() {
        if !line.trim().is_empty() {
            let chain = chain(line).map_err(|fault| format!("line {}: {fault}", n + 1))?;
            edges.extend(chain);
        }
    }
    Ok(edges)
}

/// The edges of a chain `V,W,...`.
fn chain(text: &str) -> Result<Vec<[u32; 2]>, String> {
    let mistaken =
        || format!("`{text}` is no chain of edges; give two vertex numbers or more, as in 4,7,9");
    let number = |t: &str| t.trim().parse().ok().filter(|&n| n > 0);
    let numbers: Option<Vec<u32>> = text.split(',').map(number).collect();
    match numbers {
        Some(v) if v.len() > 1 => Ok(v.windows(2).map(|e| [e[0] - 1, e[1] - 1]).collect()),
        _ => Err(mistaken()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chains_are_read_and_mistakes_named() {
        assert_eq!(chain("4, 7,9"), Ok(vec![[3, 6], [6, 8]]));
        for text in ["", "4", "4,0", "4,x", "4;7"] {
            assert!(chain(text).is_err_and(|e| e.contains("4,7,9")), "{text}");
        }
    }

    #[test]
    fn a_file_has_a_chain_a_line() {
        assert_eq!(lines("1,2,3\n\n7,5\n"), Ok(vec![[0, 1], [1, 2], [6, 4]]));
        assert!(lines("1,2\n3\n").is_err_and(|e| e.starts_with("line 2")));
    }
}

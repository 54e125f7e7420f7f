//! Sharp edges on the command line.

use std::path::PathBuf;

use clap::Args;

use crate::cli::UsageError;
use crate::ops::parse_chain;

/// Edges that stay sharp: the union of those named by the options.
#[derive(Debug, Args)]
pub struct CreaseArguments {
    /// Keep the edges of this chain of vertices sharp. Vertices are counted from 1 in the order of
    /// the file (repeatable).
    #[arg(long, value_name = "V,W,...")]
    pub crease: Vec<String>,
    /// Read chains from a file, one per line, as written by the window.
    #[arg(long, value_name = "FILE")]
    pub creases_from: Option<PathBuf>,
}

impl CreaseArguments {
    /// The named chains of edges, as vertex indices.
    ///
    /// # Errors
    /// A chain that cannot be read.
    pub fn chains(&self) -> Result<Vec<Vec<u32>>, UsageError> {
        let typed = self.crease.iter().map(|text| parse_chain(text));
        let typed = typed.collect::<Result<Vec<_>, _>>();
        let mut chains = typed.map_err(|error| UsageError(format!("--crease: {error}")))?;
        if let Some(path) = &self.creases_from {
            let name = path.display();
            let text = std::fs::read_to_string(path)
                .map_err(|e| UsageError(format!("cannot read {name}: {e}")))?;
            let listed = lines(&text).map_err(|error| UsageError(format!("{name}, {error}")))?;
            chains.extend(listed);
        }
        Ok(chains)
    }
}

/// The chains of a file, one per line.
fn lines(text: &str) -> Result<Vec<Vec<u32>>, String> {
    let lines = text.lines().enumerate();
    lines
        .filter(|(_, line)| !line.trim().is_empty())
        .map(|(n, line)| parse_chain(line).map_err(|error| format!("line {}: {error}", n + 1)))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_has_a_chain_a_line() {
        assert_eq!(lines("1,2,3\n\n7,5\n"), Ok(vec![vec![0, 1, 2], vec![6, 4]]));
        assert!(lines("1,2\n3\n").is_err_and(|e| e.starts_with("line 2")));
    }
}

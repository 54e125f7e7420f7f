//! The command that repeats an operation.

use std::path::{Path, PathBuf};

use super::Operation;
use crate::mesh::{DVec3, ranges_text};
use crate::options::Options;

/// Lists of faces and sharp edges longer than this, in bytes, are written to files.
const LONG: usize = 120;

/// A command and the files that it reads in addition to its mesh.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CommandLine {
    /// The command line for a POSIX shell.
    pub line: String,
    /// Names and contents of the files to write first.
    pub files: Vec<(PathBuf, String)>,
}

impl Operation {
    /// The name of the command.
    pub fn command_name(&self) -> &'static str {
        match self {
            Self::Fill(_) | Self::FillPart(_) => "fill",
            Self::Blend(_) => "blend",
            Self::Refill(_) | Self::Fair(_) => "refill",
            Self::Refine(_) => "refine",
            Self::Erase(_) => "erase",
            Self::Flip(_) => "flip",
            Self::Bridge(_) => "bridge",
            Self::Clean(_) => "clean",
            Self::Stitch(_) => "stitch",
        }
    }

    /// The command that applies the operation to the mesh of `input` and writes `output`. Schedules
    /// and long lists are in files whose names start with that of `output`.
    pub fn command(&self, input: &Path, output: &Path) -> CommandLine {
        let path = |p: &Path| p.to_string_lossy().into_owned();
        let mut words = vec!["meniscus".into(), self.command_name().into(), path(input)];
        words.extend(["-o".into(), path(output)]);
        let mut files = Vec::new();
        words.extend(self.arguments(output, &mut files));
        let words: Vec<String> = words.iter().map(|word| quoted(word)).collect();
        CommandLine {
            line: words.join(" "),
            files,
        }
    }

    /// The arguments of the command after IN and OUT. Appends the files they name to `files`.
    pub(super) fn arguments(
        &self,
        output: &Path,
        files: &mut Vec<(PathBuf, String)>,
    ) -> Vec<String> {
        let mut words = Vec::new();
        let mut file = |extension: &str, text: String| {
            let path = output.with_extension(extension);
            let name = path.to_string_lossy().into_owned();
            files.push((path, text));
            name
        };
        let numbers: Vec<String> = self.loops().iter().map(ToString::to_string).collect();
        let point = |p: DVec3| format!("{},{},{}", p.x, p.y, p.z);
        match self {
            Self::Fill(_) | Self::Blend(_) => words.extend(flag("loops", numbers.join(","))),
            Self::Flip(_) => {
                words.extend(numbers.into_iter().flat_map(|n| flag("component-of", n)));
            }
            Self::Bridge(spec) => {
                words.extend(flag("from", point(spec.ends[0])));
                words.extend(flag("to", point(spec.ends[1])));
                words.extend(flag("width", spec.width.to_string()));
            }
            Self::FillPart(spec) => {
                words.push("--part".into());
                words.extend(spec.ends.map(point));
            }
            Self::Refine(spec) => {
                let chains = spec.creases.iter().map(|c| chain_text(c));
                let chains: Vec<String> = chains.collect();
                if chains.iter().map(String::len).sum::<usize>() > LONG {
                    let name = file("creases.txt", chains.join("\n") + "\n");
                    words.extend(flag("creases-from", name));
                } else {
                    words.extend(chains.into_iter().flat_map(|c| flag("crease", c)));
                }
            }
            Self::Refill(_) | Self::Fair(_) | Self::Erase(_) | Self::Clean(_) | Self::Stitch(_) => {
            }
        }
        let list = ranges_text(&self.faces());
        if list.len() > LONG {
            let name = file("faces.txt", list.replace(',', "\n") + "\n");
            words.extend(flag("faces-from", name));
        } else if !list.is_empty() {
            words.extend(flag("faces", list));
        }
        if let Self::Fill(spec) = self
            && !spec.bridges.is_empty()
        {
            words.extend(flag("bridge-faces", ranges_text(&spec.bridges)));
        }
        match self {
            Self::Fill(spec) if !spec.islands => words.push("--no-islands".into()),
            Self::Fair(_) => words.push("--fair".into()),
            _ => {}
        }
        words.extend(match self {
            Self::Refine(spec) => spec.controls.to_arguments(),
            Self::Clean(spec) => spec.to_arguments(),
            Self::Stitch(spec) => spec.to_arguments(),
            _ => (self.flow()).map_or_else(Vec::new, |flow| flow.controls.to_arguments()),
        });
        if let Some(schedule) = self.schedule()
            && !schedule.entries.is_empty()
        {
            let name = file("schedule.csv", schedule.to_csv());
            words.extend(flag("schedule", name));
        }
        words
    }
}

fn flag(name: &str, value: String) -> [String; 2] {
    [format!("--{name}"), value]
}

/// A chain of edges as vertex numbers counted from 1: `4,7,9`.
pub fn chain_text(chain: &[u32]) -> String {
    let numbers: Vec<String> = chain
        .iter()
        .map(|v| (u64::from(*v) + 1).to_string())
        .collect();
    numbers.join(",")
}

/// Parses the text of [`chain_text`].
///
/// # Errors
/// The text is not a list of at least two vertex numbers.
pub fn parse_chain(text: &str) -> Result<Vec<u32>, String> {
    let index = |t: &str| t.trim().parse::<u32>().ok()?.checked_sub(1);
    let chain: Option<Vec<u32>> = text.split(',').map(index).collect();
    chain.filter(|c| c.len() > 1).ok_or_else(|| {
        format!("`{text}` is not a chain of edges; write at least two vertex numbers, as in 4,7,9")
    })
}

/// A word quoted for a POSIX shell.
fn quoted(word: &str) -> String {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "-_./,=+:@%".contains(c);
    if !word.is_empty() && word.chars().all(is_plain) {
        word.to_owned()
    } else {
        format!("'{}'", word.replace('\'', r"'\''"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_that_a_shell_would_split_are_quoted() {
        assert_eq!(quoted("H^2+K^2"), "'H^2+K^2'");
        assert_eq!(quoted("it's"), r"'it'\''s'");
        assert_eq!(quoted("a-b_c/d.obj"), "a-b_c/d.obj");
        assert_eq!(quoted(""), "''");
    }

    #[test]
    fn chains_are_read_and_errors_named() {
        assert_eq!(parse_chain("4, 7,9"), Ok(vec![3, 6, 8]));
        assert_eq!(chain_text(&[3, 6, 8]), "4,7,9");
        for text in ["", "4", "4,0", "4,x", "4;7"] {
            assert!(
                parse_chain(text).is_err_and(|e| e.contains("4,7,9")),
                "{text}"
            );
        }
    }
}

//! The command that repeats what was done.

use std::path::Path;

use crate::fill::Controls;
use crate::options::Options;

/// `meniscus COMMAND IN -o OUT` with further `words`, `controls` where they are not the defaults, and
/// the changes of a schedule file: quoted for a POSIX shell.
pub fn command_line(
    command: &str,
    input: &Path,
    output: &Path,
    words: &[String],
    controls: Option<&Controls>,
    schedule: Option<&Path>,
) -> String {
    let path = |p: &Path| p.to_string_lossy().into_owned();
    let mut line = vec!["meniscus".into(), command.into(), path(input)];
    line.extend(["-o".into(), path(output)]);
    line.extend_from_slice(words);
    line.extend(controls.into_iter().flat_map(Controls::to_arguments));
    if let Some(schedule) = schedule {
        line.extend(["--schedule".into(), path(schedule)]);
    }
    let line: Vec<String> = line.iter().map(|word| quoted(word)).collect();
    line.join(" ")
}

/// A word as a POSIX shell reads it back.
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
    fn words_a_shell_would_take_apart_are_quoted() {
        assert_eq!(quoted("H^2+K^2"), "'H^2+K^2'");
        assert_eq!(quoted("it's"), r"'it'\''s'");
        assert_eq!(quoted("a-b_c/d.obj"), "a-b_c/d.obj");
        assert_eq!(quoted(""), "''");
        let line = command_line(
            "fill",
            Path::new("my scan.obj"),
            Path::new("out.obj"),
            &["--loops".into(), "1,3".into()],
            Some(&Controls::default()),
            Some(Path::new("s.csv")),
        );
        assert_eq!(
            line,
            "meniscus fill 'my scan.obj' -o out.obj --loops 1,3 --schedule s.csv"
        );
    }
}

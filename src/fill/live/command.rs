//! The command that repeats a fill.

use std::path::Path;

use crate::fill::Controls;

/// The `meniscus fill` that fills these loops from `controls` on, with the changes of a schedule
/// file: quoted for a POSIX shell.
pub fn command_line(
    input: &Path,
    output: &Path,
    loops: &[usize],
    controls: &Controls,
    schedule: Option<&Path>,
) -> String {
    line("fill", input, output, loops, controls, schedule)
}

/// The `meniscus blend` that joins these loops, likewise.
pub fn blend_command_line(
    input: &Path,
    output: &Path,
    loops: &[usize],
    controls: &Controls,
    schedule: Option<&Path>,
) -> String {
    line("blend", input, output, loops, controls, schedule)
}

fn line(
    command: &str,
    input: &Path,
    output: &Path,
    loops: &[usize],
    controls: &Controls,
    schedule: Option<&Path>,
) -> String {
    let path = |p: &Path| p.to_string_lossy().into_owned();
    let numbers: Vec<String> = loops.iter().map(ToString::to_string).collect();
    let mut words = vec!["meniscus".into(), command.into(), path(input)];
    words.extend(["-o".into(), path(output)]);
    words.extend(["--loops".into(), numbers.join(",")]);
    words.extend(controls.to_arguments());
    if let Some(schedule) = schedule {
        words.extend(["--schedule".into(), path(schedule)]);
    }
    let words: Vec<String> = words.iter().map(|word| quoted(word)).collect();
    words.join(" ")
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
            Path::new("my scan.obj"),
            Path::new("out.obj"),
            &[1, 3],
            &Controls::default(),
            Some(Path::new("s.csv")),
        );
        assert_eq!(
            line,
            "meniscus fill 'my scan.obj' -o out.obj --loops 1,3 --schedule s.csv"
        );
    }
}

//! Random changes of an input.

use meniscus::random::SplitMix;

/// Numbers at the limits of what readers accept.
const NUMBERS: [&str; 16] = [
    "0",
    "-0",
    "1",
    "-1",
    "255",
    "256",
    "65536",
    "2147483648",
    "4294967295",
    "4294967296",
    "18446744073709551616",
    "1e308",
    "1e309",
    "5e-324",
    "nan",
    "-inf",
];
/// Maximum number of changes of one input.
const MAX_CHANGES: usize = 6;

/// Changes an input in a few places. `seeds` lend pieces, `words` belong to the format.
pub fn mutate(input: &mut Vec<u8>, seeds: &[Vec<u8>], words: &[&str], random: &mut SplitMix) {
    for _ in 0..=random.below(MAX_CHANGES) {
        change(input, seeds, words, random);
    }
}

fn change(input: &mut Vec<u8>, seeds: &[Vec<u8>], words: &[&str], random: &mut SplitMix) {
    let at = random.below(input.len() + 1);
    match random.below(9) {
        0 if at < input.len() => input[at] ^= 1 << random.below(8),
        1 if at < input.len() => input[at] = random.below(256) as u8,
        2 => drop(input.drain(at..piece_end(input, at, random))),
        3 => {
            let piece = input[at..piece_end(input, at, random)].to_vec();
            let to = random.below(input.len() + 1);
            input.splice(to..to, piece);
        }
        4 => {
            let other = &seeds[random.below(seeds.len())];
            let from = random.below(other.len() + 1);
            let piece = other[from..piece_end(other, from, random)].to_vec();
            input.splice(at..at, piece);
        }
        5 => input.truncate(at),
        6 => replace_number(input, at, NUMBERS[random.below(NUMBERS.len())]),
        _ => {
            let word = words[random.below(words.len())];
            input.splice(at..at, word.bytes());
        }
    }
}

/// The end of a piece that starts at `at`, mostly short.
fn piece_end(bytes: &[u8], at: usize, random: &mut SplitMix) -> usize {
    let longest = [4, 32, 512][random.below(3)];
    (at + random.below(longest) + 1).min(bytes.len())
}

/// Replaces the first run of digits from `at` on by `number`.
fn replace_number(input: &mut Vec<u8>, at: usize, number: &str) {
    let Some(start) = (at..input.len()).find(|&i| input[i].is_ascii_digit()) else {
        return;
    };
    let digits = input[start..].iter().take_while(|b| b.is_ascii_digit());
    let end = start + digits.count();
    input.splice(start..end, number.bytes());
}

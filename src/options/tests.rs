use std::collections::BTreeMap;

use super::value::number;
use super::*;

#[derive(Clone, Copy, Debug, Default, PartialEq)]
enum Colour {
    #[default]
    Red,
    DeepBlue,
}

choices!(Colour: Red "red", DeepBlue "deep-blue");

options! {
    /// Options of a test.
    struct Paint {
        /// Which colour, of
        /// those there are.
        colour: Colour = Colour::Red,
        /// Number of coats.
        coats("N"): usize = 2,
        /// Thickness.
        film_width("MM"): f64 = 0.1,
        /// Limit.
        limit("MM"): Option<f64> = None,
        /// Without primer.
        no_primer: bool = false,
        /// Parts of pigments.
        #[serde(alias = "parts")]
        part("NAME=PARTS"): BTreeMap<String, f64> = BTreeMap::new(),
        /// Title.
        title("TEXT"): String = "wall".into(),
    }
}

fn changed() -> Paint {
    Paint {
        colour: Colour::DeepBlue,
        coats: 3,
        film_width: -1.0 / 3.0,
        limit: Some(1e-300),
        no_primer: true,
        part: [("ochre".into(), 0.5), ("umber".into(), 2.0)].into(),
        title: "a, \"b\"".into(),
    }
}

#[test]
fn differences_set_back_give_the_same_options() {
    let some = Paint {
        part: [("ochre".into(), 1.0), ("chalk".into(), 2.0)].into(),
        ..changed()
    };
    for from in [Paint::default(), changed(), some.clone()] {
        for to in [Paint::default(), changed(), some.clone()] {
            let mut options = from.clone();
            for (name, text) in from.difference(&to) {
                options.set(&name, &text).expect("as written");
            }
            assert_eq!(options, to);
        }
        assert!(from.difference(&from).is_empty());
    }
}

#[test]
fn arguments_name_what_differs_from_the_defaults() {
    assert!(Paint::default().to_arguments().is_empty());
    let paint = Paint {
        no_primer: true,
        film_width: 2.5,
        part: [("a".into(), 1.0)].into(),
        ..Paint::default()
    };
    let words = ["--film-width", "2.5", "--no-primer", "--part", "a=1"];
    assert_eq!(paint.to_arguments(), words);
}

#[test]
fn entries_hold_names_help_and_defaults() {
    let entries = Paint::entries();
    let names: Vec<&str> = entries.iter().map(|e| e.name.as_str()).collect();
    assert_eq!(
        names,
        [
            "colour",
            "coats",
            "film-width",
            "limit",
            "no-primer",
            "part",
            "title"
        ]
    );
    assert_eq!(entries[0].help.trim(), "Which colour, of those there are.");
    assert_eq!(entries[0].kind, Kind::Choice(vec!["red", "deep-blue"]));
    assert_eq!(entries[2].value_name, Some("MM"));
    assert_eq!(entries[1].default.as_deref(), Some("2"));
    assert_eq!(entries[3].default, None);
}

#[test]
fn errors_name_problem_and_remedy() {
    let mut paint = Paint::default();
    for (name, text, wanted) in [
        ("hue", "1", "unknown option `hue`; options are colour,"),
        (
            "colour",
            "green",
            "`green` is not one of the choices; choose red or deep-blue",
        ),
        ("coats", "-1", "`-1` is not a valid number; write a number"),
        ("limit", "high", "`high` is not a valid number"),
        ("no-primer", "maybe", "`maybe` is not true or false"),
        ("part", "ochre", "`ochre` has no `=`; write NAME=PARTS"),
        ("part", "ochre=much", "`much` is not a valid number"),
    ] {
        let error = paint.set(name, text).expect_err("an error").to_string();
        assert!(error.starts_with(wanted), "{error}");
        assert_eq!(paint.part, BTreeMap::new());
    }
}

#[test]
fn files_hold_names_with_hyphens_and_read_aliases() {
    let text = toml::to_string(&changed()).expect("plain values");
    assert!(
        text.contains("film-width") && text.contains("\"deep-blue\""),
        "{text}"
    );
    assert_eq!(toml::from_str::<Paint>(&text), Ok(changed()));
    let early = toml::from_str::<Paint>("colour = \"Red\"\n[parts]\nchalk = 1.0\n");
    assert_eq!(early.expect("options").part["chalk"], 1.0);
    assert!(toml::from_str::<Paint>("colour = \"green\"").is_err());
}

#[test]
fn numbers_read_back_as_they_were() {
    for x in [
        0.0,
        -0.0,
        1.0 / 3.0,
        1e-300,
        -2.5e17,
        123_456.789,
        1e-4,
        f64::MIN_POSITIVE,
    ] {
        let read: f64 = number(x).parse().expect("a number");
        assert_eq!(read.to_bits(), x.to_bits(), "{}", number(x));
        assert!(number(x).len() < 25, "{}", number(x));
    }
}

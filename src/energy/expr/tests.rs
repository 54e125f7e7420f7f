//! The grammar: precedence, and every error at its character.

use std::collections::BTreeMap;

use super::scalar::ScalarAlgebra;
use super::*;
use crate::energy::{Energy, Preset};

fn params() -> BTreeMap<String, f64> {
    BTreeMap::from([("a".to_owned(), 0.5), ("n".to_owned(), 4.0)])
}

fn value(text: &str, k1: f64, k2: f64) -> f64 {
    let (program, _) = parse(text, &params()).unwrap_or_else(|error| panic!("{}", error.render()));
    program.eval(&ScalarAlgebra { k1, k2 }).value
}

#[test]
fn signs_powers_and_precedence() {
    // At κ1 = 3, κ2 = 1: H = 2, K = 3.
    for (text, want) in [
        ("-H^2", -4.0),
        ("(-H)^2", 4.0),
        ("2^-1", 0.5),
        ("2^-H", 0.25),
        ("2^3^2", 512.0),
        ("(2^3)^2", 64.0),
        ("2^-2^2", 0.0625),
        ("-2^-2", -0.25),
        ("1-2-3", -4.0),
        ("12/3/2", 2.0),
        ("12/3*2", 8.0),
        ("1-H*K^2", -17.0),
        ("--H", 2.0),
        ("-+-H", 2.0),
        ("2--H", 4.0),
        ("2*-H", -4.0),
        ("H/-K*3", -2.0),
        ("-H*K", -6.0),
        ("k1-k2", 2.0),
        ("1e-3*H", 2e-3),
        ("1E+2", 100.0),
        (".5*H", 1.0),
        ("2.*H", 4.0),
        ("2.5e1", 25.0),
        ("pi", std::f64::consts::PI),
        ("a*H^n", 8.0),
        ("H^(2*2)", 16.0),
        ("(1)", 1.0),
        ("((H))", 2.0),
        ("abs(-H)+abs(K)", 5.0),
        ("min(H,K)+max(H,K)*10", 32.0),
        ("max(min(H,K),1)", 2.0),
        ("sqrt(4)*sqrt(H+2)", 4.0),
        ("exp(0)+log(1)+sin(0)+cos(0)+tanh(0)", 2.0),
        ("0^0", 1.0),
        ("2^H", 4.0),
        ("H^K", 8.0),
        ("1/H", 0.5),
        ("1-H", -1.0),
        (" H \t+\n K ", 5.0),
    ] {
        let found = value(text, 3.0, 1.0);
        assert!(
            (found - want).abs() <= 1e-15 * want.abs(),
            "{text}: {found} {want}"
        );
    }
}

#[test]
fn constants_are_folded() {
    for (text, count) in [
        ("2*3^2-1", 1),
        ("2*H", 2),
        ("H+1-2", 3),
        ("H^(n-2)", 2),
        ("-(2)*H", 2),
    ] {
        let (program, _) = parse(text, &params()).expect("valid");
        assert_eq!(program.len(), count, "{text}: {program:?}");
    }
}

/// `gradH2` occurs linearly, with a coefficient that is a number.
#[test]
fn other_uses_of_the_gradient_are_refused_at_their_place() {
    for marked in [
        "»gradH2^2",
        "H*»gradH2",
        "H^2 + 3*»gradH2*gradH2",
        "gradH2 + sqrt(»gradH2)",
        "gradH2 - max(1, »gradH2)",
        "1/»gradH2",
        "2^»gradH2",
        "»gradH2^H",
        "(H+1)*(2-»gradH2)",
        "K + »gradH2/(H-H)",
        "»gradH2/0",
    ] {
        let text = marked.replace('»', "");
        let error = Energy::parse(&text, &params()).expect_err(marked);
        let place = error.syntax().expect("a place");
        assert_eq!(Some(place.byte), marked.find('»'), "{marked}: {error}");
        assert!(place.message.contains("gradH2 must be a term"), "{error}");
    }
    let reserved = BTreeMap::from([("gradH2".to_owned(), 1.0)]);
    assert!(Energy::parse("H", &reserved).is_err());
}

/// The text with `»` where the error is expected, and a part of the message.
#[test]
fn errors_point_at_the_character() {
    for (marked, message) in [
        ("»", "the expression is empty"),
        ("  »", "the expression is empty"),
        ("2»H", "expected an operator, e.g. 2*H"),
        ("H^2 + 2»H", "expected an operator, e.g. 2*H"),
        ("2»(H+1)", "expected an operator, e.g. 2*(...)"),
        ("(H+1)»(H-1)", "expected an operator, e.g. (...)*(...)"),
        ("(H+1)»H", "expected an operator, e.g. (...)*H"),
        ("(2»H)", "expected an operator, e.g. 2*H"),
        ("H »K", "expected an operator, e.g. H*K"),
        ("H »2", "expected an operator, e.g. H*2"),
        ("1.2».3", "expected an operator"),
        (
            "H»(K)",
            "'H' is not a function; expected an operator, e.g. H*(...)",
        ),
        ("a»(K)", "'a' is not a function"),
        (
            "H+»",
            "expected a number, H, K, k1, k2, a parameter, a function or '(', found the end",
        ),
        ("H+»*K", "found '*'"),
        ("»*H", "found '*'"),
        ("H^»", "found the end"),
        ("-»", "found the end"),
        ("(»)", "found ')'"),
        ("(H+K»", "the '(' at character 1 is open"),
        ("H*(K+(H)»", "the '(' at character 3 is open"),
        ("H»)", "unmatched ')'"),
        ("0»,3*H", "decimals are written with a point"),
        ("sin»", "expected '(' after sin, e.g. sin(H), found the end"),
        ("sin »H", "expected '(' after sin"),
        ("sin(»)", "found ')'"),
        ("sin(H»,K)", "sin takes one argument"),
        ("min(H»)", "min takes two arguments: expected ','"),
        ("min(H,K»,1)", "expected an operator or ')'"),
        ("max(H,»)", "found ')'"),
        ("H + »b", "parameters that have a value (a, n)"),
        ("»h^2", "did you mean H?"),
        ("»gradH^2", "did you mean gradH2?"),
        ("»k*H", "did you mean K?"),
        ("»K1 + K2", "did you mean k1?"),
        (
            "»foo(H)",
            "unknown function 'foo'; the functions are abs, sqrt",
        ),
        ("H»**2", "powers are written ^"),
        ("H»²", "powers are written ^"),
        ("κ»₁", "k1 and k2"),
        ("»κ1", "did you mean k1?"),
        ("H »− K", "ASCII hyphen"),
        ("2»·H", "a product is written *"),
        ("»√(H)", "sqrt(...)"),
        ("»|H|", "abs(...)"),
        ("f »= H", "right-hand side"),
        ("H »$ K", "unexpected character '$'"),
        ("».", "digits before or after"),
        ("1»e", "digits after the exponent mark"),
        ("1»e-", "digits after the exponent mark"),
        ("»1e999", "below 1.8e308"),
        ("κ2*»", "unknown name"),
    ] {
        let text = marked.replace('»', "");
        let error = Energy::parse(&text, &params()).expect_err(&text);
        let at = error.syntax().unwrap_or_else(|| panic!("{text}: {error}"));
        assert!(at.message.contains(message), "{text}: {}", at.message);
        // The last case is wrong at its start, whatever follows.
        let byte = if text.starts_with("κ2") {
            0
        } else {
            marked.find('»').expect("marked")
        };
        assert_eq!(at.byte, byte, "{text}: {}", at.message);
        assert_eq!(at.character, text[..byte].chars().count(), "{text}");
        assert!(at.length >= 1);
    }
}

#[test]
fn the_caret_stands_under_the_character() {
    let error = Energy::parse("H^2 + λ»K", &params()).expect_err("no such character");
    assert_eq!(
        error.render(),
        "  H^2 + λ»K\n         ^\nat character 8: unexpected character '»': expected a number, \
         H, K, k1, k2, a parameter, a function or an operator"
    );
    assert!(error.to_string().starts_with("energy: at character 8: "));
    // A long text is cut to a window.
    let long = format!("{}+foo+{}", ["H"; 100].join("+"), ["K"; 100].join("+"));
    let rendered = Energy::parse(&long, &params())
        .expect_err("unknown")
        .render();
    let lines: Vec<&str> = rendered.lines().collect();
    assert!(lines[0].starts_with("  ...") && lines[0].ends_with("..."));
    let column = lines[1].find('^').expect("a caret");
    assert_eq!(&lines[0][column..column + 3], "foo");
    assert_eq!(lines[1].trim(), "^^^");
}

#[test]
fn nesting_and_length_are_bounded() {
    let refused = |text: &str, message: &str| {
        let error = Energy::parse(text, &params()).expect_err("too much");
        assert!(error.to_string().contains(message), "{error}");
        assert!(error.render().len() < 500);
    };
    refused(&"(".repeat(4000), "nested more than");
    refused(&"sin(".repeat(1000), "nested more than");
    refused(&format!("{}H", "2^".repeat(2000)), "nested more than");
    refused(
        &format!("{}H{}", "H+K*(".repeat(20), ")".repeat(20)),
        "operands wait",
    );
    refused(&"H+".repeat(5000), "bytes, at most");
    // Chains that need no nesting may be as long as the text.
    assert_eq!(value(&format!("{}H", "-".repeat(4001)), 3.0, 1.0), -2.0);
    assert_eq!(value(&vec!["H"; 2000].join("+"), 3.0, 1.0), 4000.0);
    assert_eq!(
        value(&vec!["1"; 1000].join("+H+"), 3.0, 1.0),
        1000.0 + 2.0 * 999.0
    );
    assert_eq!(
        value(&format!("{}H{}", "(".repeat(30), ")".repeat(30)), 3.0, 1.0),
        2.0
    );
    assert_eq!(
        value(
            &format!("{}H{}", "H+(".repeat(30), ")".repeat(30)),
            3.0,
            1.0
        ),
        62.0
    );
}

#[test]
fn unsymmetric_expressions_are_refused_with_a_counterexample() {
    for text in [
        "k1",
        "k1-k2",
        "k1^2",
        "k1*H",
        "k1^4+k2^3",
        "2*k1+k2",
        "k1^2*k2",
        "(k1-k2)^3",
        "exp(k1)+k2",
        "H^2 + 1e-9*k1",
        "max(k1,0)",
        "k1^k2",
        "abs(k1)",
        "a*k1+(1-a)*k2*1.000001",
        "k1/k2",
        "log(k1)",
        "1e-12*k1+H^2",
    ] {
        let error = Energy::parse(text, &params()).expect_err(text);
        let ExprError::NotSymmetric {
            k1,
            k2,
            f,
            f_swapped,
            ..
        } = error
        else {
            panic!("{text}: {error}")
        };
        let close = |x: f64, y: f64| x == y || (x.is_nan() && y.is_nan());
        assert!(
            close(value(text, k1, k2), f) && close(value(text, k2, k1), f_swapped),
            "{text}"
        );
        assert!(!close(f, f_swapped), "{text}");
    }
    for text in [
        "k1+k2",
        "k1*k2",
        "(k1-k2)^2",
        "(k1-k2)^6",
        "a*k1+a*k2",
        "max(k1,k2)",
        "abs(k1-k2)",
        "k1^k1+k2^k2",
        "k1/k2+k2/k1",
        "log(k1)+log(k2)",
        "exp(100*k1)+exp(100*k2)",
        "sqrt(k1*k2)",
        "0.1*k1+0.2*k1+0.3*k2",
        "(k1^3-k2^3)/(k1-k2)",
        "H^2",
        "1/(k1-k2)^2",
        "(k1+k2)^3*sin(k1*k2)",
        "tanh(k1)*tanh(k2)-cos(k1-k2)",
        "min(max(k1,k2),1)",
        "0*k1",
    ] {
        if let Err(error) = Energy::parse(text, &params()) {
            panic!("{text}: {error}");
        }
    }
    let text = Energy::parse("k1", &params())
        .expect_err("unsymmetric")
        .to_string();
    assert!(
        text.contains("f(k1=1, k2=2) = 1, but f(k1=2, k2=1) = 2"),
        "{text}"
    );
}

#[test]
fn expressions_without_a_value_are_refused() {
    for text in ["1/0", "sqrt(-1)", "log(-K^2)", "H/0", "(k1-k1)/(k2-k2)"] {
        let error = Energy::parse(text, &params()).expect_err(text);
        assert!(
            matches!(error, ExprError::NowhereFinite { .. }),
            "{text}: {error}"
        );
    }
}

#[test]
fn all_presets_read_back() {
    let params = BTreeMap::from([("H0".to_owned(), 0.0), ("c".to_owned(), 1.0)]);
    for preset in Preset::ALL {
        let energy = Energy::parse(preset.text(), &params).expect("a preset");
        // With H0 = 0, (H-H0)^2 is H^2.
        let want = if preset == Preset::HMinusH0Squared {
            Preset::H2
        } else {
            preset
        };
        assert_eq!(energy.as_preset(), Some(want));
    }
}

proptest::proptest! {
    #![proptest_config(proptest::prelude::ProptestConfig {
        cases: 300, failure_persistence: None, ..Default::default()
    })]

    #[test]
    fn no_text_panics(text in "\\PC{0,40}") {
        if let Err(error) = Energy::parse(&text, &params()) {
            proptest::prop_assert!(error.render().lines().count() <= 3 || text.contains('\n'));
        }
    }

    #[test]
    fn no_soup_of_tokens_panics(
        tokens in proptest::collection::vec(proptest::sample::select(&[
            "H", "K", "k1", "k2", "gradH2", "a", "+", "-", "*", "/", "^", "(", ")", ",", "2", "0", "1e3",
            "sin(", "min(", "log(", "abs(", "²", " ",
        ][..]), 0..24),
        h in -3.0..3.0, k in -3.0..3.0,
    ) {
        let text = tokens.concat();
        match Energy::parse(&text, &params()) {
            Ok(energy) => drop(energy.jet(h, k)),
            Err(error) => if let Some(at) = error.syntax() {
                proptest::prop_assert!(at.byte <= text.len() && text.is_char_boundary(at.byte));
            }
        }
    }
}

#[test]
fn an_unknown_name_is_offered_as_a_parameter() {
    let unknown = |text: &str| {
        let error = Energy::parse(text, &BTreeMap::new()).expect_err("unknown");
        error.syntax().and_then(|e| e.unknown.clone())
    };
    assert_eq!(unknown("H^2 + a*K").as_deref(), Some("a"));
    assert_eq!(unknown("foo(H)"), None);
    assert_eq!(unknown("H^2 +"), None);
}

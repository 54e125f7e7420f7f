use super::arguments::number;
use super::*;

#[test]
fn defaults_need_no_arguments_and_are_the_librarys() {
    assert!(Controls::default().to_arguments().is_empty());
    let options = Controls::default().options().expect("defaults");
    assert_eq!(options.flow, FillOptions::default().flow);
    assert_eq!(options.patch, FillOptions::default().patch);
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

#[test]
fn mistakes_are_refused_with_their_place() {
    let with = |change: &dyn Fn(&mut Controls)| {
        let mut controls = Controls::default();
        change(&mut controls);
        controls.options().expect_err("a mistake")
    };
    let error = with(&|c| c.energy = "H^2 + q".into());
    let place = error
        .expression()
        .and_then(ExprError::syntax)
        .expect("a place");
    assert_eq!(place.byte, 6);
    for (change, wanted) in [
        (
            &(|c: &mut Controls| c.density = 0.0) as &dyn Fn(&mut Controls),
            "density",
        ),
        (&|c| c.tau = TauChoice::Fixed(f64::NAN), "tau"),
        (&|c| c.growth = Some(0.5), "growth"),
        (&|c| c.relaxation = f64::NAN, "relaxation"),
    ] {
        assert!(with(change).to_string().starts_with(wanted));
    }
}

/// A project file may leave out what it does not know yet.
#[test]
fn missing_fields_are_the_defaults() {
    let controls: Controls =
        serde_json::from_str(r#"{"energy":"K^2","tau":{"fixed":0.5}}"#).expect("controls");
    assert_eq!(controls.tau, TauChoice::Fixed(0.5));
    let wanted = Controls {
        energy: "K^2".into(),
        tau: TauChoice::Fixed(0.5),
        ..Controls::default()
    };
    assert_eq!(controls, wanted);
    let text = serde_json::to_string(&controls).expect("plain values");
    assert_eq!(
        serde_json::from_str::<Controls>(&text).expect("as written"),
        controls
    );
}

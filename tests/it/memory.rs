//! Estimates of memory before the computation.

use crate::common::desk::Desk;

/// What a fill is expected to take is within a factor of two and a half of what it takes.
#[cfg(target_os = "linux")]
#[test]
fn estimates_of_memory_are_near_the_peak() {
    let desk = Desk::with_sample("sphere");
    for more in [
        &["--density", "3"][..],
        &["--density", "3", "--surface", "g2"],
    ] {
        let words = ["fill", "in.obj", "-o", "out.obj", "--report", "report.json"];
        desk.runs(&[&words, more].concat());
        let report = desk.json("report.json");
        let number = |name: &str| report[name].as_f64().expect("a number");
        // the program itself and the mesh
        let peak = number("peak_memory") - 16e6;
        let ratio = number("memory_estimate") / peak;
        assert!((0.4..2.5).contains(&ratio), "{more:?}: {ratio}, {peak}");
    }
}

#[test]
fn what_exceeds_the_memory_is_refused_with_a_remedy() {
    let desk = Desk::with_sample("sphere");
    let many = ["fill", "in.obj", "-o", "out.obj", "--density", "100000"];
    let refine = ["refine", "in.obj", "-o", "out.obj", "--levels", "8"];
    if cfg!(target_os = "linux") {
        let words = [
            "GiB of memory would be needed",
            "are free",
            "lower the density",
        ];
        desk.run(&many).fails(1, &words);
        let repair = [&["repair"], &many[1..]].concat();
        desk.run(&repair).fails(1, &words);
        desk.run(&refine)
            .fails(1, &["GiB of memory would be needed", "fewer levels"]);
    }
}

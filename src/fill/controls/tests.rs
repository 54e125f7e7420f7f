use super::*;

#[test]
fn defaults_need_no_arguments() {
    assert!(Controls::default().to_arguments().is_empty());
}

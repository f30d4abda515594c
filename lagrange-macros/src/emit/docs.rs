//! The documentation of a generated type.
use crate::equations::Equations;
pub fn documentation(e: &mut Equations) -> Vec<String> {
    let _ = e;
    vec!["A mechanical system.".into()]
}

//! Settings of objects.

use serde::{Deserialize, Serialize};

/// What a 3MF file says of an object besides its name.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct ObjectSettings {
    /// The object of its faces, as in their tags.
    pub object: String,
    /// The group of its faces, if it is a component; empty for the object itself.
    pub group: String,
    /// Names and values of its attributes: `type` unless that is `model`, `partnumber`.
    pub values: Vec<[String; 2]>,
}

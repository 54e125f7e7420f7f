//! The file form of operations.

use serde::{Deserialize, Serialize};

use super::{Faces, RefineSpec, chain_text, parse_chain};
use crate::options::Options;
use crate::refine::RefineControls;
use crate::runner::Schedule;

/// Faces as a list of ranges, `1-12,40`.
pub mod faces {
    use std::sync::Arc;

    use serde::{Deserialize, Deserializer, Serializer};

    use crate::mesh::{parse_ranges, ranges_text};
    use crate::ops::Faces;

    pub fn serialize<S: Serializer>(faces: &Faces, to: S) -> Result<S::Ok, S::Error> {
        to.serialize_str(&ranges_text(faces))
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<Faces, D::Error> {
        let text = String::deserialize(from)?;
        // the number of faces of the mesh is unknown here
        let list = parse_ranges(&text, u32::MAX as usize);
        list.map(Arc::new).map_err(serde::de::Error::custom)
    }
}

/// Points as lists of coordinates.
pub mod points {
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    use crate::mesh::DVec3;

    pub fn serialize<S: Serializer>(points: &[DVec3; 2], to: S) -> Result<S::Ok, S::Error> {
        points.map(|p| p.to_array()).serialize(to)
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<[DVec3; 2], D::Error> {
        let points = <[[f64; 3]; 2]>::deserialize(from)?;
        Ok(points.map(DVec3::from_array))
    }
}

/// The file form of a refinement. Version 0.1 wrote the arguments of the command as `arguments`.
#[derive(Clone, Serialize, Deserialize)]
pub struct RefineEntry {
    #[serde(default, skip_serializing)]
    arguments: Vec<String>,
    #[serde(default, with = "faces")]
    selected: Faces,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    creases: Vec<String>,
    #[serde(default)]
    schedule: Schedule,
    #[serde(default)]
    controls: RefineControls,
}

impl From<RefineSpec> for RefineEntry {
    fn from(spec: RefineSpec) -> Self {
        Self {
            arguments: Vec::new(),
            selected: spec.faces,
            creases: spec.creases.iter().map(|c| chain_text(c)).collect(),
            schedule: spec.schedule,
            controls: spec.controls,
        }
    }
}

impl TryFrom<RefineEntry> for RefineSpec {
    type Error = String;

    fn try_from(mut entry: RefineEntry) -> Result<Self, String> {
        if !entry.arguments.is_empty() {
            // such files also contain controls, but those of a fill
            entry.controls = RefineControls::default();
        }
        for pair in entry.arguments.chunks(2) {
            match pair {
                [flag, chain] if flag == "--crease" => entry.creases.push(chain.clone()),
                [flag, value] => entry
                    .controls
                    .set(flag.trim_start_matches('-'), value)
                    .map_err(|e| e.to_string())?,
                _ => return Err(format!("the argument {} has no value", pair[0])),
            }
        }
        let creases = entry.creases.iter().map(|text| parse_chain(text));
        Ok(Self {
            controls: entry.controls,
            creases: creases.collect::<Result<_, _>>()?,
            faces: entry.selected,
            schedule: entry.schedule,
        })
    }
}

//! Attributes as text, for project files. Numbers and images are the base64 of their bytes.

use std::sync::Arc;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use serde::{Deserialize, Deserializer, Serialize, Serializer, de::Error};

use super::{NumberType, Numbers};

fn encoded(bytes: &[u8]) -> String {
    STANDARD.encode(bytes)
}

fn decoded<E: Error>(text: &str) -> Result<Vec<u8>, E> {
    STANDARD.decode(text).map_err(E::custom)
}

/// The name of the type in PLY files and the bytes of the numbers, little endian.
impl Serialize for Numbers {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        let mut bytes = Vec::with_capacity(self.bytes());
        for index in 0..self.len() {
            self.push_bytes(index, &mut bytes);
        }
        (self.kind().ply_name(), encoded(&bytes)).serialize(to)
    }
}

impl<'de> Deserialize<'de> for Numbers {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        use NumberType::{F32, F64, I8, I16, I32, U8, U16, U32};
        let (name, text) = <(String, String)>::deserialize(from)?;
        let bytes: Vec<u8> = decoded(&text)?;
        let kinds = [I8, U8, I16, U16, I32, U32, F32, F64];
        let kind = kinds.into_iter().find(|kind| kind.ply_name() == name);
        let kind = kind.ok_or_else(|| D::Error::custom(format!("unknown type '{name}'")))?;
        macro_rules! numbers {
            ($($kind:ident $number:ty),*) => {
                match kind {
                    $($kind => {
                        let (chunks, rest) = bytes.as_chunks();
                        if !rest.is_empty() {
                            return Err(D::Error::custom("bytes of a part of a number"));
                        }
                        let numbers = chunks.iter().map(|chunk| <$number>::from_le_bytes(*chunk));
                        Self::$kind(numbers.collect())
                    })*
                }
            };
        }
        Ok(numbers!(I8 i8, U8 u8, I16 i16, U16 u16, I32 i32, U32 u32, F32 f32, F64 f64))
    }
}

/// The bytes of an image.
pub(super) mod image {
    use super::{Arc, Deserialize, Deserializer, Serialize, Serializer, decoded, encoded};

    pub fn serialize<S: Serializer>(bytes: &Arc<Vec<u8>>, to: S) -> Result<S::Ok, S::Error> {
        encoded(bytes).serialize(to)
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<Arc<Vec<u8>>, D::Error> {
        decoded(&String::deserialize(from)?).map(Arc::new)
    }
}

/// The bytes of images, if they are known.
pub(super) mod images {
    use super::{Arc, Deserialize, Deserializer, Serialize, Serializer, decoded, encoded};

    type Image = Arc<Vec<u8>>;

    pub fn serialize<S: Serializer>(images: &[Option<Image>], to: S) -> Result<S::Ok, S::Error> {
        let texts = images.iter().map(|bytes| Some(encoded(bytes.as_ref()?)));
        texts.collect::<Vec<_>>().serialize(to)
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<Vec<Option<Image>>, D::Error> {
        let texts = Vec::<Option<String>>::deserialize(from)?;
        let bytes = texts.into_iter();
        bytes
            .map(|text| text.map(|text| decoded(&text).map(Arc::new)).transpose())
            .collect()
    }
}

/// The header of an STL file.
pub(super) mod header {
    use super::{Deserialize, Deserializer, Error, Serialize, Serializer, decoded, encoded};

    #[allow(clippy::ref_option)] // the type of the field
    pub fn serialize<S: Serializer>(header: &Option<[u8; 80]>, to: S) -> Result<S::Ok, S::Error> {
        header.map(|bytes| encoded(&bytes)).serialize(to)
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<Option<[u8; 80]>, D::Error> {
        let Some(text) = Option::<String>::deserialize(from)? else {
            return Ok(None);
        };
        let bytes: Vec<u8> = decoded(&text)?;
        let header = bytes.try_into();
        let header = header.map_err(|_| D::Error::custom("a header has 80 bytes"))?;
        Ok(Some(header))
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Attributes, Column, GltfMaterials, ObjectSettings, OwnMaterial};
    use super::*;
    use crate::mesh::{FaceTag, NO_VALUE};

    #[test]
    fn attributes_come_back_from_text() {
        let column = |name: &str, numbers| Column {
            name: name.into(),
            numbers,
            is_typed: true,
        };
        let mut all = Attributes {
            vertices: vec![
                column("a", Numbers::I8(vec![-1, 2])),
                column("b", Numbers::U8(vec![255, 0])),
                column("c", Numbers::I16(vec![-300, 2])),
                column("d", Numbers::U16(vec![65535, 1])),
                column("e", Numbers::I32(vec![i32::MIN, 2])),
                column("f", Numbers::U32(vec![u32::MAX, 0])),
                column("g", Numbers::F32(vec![-0.0, 1e-40])),
                Column::decimals("h", vec![0.1, f64::MAX]),
            ],
            tags: vec![FaceTag {
                object: "a \"b\"\n".into(),
                ..FaceTag::default()
            }],
            texture: Arc::new(vec![Column::decimals("u", vec![1.0 / 3.0])]),
            texture_is_down: true,
            gltf_materials: Some(Arc::new(GltfMaterials {
                names: vec!["m".into()],
                json: serde_json::from_str("{\"materials\":[{\"x\":[0.1,1e-9]}]}").expect("JSON"),
                images: vec![Some(vec![1, 2, 3].into()), None],
            })),
            own_materials: vec![OwnMaterial {
                name: "own".into(),
                like: "m".into(),
                png: Arc::new(vec![9; 100]),
            }],
            comments: vec!["comment c".into()],
            unit: "inch".into(),
            metadata: vec![["Title".into(), "t".into()]],
            objects: vec![ObjectSettings {
                object: "a".into(),
                group: String::new(),
                values: vec![["type".into(), "support".into()]],
            }],
            stl_header: Some([7; 80]),
            ..Attributes::default()
        };
        all.faces.tags = vec![0];
        all.faces.texture = vec![0, 0, NO_VALUE];
        let text = serde_json::to_string(&all).expect("plain data");
        let again: Attributes = serde_json::from_str(&text).expect("what was written");
        assert_eq!(again, all);
        let bits = |all: &Attributes| all.vertices[6].numbers.get(0).to_bits();
        assert_eq!(bits(&again), (-0.0_f64).to_bits());
        assert_eq!(
            serde_json::from_str::<Attributes>("{}").expect("nothing"),
            Attributes::default()
        );
        for wrong in [
            "{\"stl_header\":\"AAAA\"}",
            "{\"vertices\":[{\"name\":\"a\",\"numbers\":[\"float\",\"AAAA\"],\"is_typed\":true}]}",
            "{\"vertices\":[{\"name\":\"a\",\"numbers\":[\"real\",\"\"],\"is_typed\":true}]}",
        ] {
            assert!(
                serde_json::from_str::<Attributes>(wrong).is_err(),
                "{wrong}"
            );
        }
    }
}

//! A model part: resources, objects and the build.

use std::borrow::Cow;
use std::collections::{BTreeSet, HashMap};

use glam::DMat4;
use quick_xml::events::{BytesStart, Event};
use quick_xml::{Reader, XmlVersion};

use super::super::error::{ParseError, ParseErrorKind, excerpt, in_file};
use super::{CORE, MATERIALS, PRODUCTION};
use crate::mesh::DVec3;

/// The ids of resources and objects in all parts, numbered. The specification asks for whole numbers; some
/// programs write words.
#[derive(Default)]
pub(super) struct Ids {
    texts: Vec<String>,
    numbers: HashMap<String, u32>,
}

impl Ids {
    fn number(&mut self, text: &str) -> u32 {
        let text = text.trim();
        if let Some(&number) = self.numbers.get(text) {
            return number;
        }
        let number = self.texts.len() as u32;
        self.texts.push(text.to_owned());
        self.numbers.insert(text.to_owned(), number);
        number
    }

    /// An id as the file has it.
    pub fn text(&self, number: u32) -> &str {
        &self.texts[number as usize]
    }
}

/// The content of a model part. Ids are numbers of [`Ids`].
#[derive(Default)]
pub(super) struct Model {
    /// `unit` of the model; empty for the default, millimetres.
    pub unit: String,
    pub metadata: Vec<[String; 2]>,
    /// Resources but objects in the order of the file.
    pub resources: Vec<Resource>,
    /// The index of each resource.
    pub of_id: HashMap<u32, usize>,
    pub objects: HashMap<u32, Object>,
    pub items: Vec<Placement>,
    /// Names of elements and attributes that are not kept.
    pub lost: BTreeSet<String>,
}

pub(super) enum Resource {
    Base(Vec<Base>),
    Colors {
        colors: Vec<[u8; 4]>,
        has_opacity: bool,
    },
    Texture {
        path: String,
        media: String,
        /// Names of the tile styles along `u` and `v`.
        tiles: [String; 2],
    },
    TextureGroup {
        texture: u32,
        coordinates: Vec<[f64; 2]>,
    },
}

/// A base material.
pub(super) struct Base {
    pub name: String,
    /// Red, green, blue and opacity.
    pub color: [u8; 4],
}

pub(super) struct Object {
    pub name: String,
    /// Names and values of the other attributes that are kept.
    pub settings: Vec<[String; 2]>,
    pub content: Content,
}

pub(super) enum Content {
    Mesh(Mesh),
    Components(Vec<Placement>),
}

#[derive(Default)]
pub(super) struct Mesh {
    pub vertices: Vec<DVec3>,
    pub triangles: Vec<Triangle>,
}

pub(super) struct Triangle {
    pub corners: [u32; 3],
    pub property: Option<Property>,
}

/// The property group of a triangle, and its entry for each corner.
#[derive(Clone, Copy)]
pub(super) struct Property {
    pub group: u32,
    pub entries: [u32; 3],
}

/// An object at a place: an item of the build, or a component.
pub(super) struct Placement {
    pub object: u32,
    /// The part with the object, if that is another one.
    pub path: Option<String>,
    pub transform: DMat4,
}

/// The attributes of objects, and those of items and components, that are read.
const OBJECT: [&[u8]; 6] = [b"id", b"name", b"type", b"partnumber", b"pid", b"pindex"];
const PLACEMENT: [&[u8]; 3] = [b"objectid", b"transform", b"path"];

/// The value of an attribute, by its name with prefix; `None` without it or if it is malformed.
pub(super) fn attribute<'a>(element: &'a BytesStart<'_>, name: &[u8]) -> Option<Cow<'a, str>> {
    let attribute = element.try_get_attribute(name).ok()??;
    attribute.normalized_value(XmlVersion::Implicit1_0).ok()
}

/// The text of a part in UTF-8, or in UTF-16 with a byte order mark.
fn text<'a>(part: &str, bytes: &'a [u8]) -> Result<Cow<'a, str>, ParseError> {
    let wide = |rest: &[u8], unit: fn([u8; 2]) -> u16| {
        let units = rest.chunks_exact(2).map(|pair| unit([pair[0], pair[1]]));
        let text: Result<String, _> = char::decode_utf16(units).collect();
        text.ok().filter(|_| rest.len().is_multiple_of(2))
    };
    let decoded = match bytes {
        [0xff, 0xfe, rest @ ..] => wide(rest, u16::from_le_bytes),
        [0xfe, 0xff, rest @ ..] => wide(rest, u16::from_be_bytes),
        _ => None,
    };
    if let Some(text) = decoded {
        return Ok(Cow::Owned(text));
    }
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    std::str::from_utf8(bytes)
        .map(Cow::Borrowed)
        .map_err(|error| {
            let at = error.valid_up_to();
            let what = format!("text that is neither UTF-8 nor UTF-16 (at byte {at})");
            let remedy = "export it with UTF-8";
            let kind = ParseErrorKind::Unsupported { what, remedy };
            in_part(part, bytes, at, kind)
        })
}

/// An error at a byte of a part.
fn in_part(part: &str, bytes: &[u8], at: usize, kind: ParseErrorKind) -> ParseError {
    let before = &bytes[..at.min(bytes.len())];
    in_file(ParseErrorKind::InPart {
        part: excerpt(part.trim_start_matches('/').as_bytes()),
        line: before.split(|&b| b == b'\n').count(),
        kind: Box::new(kind),
    })
}

fn malformed(error: &quick_xml::Error) -> ParseErrorKind {
    ParseErrorKind::invalid(format!("the XML is malformed: {error}"))
}

/// Calls `visit` with the start of each element of a part.
pub(super) fn starts(
    part: &str,
    bytes: &[u8],
    mut visit: impl FnMut(&BytesStart<'_>),
) -> Result<(), ParseError> {
    let text = text(part, bytes)?;
    let mut reader = Reader::from_str(&text);
    loop {
        match reader.read_event() {
            Ok(Event::Start(element) | Event::Empty(element)) => visit(&element),
            Ok(Event::Eof) => return Ok(()),
            Ok(_) => {}
            Err(error) => {
                let at = reader.error_position() as usize;
                return Err(in_part(part, text.as_bytes(), at, malformed(&error)));
            }
        }
    }
}

/// Reads a model part of this name.
pub(super) fn read(part: &str, bytes: &[u8], ids: &mut Ids) -> Result<Model, ParseError> {
    let text = text(part, bytes)?;
    let mut xml = Reader::from_str(&text);
    let mut parser = Parser {
        model: Model::default(),
        ids,
        is_model: false,
        depth: 0,
        metadata: None,
        object: None,
    };
    loop {
        let event = xml.read_event();
        let at = match &event {
            Ok(_) => xml.buffer_position(),
            Err(_) => xml.error_position(),
        };
        let step = match event {
            Err(error) => Err(malformed(&error)),
            Ok(Event::Start(element)) => match parser.start(&element) {
                Ok(true) => Ok(()),
                Ok(false) => match xml.read_to_end(element.name()) {
                    Ok(_) => Ok(()),
                    Err(error) => Err(malformed(&error)),
                },
                Err(kind) => Err(kind),
            },
            Ok(Event::Empty(element)) => match parser.start(&element) {
                Ok(true) => parser.end(element.local_name().as_ref()),
                Ok(false) => Ok(()),
                Err(kind) => Err(kind),
            },
            Ok(Event::End(element)) => parser.end(element.local_name().as_ref()),
            Ok(Event::Text(text)) => {
                parser.text(&text.xml10_content().unwrap_or_default());
                Ok(())
            }
            Ok(Event::CData(text)) => {
                parser.text(&text.xml10_content().unwrap_or_default());
                Ok(())
            }
            Ok(Event::GeneralRef(name)) => {
                let character = name.resolve_char_ref().ok().flatten();
                let name = name.decode().unwrap_or_default();
                let known = quick_xml::escape::resolve_predefined_entity(&name);
                match (character, known) {
                    (Some(character), _) => parser.text(character.encode_utf8(&mut [0; 4])),
                    (None, known) => parser.text(known.unwrap_or_default()),
                }
                Ok(())
            }
            Ok(Event::Eof) => break,
            Ok(_) => Ok(()),
        };
        step.map_err(|kind| in_part(part, text.as_bytes(), at as usize, kind))?;
    }
    if !parser.is_model {
        let (format, found) = ("3MF", "XML without an element 'model'".to_owned());
        let kind = ParseErrorKind::NotThisFormat { format, found };
        return Err(in_part(part, text.as_bytes(), 0, kind));
    }
    if parser.depth > 0 {
        let kind = ParseErrorKind::truncated("its elements do not end");
        return Err(in_part(part, text.as_bytes(), text.len(), kind));
    }
    Ok(parser.model)
}

/// The model as far as it is read, and what is open.
struct Parser<'a> {
    model: Model,
    ids: &'a mut Ids,
    is_model: bool,
    /// Open elements.
    depth: usize,
    /// The open metadata and its text.
    metadata: Option<[String; 2]>,
    object: Option<OpenObject>,
}

struct OpenObject {
    id: u32,
    property: Option<Property>,
    object: Object,
}

impl Parser<'_> {
    /// Reads the start of an element. Returns whether its content matters; otherwise it has no end here.
    fn start(&mut self, element: &BytesStart<'_>) -> Result<bool, ParseErrorKind> {
        match element.local_name().as_ref() {
            // the frequent ones first
            b"vertex" => self.vertex(element)?,
            b"triangle" => self.triangle(element)?,
            b"tex2coord" => {
                let u = number(element, b"u")?;
                let v = number(element, b"v")?;
                if let Some(Resource::TextureGroup { coordinates, .. }) =
                    self.model.resources.last_mut()
                {
                    coordinates.push([u, v]);
                }
            }
            b"color" => {
                let (color, opacity) = color(element, b"color")?;
                if let Some(Resource::Colors {
                    colors,
                    has_opacity,
                }) = self.model.resources.last_mut()
                {
                    colors.push(color);
                    *has_opacity |= opacity;
                }
            }
            b"base" => {
                let name = attribute(element, b"name").unwrap_or_default().into_owned();
                let (color, _) = color(element, b"displaycolor")?;
                if let Some(Resource::Base(list)) = self.model.resources.last_mut() {
                    list.push(Base { name, color });
                }
            }
            b"model" => {
                self.is_model = true;
                check_extensions(element)?;
                let unit = attribute(element, b"unit").unwrap_or_default();
                self.model.unit = unit.into_owned();
            }
            b"metadata" => {
                let name = attribute(element, b"name").unwrap_or_default();
                // those of objects, and those with a namespace, are not kept
                if self.object.is_some() || name.is_empty() || name.contains(':') {
                    self.model.lost.insert(format!("metadata {name}"));
                    return Ok(false);
                }
                self.metadata = Some([name.into_owned(), String::new()]);
            }
            b"basematerials" => self.resource(element, Resource::Base(Vec::new()))?,
            b"colorgroup" => {
                let (colors, has_opacity) = (Vec::new(), false);
                self.resource(
                    element,
                    Resource::Colors {
                        colors,
                        has_opacity,
                    },
                )?;
            }
            b"texture2d" => {
                let text = |name| attribute(element, name).unwrap_or_default().into_owned();
                let (path, media) = (text(b"path"), text(b"contenttype"));
                let tiles = [text(b"tilestyleu"), text(b"tilestylev")];
                self.resource(element, Resource::Texture { path, media, tiles })?;
            }
            b"texture2dgroup" => {
                let (texture, coordinates) = (self.id(element, b"texid")?, Vec::new());
                let group = Resource::TextureGroup {
                    texture,
                    coordinates,
                };
                self.resource(element, group)?;
            }
            b"object" => self.open_object(element)?,
            b"components" => {
                if let Some(open) = &mut self.object {
                    open.object.content = Content::Components(Vec::new());
                }
            }
            b"component" => {
                let component = self.placement(element)?;
                self.note_others(element, &PLACEMENT);
                if let Some(OpenObject {
                    object:
                        Object {
                            content: Content::Components(list),
                            ..
                        },
                    ..
                }) = &mut self.object
                {
                    list.push(component);
                }
            }
            b"item" => {
                let item = self.placement(element)?;
                self.model.items.push(item);
                self.note_others(element, &PLACEMENT);
            }
            b"build" => self.note_others(element, &[]),
            b"mesh" | b"vertices" | b"triangles" | b"resources" | b"metadatagroup" => {}
            other => {
                let name = excerpt(element.name().as_ref());
                // those around a model are no part of it
                if self.is_model && !other.is_empty() {
                    self.model.lost.insert(name);
                }
                return Ok(false);
            }
        }
        self.depth += 1;
        Ok(true)
    }

    fn end(&mut self, name: &[u8]) -> Result<(), ParseErrorKind> {
        self.depth = self.depth.saturating_sub(1);
        match name {
            b"metadata" => self.model.metadata.extend(self.metadata.take()),
            b"object" => {
                if let Some(open) = self.object.take()
                    && self.model.objects.insert(open.id, open.object).is_some()
                {
                    let what = format!("two objects have the id {}", self.ids.text(open.id));
                    return Err(ParseErrorKind::invalid(what));
                }
            }
            _ => {}
        }
        Ok(())
    }

    fn text(&mut self, text: &str) {
        if let Some([_, value]) = &mut self.metadata {
            value.push_str(text);
        }
    }

    fn resource(
        &mut self,
        element: &BytesStart<'_>,
        resource: Resource,
    ) -> Result<(), ParseErrorKind> {
        let id = self.id(element, b"id")?;
        self.model.of_id.insert(id, self.model.resources.len());
        self.model.resources.push(resource);
        Ok(())
    }

    fn open_object(&mut self, element: &BytesStart<'_>) -> Result<(), ParseErrorKind> {
        let id = self.id(element, b"id")?;
        let property = match attribute(element, b"pid") {
            Some(_) => {
                let entry = match attribute(element, b"pindex") {
                    Some(_) => index(element, b"pindex")?,
                    None => 0,
                };
                Some(Property {
                    group: self.id(element, b"pid")?,
                    entries: [entry; 3],
                })
            }
            None => None,
        };
        let setting = |name: &str| {
            let value = attribute(element, name.as_bytes())?.into_owned();
            let is_default = name == "type" && value == "model";
            (!is_default).then(|| [name.to_owned(), value])
        };
        let settings = ["type", "partnumber"]
            .into_iter()
            .filter_map(setting)
            .collect();
        self.note_others(element, &OBJECT);
        self.object = Some(OpenObject {
            id,
            property,
            object: Object {
                name: attribute(element, b"name").unwrap_or_default().into_owned(),
                settings,
                content: Content::Mesh(Mesh::default()),
            },
        });
        Ok(())
    }

    /// The number of the id in an attribute.
    fn id(&mut self, element: &BytesStart<'_>, name: &[u8]) -> Result<u32, ParseErrorKind> {
        let text = attribute(element, name).ok_or_else(|| missing(element, name))?;
        Ok(self.ids.number(&text))
    }

    /// An item or a component.
    fn placement(&mut self, element: &BytesStart<'_>) -> Result<Placement, ParseErrorKind> {
        let mut path = None;
        for attribute in element.attributes().with_checks(false).flatten() {
            if attribute.key.local_name().as_ref() == b"path" {
                let text = attribute.normalized_value(XmlVersion::Implicit1_0);
                path = text.ok().map(Cow::into_owned);
            }
        }
        let transform = match attribute(element, b"transform") {
            Some(text) => matrix(&text).ok_or_else(|| {
                ParseErrorKind::syntax("a transform has twelve numbers", excerpt(text.as_bytes()))
            })?,
            None => DMat4::IDENTITY,
        };
        Ok(Placement {
            object: self.id(element, b"objectid")?,
            path,
            transform,
        })
    }

    /// Notes the attributes of an element that are not kept, all but `known`.
    fn note_others(&mut self, element: &BytesStart<'_>, known: &[&[u8]]) {
        for attribute in element.attributes().with_checks(false).flatten() {
            let name = attribute.key.local_name();
            if name.as_ref() == b"UUID" {
                self.model.lost.insert("UUIDs".to_owned());
            } else if !known.contains(&name.as_ref()) {
                let (element, name) = (element.local_name(), excerpt(name.as_ref()));
                let element = excerpt(element.as_ref());
                self.model.lost.insert(format!("{element} {name}"));
            }
        }
    }

    /// The mesh of the open object.
    fn mesh(&mut self) -> Result<(&mut Mesh, Option<Property>), ParseErrorKind> {
        match &mut self.object {
            Some(OpenObject {
                property,
                object:
                    Object {
                        content: Content::Mesh(mesh),
                        ..
                    },
                ..
            }) => Ok((mesh, *property)),
            _ => Err(ParseErrorKind::invalid(
                "there is a vertex or a triangle outside a mesh",
            )),
        }
    }

    fn vertex(&mut self, element: &BytesStart<'_>) -> Result<(), ParseErrorKind> {
        let (mesh, _) = self.mesh()?;
        let vertex = mesh.vertices.len() + 1;
        let mut place = [None; 3];
        for attribute in element.attributes().with_checks(false) {
            let attribute = attribute.map_err(|error| malformed(&error.into()))?;
            let axis = match attribute.key.as_ref() {
                b"x" => 0,
                b"y" => 1,
                b"z" => 2,
                _ => continue,
            };
            let value = &attribute.value[..];
            let number = parsed(value).ok_or_else(|| not_a_number(["x", "y", "z"][axis], value))?;
            if !number.is_finite() {
                let (axis, found) = (['x', 'y', 'z'][axis], excerpt(value));
                return Err(ParseErrorKind::NotFinite {
                    vertex,
                    axis,
                    found,
                });
            }
            place[axis] = Some(number);
        }
        let [Some(x), Some(y), Some(z)] = place else {
            let found = place.iter().flatten().count();
            let wanted = "the attributes x, y and z";
            return Err(ParseErrorKind::VertexNumbers {
                vertex,
                found,
                wanted,
            });
        };
        mesh.vertices.push(DVec3::new(x, y, z));
        Ok(())
    }

    fn triangle(&mut self, element: &BytesStart<'_>) -> Result<(), ParseErrorKind> {
        let (mut corners, mut entries, mut group) = ([None; 3], [None; 3], None);
        let mut lost = Vec::new();
        for attribute in element.attributes().with_checks(false) {
            let attribute = attribute.map_err(|error| malformed(&error.into()))?;
            let slot = match attribute.key.as_ref() {
                b"v1" => &mut corners[0],
                b"v2" => &mut corners[1],
                b"v3" => &mut corners[2],
                b"p1" => &mut entries[0],
                b"p2" => &mut entries[1],
                b"p3" => &mut entries[2],
                b"pid" => {
                    let text = attribute.normalized_value(XmlVersion::Implicit1_0);
                    group = Some(self.ids.number(&text.unwrap_or_default()));
                    continue;
                }
                other => {
                    lost.push(format!("triangle {}", excerpt(other)));
                    continue;
                }
            };
            *slot = Some(whole(attribute.key.as_ref(), &attribute.value)?);
        }
        for name in lost {
            self.model.lost.insert(name);
        }
        let (mesh, property) = self.mesh()?;
        let face = mesh.triangles.len() + 1;
        let [Some(a), Some(b), Some(c)] = corners else {
            let found = corners.iter().flatten().count();
            let cut = false;
            return Err(ParseErrorKind::FewCorners { face, found, cut });
        };
        let vertices = mesh.vertices.len();
        for corner in [a, b, c] {
            if corner as usize >= vertices {
                let (found, first) = (i64::from(corner), 0);
                return Err(ParseErrorKind::IndexRange {
                    face,
                    found,
                    vertices,
                    first,
                });
            }
        }
        let property = match (group.or(property.map(|p| p.group)), entries[0]) {
            (Some(group), Some(first)) => Some(Property {
                group,
                entries: [
                    first,
                    entries[1].unwrap_or(first),
                    entries[2].unwrap_or(first),
                ],
            }),
            _ => property,
        };
        mesh.triangles.push(Triangle {
            corners: [a, b, c],
            property,
        });
        Ok(())
    }
}

/// Refuses extensions that the model requires and that change its meshes.
fn check_extensions(element: &BytesStart<'_>) -> Result<(), ParseErrorKind> {
    let required = attribute(element, b"requiredextensions").unwrap_or_default();
    for prefix in required.split_whitespace() {
        let namespace = attribute(element, format!("xmlns:{prefix}").as_bytes());
        let known = [CORE, MATERIALS, PRODUCTION];
        if namespace
            .as_deref()
            .is_none_or(|name| !known.contains(&name))
        {
            let name = namespace.unwrap_or_else(|| prefix.into());
            let what = format!(
                "a 3MF file that requires the extension {}",
                excerpt(
                    name.rsplit("3dmanufacturing/")
                        .next()
                        .unwrap_or(&name)
                        .as_bytes()
                )
            );
            let remedy = "export it without this extension";
            return Err(ParseErrorKind::Unsupported { what, remedy });
        }
    }
    Ok(())
}

fn parsed(text: &[u8]) -> Option<f64> {
    std::str::from_utf8(text.trim_ascii()).ok()?.parse().ok()
}

fn not_a_number(what: &str, found: &[u8]) -> ParseErrorKind {
    let (what, found) = (what.to_owned(), excerpt(found));
    ParseErrorKind::NotANumber { what, found }
}

fn missing(element: &BytesStart<'_>, name: &[u8]) -> ParseErrorKind {
    ParseErrorKind::invalid(format!(
        "the element '{}' has no attribute '{}'",
        excerpt(element.name().as_ref()),
        excerpt(name)
    ))
}

/// A finite number.
fn number(element: &BytesStart<'_>, name: &[u8]) -> Result<f64, ParseErrorKind> {
    let text = attribute(element, name).ok_or_else(|| missing(element, name))?;
    let number = parsed(text.as_bytes()).filter(|number| number.is_finite());
    number.ok_or_else(|| not_a_number(&excerpt(name), text.as_bytes()))
}

/// An index.
fn index(element: &BytesStart<'_>, name: &[u8]) -> Result<u32, ParseErrorKind> {
    let text = attribute(element, name).ok_or_else(|| missing(element, name))?;
    whole(name, text.as_bytes())
}

fn whole(name: &[u8], text: &[u8]) -> Result<u32, ParseErrorKind> {
    let number = std::str::from_utf8(text.trim_ascii()).ok();
    let number = number.and_then(|number| number.parse().ok());
    number.ok_or_else(|| not_a_number(&format!("the index {}", excerpt(name)), text))
}

/// A colour such as `#FF8000` or `#FF8000CC`, and whether it has an opacity.
fn color(element: &BytesStart<'_>, name: &[u8]) -> Result<([u8; 4], bool), ParseErrorKind> {
    let text = attribute(element, name).ok_or_else(|| missing(element, name))?;
    let digits = text.trim().strip_prefix('#').unwrap_or_default();
    let is_hex = digits.bytes().all(|digit| digit.is_ascii_hexdigit());
    let byte = |k: usize| u8::from_str_radix(digits.get(2 * k..2 * k + 2)?, 16).ok();
    let is_long = digits.len() == 8;
    let opacity = if is_long { byte(3) } else { Some(255) };
    match [byte(0), byte(1), byte(2), opacity] {
        [Some(r), Some(g), Some(b), Some(a)] if is_hex && (is_long || digits.len() == 6) => {
            Ok(([r, g, b, a], is_long))
        }
        _ => {
            let what = "a colour needs six or eight digits, as in #FF8000";
            Err(ParseErrorKind::syntax(what, excerpt(text.as_bytes())))
        }
    }
}

/// The matrix of a transform, whose twelve numbers are the columns of its linear part, then the
/// translation.
fn matrix(text: &str) -> Option<DMat4> {
    let mut numbers = [0.0; 12];
    let mut words = text.split_whitespace();
    for number in &mut numbers {
        *number = words.next()?.parse().ok().filter(|x: &f64| x.is_finite())?;
    }
    let column = |k: usize| DVec3::from_slice(&numbers[3 * k..3 * k + 3]);
    let matrix = DMat4::from_cols(
        column(0).extend(0.0),
        column(1).extend(0.0),
        column(2).extend(0.0),
        column(3).extend(1.0),
    );
    words.next().is_none().then_some(matrix)
}

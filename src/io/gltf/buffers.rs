//! Buffers of a glTF file and the numbers in them. Sizes are checked before anything is allocated.

use std::borrow::Cow;
use std::fmt::Write as _;
use std::fs::File;
use std::io::Read as _;
use std::path::Path;

use base64::Engine as _;
use base64::alphabet::STANDARD;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};

use super::super::error::{ParseError, ParseErrorKind, excerpt, in_file, no_memory};
use super::schema::{Root, Sparse};
use super::{BYTE, COMPRESSIONS, DATA, FLOAT, SHORT, UNSIGNED_BYTE, UNSIGNED_INT, UNSIGNED_SHORT};
use crate::memory;
use crate::mesh::NumberType;

/// Base64 with or without padding, which some programs omit.
const BASE64: GeneralPurpose = GeneralPurpose::new(
    &STANDARD,
    GeneralPurposeConfig::new().with_decode_padding_mode(DecodePaddingMode::Indifferent),
);

/// An error of the file as a whole.
pub(super) fn invalid(what: impl Into<String>) -> ParseError {
    in_file(ParseErrorKind::invalid(what))
}

/// The buffers of a file.
pub(super) struct Buffers<'a> {
    root: &'a Root,
    /// `None` for a buffer without data, as compression leaves them.
    data: Vec<Option<Cow<'a, [u8]>>>,
}

impl<'a> Buffers<'a> {
    /// Loads all buffers: the chunk of a binary file, data URIs, and files in `folder`.
    ///
    /// # Errors
    /// A buffer is missing or shorter than it declares.
    pub fn load(
        root: &'a Root,
        chunk: Option<&'a [u8]>,
        folder: Option<&Path>,
    ) -> Result<Self, ParseError> {
        let mut data = Vec::new();
        for (k, buffer) in root.buffers.iter().enumerate() {
            let wanted = buffer.byte_length;
            let found: Option<Cow<'a, [u8]>> = match (&buffer.uri, chunk) {
                (Some(uri), _) => Some(fetch(uri, k, wanted, folder)?.into()),
                (None, Some(chunk)) if k == 0 => Some(chunk.into()),
                (None, _) => None,
            };
            if let Some(found) = &found
                && (found.len() as u64) < wanted
            {
                let what = format!("buffer {k} has {} bytes instead of {wanted}", found.len());
                return Err(in_file(ParseErrorKind::truncated(what)));
            }
            data.push(found);
        }
        Ok(Self { root, data })
    }

    /// Size of all buffers in bytes.
    pub fn size(&self) -> usize {
        self.data.iter().flatten().map(|data| data.len()).sum()
    }

    /// The error for data that is not in the file.
    pub fn missing(&self, what: &str) -> ParseError {
        let mut used = self.root.extensions_used.iter();
        match used.find(|name| COMPRESSIONS.contains(&name.as_str())) {
            Some(name) => compressed(name),
            None => invalid(format!("{what} has no data")),
        }
    }

    /// The bytes of a buffer view.
    ///
    /// # Errors
    /// The view does not exist, has no data, or exceeds its buffer.
    pub fn view(&self, index: usize, what: &str) -> Result<&[u8], ParseError> {
        let view = self.root.buffer_views.get(index);
        let view = view.ok_or_else(|| invalid(format!("{what} has no buffer view")))?;
        let data = self.data.get(view.buffer);
        let data = data.ok_or_else(|| invalid(format!("{what} has no buffer")))?;
        let data = data.as_deref().ok_or_else(|| self.missing(what))?;
        let start = view.byte_offset;
        part(data, start, view.byte_length).ok_or_else(|| {
            let (length, size) = (view.byte_length, data.len());
            invalid(format!(
                "the buffer view of {what} has {length} bytes from byte {start} on, but the buffer has \
                 {size}"
            ))
        })
    }

    /// The elements of an accessor of one of the shapes `wanted`, up to `VEC4`.
    ///
    /// # Errors
    /// The accessor does not exist, is of another type, or exceeds its buffer view.
    pub fn elements(
        &self,
        index: usize,
        wanted: &[&str],
        what: &str,
    ) -> Result<Elements<'_>, ParseError> {
        let accessor = self.root.accessors.get(index);
        let accessor = accessor.ok_or_else(|| invalid(format!("{what} has no accessor")))?;
        let kind = number_type(accessor.component_type);
        let kind = kind.ok_or_else(|| invalid(format!("{what} has numbers of an unknown type")))?;
        let shape = accessor.shape.as_str();
        if !wanted.contains(&shape) {
            let found = excerpt(shape.as_bytes());
            let wanted = wanted.join(" or ");
            return Err(invalid(format!("{what} is '{found}' instead of {wanted}")));
        }
        let width = match shape {
            "SCALAR" => 1,
            "VEC2" => 2,
            "VEC3" => 3,
            _ => 4,
        };
        let (count, of_type) = (accessor.count, ElementType { kind, width, what });
        let mut elements = match (accessor.buffer_view, &accessor.sparse) {
            (Some(view), _) => self.stored(view, accessor.byte_offset, count, &of_type)?,
            (None, Some(_)) => zeros(count, &of_type)?,
            (None, None) => return Err(self.missing(what)),
        };
        if let Some(sparse) = &accessor.sparse {
            self.replace(&mut elements, sparse, &of_type)?;
        }
        elements.is_normalized = accessor.normalized;
        Ok(elements)
    }

    /// `count` elements in a buffer view from byte `start` of it on.
    fn stored(
        &self,
        view: usize,
        start: u64,
        count: u64,
        of_type: &ElementType<'_>,
    ) -> Result<Elements<'_>, ParseError> {
        let ElementType { kind, width, what } = of_type;
        let bytes = self.view(view, what)?;
        let size = kind.size() * width;
        let stride = self.root.buffer_views[view].byte_stride;
        let stride = stride.unwrap_or(size);
        let length = match count.checked_sub(1) {
            Some(gaps) => gaps.checked_mul(stride as u64),
            None => return Err(invalid(format!("{what} has no elements"))),
        };
        let length = length.and_then(|length| length.checked_add(size as u64));
        let data = length.and_then(|length| part(bytes, start, length));
        let (Some(bytes), true) = (data, stride >= size) else {
            return Err(invalid(format!(
                "{what} has {count} elements from byte {start} on, {stride} bytes apart, but its buffer \
                 view has {} bytes",
                bytes.len()
            )));
        };
        Ok(Elements::new(bytes.into(), count, stride, of_type))
    }

    /// Replaces the elements that a sparse accessor lists.
    fn replace(
        &self,
        elements: &mut Elements<'_>,
        sparse: &Sparse,
        of_type: &ElementType<'_>,
    ) -> Result<(), ParseError> {
        let (count, what) = (sparse.count, of_type.what);
        let (indices, values) = (&sparse.indices, &sparse.values);
        let kind = number_type(indices.component_type)
            .ok_or_else(|| invalid(format!("{what} has sparse indices of an unknown type")))?;
        let width = 1;
        let places = ElementType { kind, width, what };
        let places = self.stored(indices.buffer_view, indices.byte_offset, count, &places)?;
        let values = self.stored(values.buffer_view, values.byte_offset, count, of_type)?;
        let size = of_type.kind.size() * of_type.width;
        for k in 0..places.count {
            let place = places.index(k).map(|place| place as usize);
            let place = place
                .filter(|&place| place < elements.count)
                .ok_or_else(|| {
                    let count = elements.count;
                    invalid(format!(
                        "a sparse index of {what} exceeds its {count} elements"
                    ))
                })?;
            let (to, from) = (place * elements.stride, k * values.stride);
            elements.bytes.to_mut()[to..to + size]
                .copy_from_slice(&values.bytes[from..from + size]);
        }
        Ok(())
    }
}

/// The type of the elements of an accessor, and its name in messages.
struct ElementType<'a> {
    kind: NumberType,
    width: usize,
    what: &'a str,
}

/// `count` elements of zeros.
///
/// # Errors
/// They do not fit into the memory.
fn zeros(count: u64, of_type: &ElementType<'_>) -> Result<Elements<'static>, ParseError> {
    let ElementType { kind, width, what } = of_type;
    let stride = kind.size() * width;
    let what = format!("{what} with {count} elements");
    memory::require(count as f64 * stride as f64).map_err(|error| no_memory(&what, &error))?;
    // where the free memory is unknown
    let size = usize::try_from(count)
        .ok()
        .and_then(|count| count.checked_mul(stride));
    let mut bytes = Vec::new();
    let reserved = bytes.try_reserve_exact(size.unwrap_or(usize::MAX));
    reserved.map_err(|error| no_memory(&what, &error))?;
    bytes.resize(size.unwrap_or_default(), 0);
    Ok(Elements::new(bytes.into(), count, stride, of_type))
}

fn number_type(component_type: u64) -> Option<NumberType> {
    Some(match u32::try_from(component_type).ok()? {
        BYTE => NumberType::I8,
        UNSIGNED_BYTE => NumberType::U8,
        SHORT => NumberType::I16,
        UNSIGNED_SHORT => NumberType::U16,
        UNSIGNED_INT => NumberType::U32,
        FLOAT => NumberType::F32,
        _ => return None,
    })
}

/// The error for a compressed file.
pub(super) fn compressed(extension: &str) -> ParseError {
    let what = format!("a compressed glTF file ({extension})");
    let remedy = "export it without compression";
    in_file(ParseErrorKind::Unsupported { what, remedy })
}

/// A part of a list of bytes, if it is inside.
fn part(bytes: &[u8], start: u64, length: u64) -> Option<&[u8]> {
    let end = usize::try_from(start.checked_add(length)?).ok()?;
    bytes.get(usize::try_from(start).ok()?..end)
}

/// The data in a data URI; `None` if it is not base64.
pub(super) fn decoded(uri: &str) -> Option<Vec<u8>> {
    let (_, text) = uri.strip_prefix(DATA)?.split_once(";base64,")?;
    BASE64.decode(text).ok()
}

/// The data of buffer `k` at `uri`, of `wanted` bytes.
fn fetch(uri: &str, k: usize, wanted: u64, folder: Option<&Path>) -> Result<Vec<u8>, ParseError> {
    if uri.starts_with(DATA) {
        return decoded(uri).ok_or_else(|| invalid(format!("the URI of buffer {k} is not base64")));
    }
    let unsupported =
        |what: String, remedy| Err(in_file(ParseErrorKind::Unsupported { what, remedy }));
    let name = unescaped(uri);
    let Some(folder) = folder else {
        let what = format!("buffer {k} in another file ('{name}')");
        return unsupported(what, "export the mesh as .glb");
    };
    if uri.contains("://") || Path::new(&name).is_absolute() {
        let what = format!("buffer {k} at '{name}'");
        return unsupported(
            what,
            "put the file beside the mesh and refer to it by its name",
        );
    }
    let failed = |reason: String| {
        let what = format!("the file '{name}' of buffer {k} cannot be read ({reason})");
        let remedy = "copy it to its place beside the mesh";
        in_file(ParseErrorKind::Unavailable { what, remedy })
    };
    let path = folder.join(&name);
    let metadata = std::fs::metadata(&path).map_err(|error| failed(error.to_string()))?;
    if !metadata.is_file() {
        return Err(failed("not a file".to_owned()));
    }
    if metadata.len() < wanted {
        return Err(failed(format!(
            "it has {} bytes instead of {wanted}",
            metadata.len()
        )));
    }
    let mut data = Vec::new();
    File::open(&path)
        .and_then(|file| file.take(wanted).read_to_end(&mut data))
        .map_err(|error| failed(error.to_string()))?;
    Ok(data)
}

/// A relative URI as a path: `%20` and the like are bytes of the name.
pub(super) fn unescaped(uri: &str) -> String {
    let mut bytes = Vec::with_capacity(uri.len());
    let mut rest = uri.as_bytes();
    while let Some((&first, after)) = rest.split_first() {
        let digits = after
            .get(..2)
            .and_then(|digits| str::from_utf8(digits).ok());
        let escaped = digits.and_then(|digits| u8::from_str_radix(digits, 16).ok());
        match escaped {
            Some(byte) if first == b'%' => {
                bytes.push(byte);
                rest = &after[2..];
            }
            _ => {
                bytes.push(first);
                rest = after;
            }
        }
    }
    String::from_utf8_lossy(&bytes).into_owned()
}

/// A path as a relative URI: the inverse of [`unescaped`].
pub(super) fn escaped(path: &str) -> String {
    let mut uri = String::new();
    for byte in path.bytes() {
        if byte.is_ascii_alphanumeric() || b"-._~/".contains(&byte) {
            uri.push(char::from(byte));
        } else {
            // writing to a string cannot fail
            let _ = write!(uri, "%{byte:02X}");
        }
    }
    uri
}

/// The elements of an accessor, in place unless it is sparse.
pub(super) struct Elements<'a> {
    bytes: Cow<'a, [u8]>,
    pub count: usize,
    /// Numbers of an element.
    pub width: usize,
    stride: usize,
    kind: NumberType,
    is_normalized: bool,
}

impl<'a> Elements<'a> {
    fn new(bytes: Cow<'a, [u8]>, count: u64, stride: usize, of_type: &ElementType<'_>) -> Self {
        Self {
            bytes,
            count: count as usize,
            width: of_type.width,
            stride,
            kind: of_type.kind,
            is_normalized: false,
        }
    }

    /// The bytes of number `k` of an element.
    fn at<const SIZE: usize>(&self, element: usize, k: usize) -> [u8; SIZE] {
        let start = element * self.stride + k * SIZE;
        let mut bytes = [0; SIZE];
        bytes.copy_from_slice(&self.bytes[start..start + SIZE]);
        bytes
    }

    /// Number `k` of an element; a normalized integer as its part of the full range.
    #[inline]
    pub fn number(&self, element: usize, k: usize) -> f32 {
        let (number, full) = match self.kind {
            NumberType::F32 => return f32::from_le_bytes(self.at(element, k)),
            NumberType::I8 => (f32::from(i8::from_le_bytes(self.at(element, k))), 127.0),
            NumberType::U8 => (f32::from(u8::from_le_bytes(self.at(element, k))), 255.0),
            NumberType::I16 => (f32::from(i16::from_le_bytes(self.at(element, k))), 32767.0),
            NumberType::U16 => (f32::from(u16::from_le_bytes(self.at(element, k))), 65535.0),
            _ => return u32::from_le_bytes(self.at(element, k)) as f32,
        };
        if self.is_normalized {
            (number / full).max(-1.0)
        } else {
            number
        }
    }

    /// The first numbers of an element.
    #[inline]
    pub fn numbers<const N: usize>(&self, element: usize) -> [f32; N] {
        std::array::from_fn(|k| self.number(element, k))
    }

    /// An element as an index; `None` if it is no unsigned integer.
    #[inline]
    pub fn index(&self, element: usize) -> Option<u32> {
        match self.kind {
            NumberType::U8 => Some(u8::from_le_bytes(self.at(element, 0)).into()),
            NumberType::U16 => Some(u16::from_le_bytes(self.at(element, 0)).into()),
            NumberType::U32 => Some(u32::from_le_bytes(self.at(element, 0))),
            _ => None,
        }
    }
}

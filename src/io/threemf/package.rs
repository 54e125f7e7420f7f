//! The parts of the archive.

use std::borrow::Cow;
use std::collections::BTreeSet;
use std::io::{Cursor, Read as _};

use zip::ZipArchive;
use zip::result::ZipError;

use super::super::error::{ParseError, ParseErrorKind, excerpt, in_file};
use super::model::{attribute, starts};
use super::{MODEL_RELATION, RELATIONS};
use crate::memory::free_memory;

/// Text of meshes compresses to a tenth, and hardly to a fiftieth of its size. What is larger was made to
/// fill the memory.
const LARGEST_RATIO: u64 = 200;
/// The bytes before the end of the directory of an archive.
const END: &[u8] = b"PK\x05\x06";
/// What a small file may have in any case, bytes.
const ALWAYS: u64 = 1 << 20;

/// An archive with its parts.
pub(super) struct Package<'a> {
    archive: ZipArchive<Cursor<&'a [u8]>>,
    /// Bytes that parts may still have.
    left: u64,
    /// Indices of the parts that were read.
    used: BTreeSet<usize>,
}

impl<'a> Package<'a> {
    pub fn open(bytes: &'a [u8]) -> Result<Self, ParseError> {
        if bytes.is_empty() {
            return Err(in_file(ParseErrorKind::Empty));
        }
        if !bytes.starts_with(b"PK") {
            let first = excerpt(&bytes[..bytes.len().min(8)]);
            let (format, found) = ("3MF", format!("'{first}' instead of a ZIP archive"));
            return Err(in_file(ParseErrorKind::NotThisFormat { format, found }));
        }
        let archive = ZipArchive::new(Cursor::new(bytes)).map_err(|error| {
            // the directory is at the end
            let what = format!("the ZIP archive has no valid directory ({error})");
            let has_end = bytes.windows(END.len()).any(|part| part == END);
            in_file(if has_end {
                ParseErrorKind::damaged(what)
            } else {
                ParseErrorKind::truncated(what)
            })
        })?;
        let of_file = (bytes.len() as u64).saturating_mul(LARGEST_RATIO);
        let free = free_memory().unwrap_or(u64::MAX);
        Ok(Self {
            archive,
            left: of_file.max(ALWAYS).min(free),
            used: BTreeSet::new(),
        })
    }

    /// The bytes of a part; `None` if there is none of this name, which may begin with `/`.
    pub fn part(&mut self, name: &str) -> Result<Option<Vec<u8>>, ParseError> {
        let wanted = name.trim_start_matches('/');
        let Some(index) = self.index(wanted) else {
            return Ok(None);
        };
        let failed = |error: &dyn std::fmt::Display| {
            in_file(ParseErrorKind::damaged(format!(
                "the part '{}' cannot be read ({error})",
                excerpt(wanted.as_bytes())
            )))
        };
        let entry = self.archive.by_index(index).map_err(|error| match error {
            ZipError::UnsupportedArchive(_) | ZipError::CompressionMethodNotSupported(_) => {
                let what = format!("the part '{}' ({error})", excerpt(wanted.as_bytes()));
                let remedy = "export it without a password, with the usual compression";
                in_file(ParseErrorKind::Unsupported { what, remedy })
            }
            error => failed(&error),
        })?;
        let (size, left) = (entry.size(), self.left);
        let too_large = || {
            let what = format!(
                "the part '{}' has more than the {} MiB that a file of this size may have uncompressed",
                excerpt(wanted.as_bytes()),
                left >> 20
            );
            in_file(ParseErrorKind::invalid(what))
        };
        if size > left {
            return Err(too_large());
        }
        let mut bytes = Vec::new();
        if bytes.try_reserve_exact(size as usize).is_err() {
            return Err(too_large());
        }
        let mut limited = entry.take(left + 1);
        let read = limited.read_to_end(&mut bytes).map_err(|e| failed(&e))?;
        self.left = left.checked_sub(read as u64).ok_or_else(too_large)?;
        self.used.insert(index);
        Ok(Some(bytes))
    }

    /// The index of a part; names differ in more than case.
    fn index(&self, name: &str) -> Option<usize> {
        self.archive.index_for_name(name).or_else(|| {
            (0..self.archive.len()).find(|&k| {
                let other = self.archive.name_for_index(k);
                other.is_some_and(|other| other.is_ok_and(|o| o.eq_ignore_ascii_case(name)))
            })
        })
    }

    /// The name of the part with the model.
    pub fn model(&mut self) -> Result<String, ParseError> {
        let relations = self.part(RELATIONS)?.unwrap_or_default();
        let mut target = None;
        starts(RELATIONS, &relations, |element| {
            let kind = attribute(element, b"Type");
            if target.is_none() && kind.is_some_and(|kind| kind == MODEL_RELATION) {
                target = attribute(element, b"Target").map(Cow::into_owned);
            }
        })?;
        let name = target.unwrap_or_else(|| "3D/3dmodel.model".to_owned());
        if self.index(name.trim_start_matches('/')).is_none() {
            let what = format!(
                "the ZIP archive has no model, no part '{}'",
                excerpt(name.as_bytes())
            );
            return Err(in_file(ParseErrorKind::invalid(what)));
        }
        Ok(name)
    }

    /// Names of the parts that were not read, without those that every archive has.
    pub fn others(&self) -> Vec<String> {
        let unread = (0..self.archive.len()).filter(|k| !self.used.contains(k));
        let names = unread.filter_map(|k| Some(self.archive.name_for_index(k)?.ok()?.into_owned()));
        let is_frame = |name: &str| {
            let is_relations = name.contains("_rels/");
            name == "[Content_Types].xml" || is_relations || name.ends_with('/')
        };
        names.filter(|name| !is_frame(name)).collect()
    }
}

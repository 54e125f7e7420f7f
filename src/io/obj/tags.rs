//! Objects, groups, materials and smoothing groups: the tags of faces.

use std::collections::HashMap;

use crate::mesh::{FaceTag, Soup};

/// The current tag while a file is read. Faces before the first tag get an empty tag. A file
/// without tags has no face tags.
#[derive(Default)]
pub(super) struct TagRuns {
    current: FaceTag,
    index: u32,
    changed: bool,
    used: bool,
    known: HashMap<FaceTag, u32>,
}

impl TagRuns {
    /// Changes the tag of the following faces.
    pub fn change(&mut self, edit: impl FnOnce(&mut FaceTag)) {
        edit(&mut self.current);
        self.changed = true;
    }

    /// Tags the last face of `soup`.
    #[inline]
    pub fn face(&mut self, soup: &mut Soup) {
        if self.changed {
            self.look_up(soup);
        }
        if self.used {
            soup.attributes.faces.tags.push(self.index);
        }
    }

    fn look_up(&mut self, soup: &mut Soup) {
        self.changed = false;
        let before = soup.face_count() - 1;
        if !self.used && before > 0 {
            self.known.insert(FaceTag::default(), 0);
            soup.attributes.tags.push(FaceTag::default());
            soup.attributes.faces.tags.resize(before, 0);
        }
        self.used = true;
        let tags = &mut soup.attributes.tags;
        let next = tags.len() as u32;
        self.index = self.known.get(&self.current).copied().unwrap_or(next);
        if self.index == next {
            tags.push(self.current.clone());
            self.known.insert(self.current.clone(), next);
        }
    }
}

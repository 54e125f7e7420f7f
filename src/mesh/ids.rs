//! `u32` indices with separate types, so that faces and vertices cannot be confused.

use std::num::{NonZeroU32, ParseIntError};
use std::str::FromStr;

use serde::{Deserialize, Serialize};

macro_rules! id {
    ($(#[$doc:meta])* $name:ident) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        #[repr(transparent)]
        pub struct $name(pub u32);

        impl $name {
            /// The value for "none", which is never a valid index.
            pub const NONE: Self = Self(u32::MAX);

            /// The index as `usize`.
            #[inline]
            pub const fn index(self) -> usize {
                self.0 as usize
            }

            /// Whether this is a valid index.
            #[inline]
            pub const fn is_some(self) -> bool {
                self.0 != u32::MAX
            }
        }

        impl From<usize> for $name {
            #[inline]
            fn from(index: usize) -> Self {
                debug_assert!(index < u32::MAX as usize);
                Self(index as u32)
            }
        }
    };
}

id!(
    /// A vertex of a mesh.
    VertexId
);
id!(
    /// A triangle of a mesh.
    FaceId
);
id!(
    /// A directed edge; its twin is the same index with the lowest bit flipped.
    HalfedgeId
);

impl HalfedgeId {
    /// The oppositely directed half of the same edge.
    #[inline]
    #[must_use]
    pub const fn twin(self) -> Self {
        Self(self.0 ^ 1)
    }

    /// The index of the undirected edge.
    #[inline]
    pub const fn edge(self) -> usize {
        (self.0 >> 1) as usize
    }
}

/// A boundary loop of a mesh.
///
/// Texts and files contain numbers from 1. [`Self::index`] is the index in the list of
/// [`boundary_loops`](super::boundary_loops).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(transparent)]
pub struct LoopId(NonZeroU32);

impl LoopId {
    /// The first loop.
    pub const FIRST: Self = Self(NonZeroU32::MIN);

    /// Index in the list of loops, from 0.
    #[inline]
    pub const fn index(self) -> usize {
        self.0.get() as usize - 1
    }
}

impl From<usize> for LoopId {
    /// The loop at an index in the list, from 0.
    #[inline]
    fn from(index: usize) -> Self {
        Self(NonZeroU32::MIN.saturating_add(index as u32))
    }
}

impl std::fmt::Display for LoopId {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.0.fmt(f)
    }
}

impl FromStr for LoopId {
    type Err = ParseIntError;

    fn from_str(number: &str) -> Result<Self, ParseIntError> {
        number.parse().map(Self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn loops_are_written_from_one_and_stored_from_zero() {
        let third = LoopId::from(2);
        assert_eq!((third.index(), third.to_string()), (2, "3".into()));
        assert_eq!("3".parse(), Ok(third));
        assert_eq!(serde_json::to_string(&third).ok().as_deref(), Some("3"));
        assert_eq!(
            serde_json::from_str::<LoopId>("1").ok(),
            Some(LoopId::FIRST)
        );
        assert!("0".parse::<LoopId>().is_err() && serde_json::from_str::<LoopId>("0").is_err());
    }
}

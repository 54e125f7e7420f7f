//! `u32` indices with a type of their own, so that a face is never taken for a vertex.

macro_rules! id {
    ($(#[$doc:meta])* $name:ident) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        #[repr(transparent)]
        pub struct $name(pub u32);

        impl $name {
            /// The mark for "none": never a valid index.
            pub const NONE: Self = Self(u32::MAX);

            /// The index as `usize`.
            #[inline]
            pub const fn index(self) -> usize {
                self.0 as usize
            }

            /// Whether this is a real index.
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

//! Loop limit surfaces.

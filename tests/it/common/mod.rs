//! Shared parts of the integration tests: an independent reader of mesh files, the manifest of the
//! test models, true surfaces, and the judge that measures a filled mesh.
#![allow(dead_code, missing_docs)]
// indices in the files read are as the formats have them, and checked after the cast
#![allow(clippy::cast_possible_wrap, clippy::cast_sign_loss)]

#[cfg(feature = "cli")]
pub mod desk;
pub mod icosphere;
pub mod judge;
pub mod layouts;
pub mod manifest;
pub mod raw;
pub mod truth;
pub mod wait;

//! Refinement.
#![allow(warnings)]
pub mod proto;

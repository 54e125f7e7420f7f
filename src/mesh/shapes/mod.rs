//! Generators of test and demonstration surfaces; everything is a function of its arguments, so
//! the same call gives the same bits everywhere.

mod random;

pub use random::SplitMix;

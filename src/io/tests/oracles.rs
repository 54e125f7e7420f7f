//! Independent readers of the same bytes.

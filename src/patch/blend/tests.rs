//! Patches over several generated rims.

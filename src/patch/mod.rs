//! First surfaces for holes.

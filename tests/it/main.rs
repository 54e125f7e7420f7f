//! Integration tests of the library and of the program's commands, in one executable, because each
//! executable costs a link of everything. The window has its own (`tests/window`).

mod common;

mod attributes;
mod continuity;
mod dependencies;
mod fuzz;
mod invariance;
mod judge;
mod layouts;
mod mixed;
mod models_loops;
mod random_holes;
mod refine;
mod sphere_cap;

#[cfg(feature = "cli")]
mod analyze;
#[cfg(feature = "cli")]
mod batch;
#[cfg(feature = "cli")]
mod blend;
#[cfg(feature = "cli")]
mod cli;
#[cfg(feature = "cli")]
mod creases;
#[cfg(feature = "cli")]
mod joined;
#[cfg(feature = "cli")]
mod live;
#[cfg(feature = "cli")]
mod memory;
#[cfg(feature = "cli")]
mod models;
#[cfg(feature = "cli")]
mod refine_live;
#[cfg(feature = "cli")]
mod saving;
#[cfg(feature = "cli")]
mod textures;
#[cfg(feature = "cli")]
mod wild;

#[cfg(feature = "render")]
mod render;
#[cfg(all(feature = "cli", feature = "render"))]
mod render_command;
#[cfg(feature = "render")]
mod sequences;

#[cfg(feature = "window")]
mod repeat;

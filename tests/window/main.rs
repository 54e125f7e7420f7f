//! The window: its panels by their labels, and the program on a virtual display.

mod end_to_end;
mod panels;
#[path = "../it/common/wait.rs"]
mod wait;

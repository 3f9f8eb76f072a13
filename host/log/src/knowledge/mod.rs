//! What a robot has learned: in files, summed up, compared, followed.

pub mod difference;
mod file;
pub mod followed;
pub mod summary;

pub use file::{FileError, Loaded, from_bytes, load, save, to_bytes};

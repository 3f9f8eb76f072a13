//! The dashboard: what a rover, an emulated board or a log shows of itself, and the keys that
//! steer it.
//!
//! ```text
//!  Source::poll ──► Happening ──► Watch ──► model::Dashboard ──► view
//!  Source::send ◄── Command   ◄── keys, and what is asked for unbidden
//! ```
//!
//! | file | holds |
//! |---|---|
//! | `source`, `happening` | where it comes from, and what comes |
//! | `model`, `hear` | what is shown, and how what is heard changes it |
//! | `watch`, `pull`, `keys` | what is asked for |
//! | `terminal` | the loops that keep it going |
//! | `view` | the picture, one panel a file |
//! | `plain`, `json` | the same as lines, for people and for programs |
//! | `live`, `recording` | a rover at the end of a port; a log |

pub mod happening;
mod hear;
mod json;
pub mod keys;
pub mod live;
pub mod model;
pub mod plain;
mod pull;
pub mod recording;
pub mod source;
pub mod terminal;
pub mod view;
pub mod watch;

pub use happening::{Connection, Happening, Origin, Playback};
pub use source::{Control, Source};
pub use watch::Watch;

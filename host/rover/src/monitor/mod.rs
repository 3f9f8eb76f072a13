//! The dashboard: what a rover, an emulated board or a log shows of itself, and the keys that
//! steer it.
//!
//! ```text
//!  Feed::poll ──► FeedEvent ──► App ──► model::Dashboard ──► view, plain, json
//!  Feed::send ◄── Command   ◄── keys, and periodic requests
//! ```
//!
//! | file | holds |
//! |---|---|
//! | `feed` | the trait of what can be watched, and what it reports |
//! | `rover_feed`, `player` | a rover at the end of a port; a log that is played |
//! | `model`, `update` | what is shown, and how each event changes it |
//! | `app`, `knowledge_reader`, `keys` | what is requested of the rover, by itself and by keys |
//! | `terminal` | the main loops |
//! | `view` | the picture, one panel a file |
//! | `plain`, `json` | the same as lines, for people and for programs |

pub mod app;
pub mod feed;
mod json;
pub mod keys;
mod knowledge_reader;
pub mod model;
pub mod plain;
pub mod player;
pub mod rover_feed;
pub mod terminal;
mod update;
pub mod view;

pub use app::App;
pub use feed::{Connection, Control, Feed, FeedEvent, Origin, Playback};

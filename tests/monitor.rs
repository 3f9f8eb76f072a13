//! The dashboard: what it shows of a rover in this process and of a log, and what its keys do.

#[path = "monitor/anything.rs"]
mod anything;
#[path = "monitor/keys.rs"]
mod keys;
#[path = "monitor/lines.rs"]
mod lines;
#[path = "monitor/pictures.rs"]
mod pictures;
#[path = "monitor/scene.rs"]
mod scene;
#[path = "monitor/truth.rs"]
mod truth;

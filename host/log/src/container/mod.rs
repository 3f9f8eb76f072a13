//! The MCAP container (<https://mcap.dev/spec>), as far as logs need it.

pub(crate) mod reader;
pub(crate) mod writer;

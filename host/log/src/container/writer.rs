//! Writing MCAP files: JSON messages with the schemas of their types, metadata, attachments.

use std::collections::BTreeMap;
use std::io::{BufWriter, Result, Seek, Write};

use mcap::records::{MessageHeader, Metadata};
use mcap::{Attachment, McapError, WriteOptions};
use schemars::Schema;
use serde::Serialize;

use crate::format::{FORMAT, METADATA};

/// A file that is written.
pub(crate) struct Container<W: Write + Seek> {
    mcap: mcap::Writer<BufWriter<W>>,
}

/// When a message was logged and published, in nanoseconds.
#[derive(Clone, Copy)]
pub(crate) struct Times {
    pub log: u64,
    pub publish: u64,
}

impl<W: Write + Seek> Container<W> {
    /// Begins a file with metadata, to which the version of the format is added.
    pub fn begin<'a>(
        file: W,
        options: WriteOptions,
        metadata: impl IntoIterator<Item = (&'a str, String)>,
    ) -> Result<Self> {
        let options = options.compression(None).library("turing-rover");
        let mcap = options.create(BufWriter::new(file)).map_err(io_error)?;
        let mut container = Self { mcap };
        let format = ("format", FORMAT.to_string());
        container.metadata(METADATA, metadata.into_iter().chain([format]))?;
        Ok(container)
    }

    /// Writes metadata.
    pub fn metadata<'a>(
        &mut self,
        name: &str,
        pairs: impl IntoIterator<Item = (&'a str, String)>,
    ) -> Result<()> {
        let pairs = pairs.into_iter().map(|(key, value)| (key.into(), value));
        let metadata = Metadata {
            name: name.into(),
            metadata: pairs.collect(),
        };
        self.mcap.write_metadata(&metadata).map_err(io_error)
    }

    /// Adds a channel of JSON messages.
    pub fn channel(&mut self, topic: &str, name: &str, schema: &Schema) -> Result<u16> {
        let schema = serde_json::to_vec(schema)?;
        let schema = self.mcap.add_schema(name, "jsonschema", &schema);
        let schema = schema.map_err(io_error)?;
        let channel = self
            .mcap
            .add_channel(schema, topic, "json", &BTreeMap::new());
        channel.map_err(io_error)
    }

    /// Writes a message, and returns its bytes.
    pub fn message(
        &mut self,
        channel_id: u16,
        sequence: u32,
        times: Times,
        message: &impl Serialize,
    ) -> Result<Vec<u8>> {
        let data = serde_json::to_vec(message)?;
        let header = MessageHeader {
            channel_id,
            sequence,
            log_time: times.log,
            publish_time: times.publish,
        };
        let written = self.mcap.write_to_known_channel(&header, &data);
        written.map_err(io_error)?;
        Ok(data)
    }

    /// Attaches a file.
    pub fn attach(&mut self, name: &str, data: &[u8], times: Times) -> Result<()> {
        let attachment = Attachment {
            log_time: times.log,
            create_time: times.publish,
            name: name.into(),
            media_type: "application/octet-stream".into(),
            data: data.into(),
        };
        self.mcap.attach(&attachment).map_err(io_error)
    }

    /// Writes out what there is.
    pub fn flush(&mut self) -> Result<()> {
        self.mcap.flush().map_err(io_error)
    }

    /// Writes the index.
    pub fn finish(&mut self) -> Result<()> {
        self.mcap.finish().map(|_| ()).map_err(io_error)
    }

    /// The file, which is finished.
    pub fn into_inner(self) -> Result<W> {
        let file = self.mcap.into_inner().into_inner();
        file.map_err(std::io::IntoInnerError::into_error)
    }
}

fn io_error(error: McapError) -> std::io::Error {
    match error {
        McapError::Io(error) => error,
        other => std::io::Error::other(other),
    }
}

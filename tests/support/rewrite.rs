//! Logs as another tool would write them anew.

use std::io::Cursor;

use mcap::WriteOptions;

/// The log with those messages for which `change` returns true, as it leaves them, and new checksums
/// of the container. `change` is given a message's topic and text.
pub fn rewrite(log: &[u8], change: impl FnMut(&str, &mut String) -> bool) -> Vec<u8> {
    rewrite_with(WriteOptions::new(), log, change)
}

/// The same with options of the container.
pub fn rewrite_with(
    options: WriteOptions,
    log: &[u8],
    mut change: impl FnMut(&str, &mut String) -> bool,
) -> Vec<u8> {
    let options = options.compression(None);
    let mut out = options.create(Cursor::new(Vec::new())).unwrap();
    for record in mcap::read::LinearReader::new(log).unwrap() {
        match record.unwrap() {
            mcap::records::Record::Metadata(metadata) => out.write_metadata(&metadata).unwrap(),
            mcap::records::Record::Attachment { header, data, .. } => out
                .attach(&mcap::Attachment {
                    log_time: header.log_time,
                    create_time: header.create_time,
                    name: header.name,
                    media_type: header.media_type,
                    data,
                })
                .unwrap(),
            _ => {}
        }
    }
    for message in mcap::MessageStream::new(log).unwrap() {
        let mut message = message.unwrap();
        let mut text = String::from_utf8(message.data.into_owned()).unwrap();
        if change(&message.channel.topic, &mut text) {
            message.data = text.into_bytes().into();
            out.write(&message).unwrap();
        }
    }
    out.finish().unwrap();
    out.into_inner().into_inner()
}

//! Changing a log's messages behind the back of its checksums.

use std::io::Cursor;

/// The log with its messages as `change` leaves them, and the checksums of the MCAP container, not
/// those within the messages, recalculated by writing everything anew. `change` is given a message's
/// topic and text.
pub fn rewrite(log: &[u8], mut change: impl FnMut(&str, &mut String)) -> Vec<u8> {
    let mut out = mcap::WriteOptions::new()
        .compression(None)
        .create(Cursor::new(Vec::new()))
        .unwrap();
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
        change(&message.channel.topic, &mut text);
        message.data = text.into_bytes().into();
        out.write(&message).unwrap();
    }
    out.finish().unwrap();
    out.into_inner().into_inner()
}

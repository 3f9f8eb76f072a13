//! Recordings: logs of what came over a rover's port, real or emulated.
//!
//! | part | holds |
//! |---|---|
//! | metadata `turing-rover` | [`Provenance`] |
//! | channels `/hello`, `/action`, `/event`, `/fault`, `/status`, `/ack`, `/last_words` | what the rover said: the messages of [`rover_shared::wire::message`], each with the number of its frame and how many frames before it were lost |
//! | channel `/command` | what the host asked for: [`Asked`], whose acknowledgement in `/ack` names its number |
//! | channels `/truth`, `/arena` | of an emulated rover only, which does not know it itself: where it was before an action ([`Truth`]), and in what arena ([`Arena`](super::arena::Arena)) |
//! | attachments `knowledge-FINGERPRINT.rover` | knowledge that was pulled from the rover |
//! | channel `/knowledge` | when it was pulled: what the rover knew at that moment |
//! | channel `/gap` | that reports are missing, and why |
//! | metadata `turing-rover-end` | how many frames came and were lost; its checksum, which names the file; missing if the recorder was killed |
//!
//! Log times are those of the host, publish times those of the rover (since its reset). Chunks are
//! written out whole, every two seconds, so that a recorder that is killed leaves a file that is
//! readable up to there. A recording may have several files, one following the other.
//!
//! | file | holds |
//! |---|---|
//! | `message` | the channels and their messages |
//! | `writer` | [`RecordingWriter`] |
//! | `reader` | [`Recording`] |

mod message;
mod reader;
mod writer;

pub use message::{Asked, Gap, Heard, LastWords, Provenance, Pulled, Topic, Truth};
pub use reader::{Recorded, Recording, What};
pub use writer::{RecordingWriter, Written};

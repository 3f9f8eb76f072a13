//! Faults of an emulated rover as data, and how a user writes them. What each one does is injected
//! elsewhere: see the [crate's documentation](crate#faults).

use std::fmt;
use std::str::FromStr;

use rover_shared::supervisor::Loop;
use thiserror::Error;

/// A range sensor.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Channel {
    /// Ahead, on the left.
    FrontLeft,
    /// Ahead, on the right.
    FrontRight,
    /// 45 degrees to the left.
    Left,
    /// 45 degrees to the right.
    Right,
}

/// One side's wheels and motors, or both sides'.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Side {
    /// The left side.
    Left,
    /// The right side.
    Right,
    /// Both sides.
    Both,
}

/// Something that goes wrong with an emulated rover. It lasts until its time is over, or for good,
/// unless it is [momentary](Self::momentary).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// A range sensor's cable breaks: the resistor to ground pulls the pin to 0 V.
    IrOpen(Channel),
    /// A range sensor's output meets its supply: the pin stays at full scale.
    IrShorted(Channel),
    /// A range sensor hangs: not one count changes any more.
    IrFrozen(Channel),
    /// A range sensor's measurements err by half a volt.
    IrNoisy(Channel),
    /// The compass does not acknowledge its address.
    CompassSilent,
    /// The compass holds the data line low.
    CompassStuck,
    /// The compass's registers hold random bytes.
    CompassGarbage,
    /// Every bearing is wrong by 90 degrees, as beside a large piece of iron.
    CompassRotated,
    /// The motors of a side get no current, and coast.
    MotorDead(Side),
    /// The wheels of a side spin without grip.
    WheelsSlipping(Side),
    /// The USB cable is pulled out, and put in again when its time is over.
    UsbUnplugged,
    /// The host keeps the port open and reads nothing.
    UsbDeaf,
    /// Random bytes arrive at the board, frames among them.
    UsbGarbageIn,
    /// Random bytes arrive at the host, frames among them.
    UsbGarbageOut,
    /// Frames to the board lose their ends.
    UsbTruncatedIn,
    /// Frames to the host lose their ends.
    UsbTruncatedOut,
    /// Erasing and programming the flash takes as long as its data sheet allows: 400 ms a sector.
    FlashSlow,
    /// The board loses its supply, for its time or 0.1 s, and starts anew; at a flash operation,
    /// in the middle of it.
    PowerCut,
    /// The supply dips as motors start: the board resets at once, the flash is left alone.
    BrownOut,
    /// One of the firmware's loops does not come back from its turn.
    TaskHang(Loop),
    /// Each turn of the control loop takes longer than its period.
    ControlOverrun,
}

/// Words of a fault, and what it is.
const SIMPLE: [(&str, Fault); 14] = [
    ("compass silent", Fault::CompassSilent),
    ("compass stuck", Fault::CompassStuck),
    ("compass garbage", Fault::CompassGarbage),
    ("compass rotated", Fault::CompassRotated),
    ("usb unplugged", Fault::UsbUnplugged),
    ("usb deaf", Fault::UsbDeaf),
    ("usb garbage in", Fault::UsbGarbageIn),
    ("usb garbage out", Fault::UsbGarbageOut),
    ("usb truncated in", Fault::UsbTruncatedIn),
    ("usb truncated out", Fault::UsbTruncatedOut),
    ("flash slow", Fault::FlashSlow),
    ("power cut", Fault::PowerCut),
    ("brown out", Fault::BrownOut),
    ("control overrun", Fault::ControlOverrun),
];

const CHANNELS: [(&str, Channel); 4] = [
    ("front left", Channel::FrontLeft),
    ("front right", Channel::FrontRight),
    ("left", Channel::Left),
    ("right", Channel::Right),
];

const SIDES: [(&str, Side); 3] = [
    ("left", Side::Left),
    ("right", Side::Right),
    ("both", Side::Both),
];

const LOOPS: [(&str, Loop); 5] = [
    ("sense", Loop::Sense),
    ("control", Loop::Control),
    ("drive", Loop::Drive),
    ("link", Loop::Link),
    ("store", Loop::Store),
];

type OfChannel = fn(Channel) -> Fault;
type OfSide = fn(Side) -> Fault;

const IR: [(&str, OfChannel); 4] = [
    ("open", Fault::IrOpen),
    ("shorted", Fault::IrShorted),
    ("frozen", Fault::IrFrozen),
    ("noisy", Fault::IrNoisy),
];

const MOTOR: [(&str, &str, OfSide); 2] = [
    ("motor", "dead", Fault::MotorDead),
    ("wheels", "slipping", Fault::WheelsSlipping),
];

/// What can be written for a fault, for help texts and errors.
pub const POSSIBLE: &str = "ir CHANNEL open|shorted|frozen|noisy (CHANNEL: front left, front \
    right, left, right), compass silent|stuck|garbage|rotated, motor SIDE dead, wheels SIDE \
    slipping (SIDE: left, right, both), usb unplugged|deaf|garbage in|garbage out|truncated \
    in|truncated out, flash slow, power cut, brown out, task NAME hang (NAME: sense, control, drive, link, \
    store), control overrun";

/// A text that is no fault.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("there is no fault \"{0}\"; possible are: {POSSIBLE}")]
pub struct UnknownFault(String);

impl Channel {
    /// All, in the order of arrays of four.
    pub const ALL: [Self; 4] = [Self::FrontLeft, Self::FrontRight, Self::Left, Self::Right];

    /// Its place in arrays of four.
    pub const fn index(self) -> usize {
        self as usize
    }
}

impl Side {
    /// Whether the left and the right side are meant.
    pub const fn includes(self) -> [bool; 2] {
        [
            matches!(self, Self::Left | Self::Both),
            matches!(self, Self::Right | Self::Both),
        ]
    }
}

impl Fault {
    /// Every fault there is.
    pub fn all() -> Vec<Self> {
        let simple = SIMPLE.iter().map(|(_, fault)| *fault);
        let ir = IR
            .iter()
            .flat_map(|(_, of)| CHANNELS.iter().map(move |(_, channel)| of(*channel)));
        let motor = MOTOR
            .iter()
            .flat_map(|(_, _, of)| SIDES.iter().map(move |(_, side)| of(*side)));
        let hang = LOOPS.iter().map(|(_, of)| Self::TaskHang(*of));
        simple.chain(ir).chain(motor).chain(hang).collect()
    }

    /// Whether the fault happens at once and does not last.
    pub const fn momentary(&self) -> bool {
        matches!(self, Self::PowerCut | Self::BrownOut)
    }
}

fn word<T: PartialEq>(of: &T, words: &[(&'static str, T)]) -> &'static str {
    words
        .iter()
        .find(|(_, value)| value == of)
        .map_or("?", |(word, _)| word)
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let ir = |channel, what| format!("ir {} {what}", word(channel, &CHANNELS));
        let text = match self {
            Self::IrOpen(channel) => ir(channel, "open"),
            Self::IrShorted(channel) => ir(channel, "shorted"),
            Self::IrFrozen(channel) => ir(channel, "frozen"),
            Self::IrNoisy(channel) => ir(channel, "noisy"),
            Self::MotorDead(side) => format!("motor {} dead", word(side, &SIDES)),
            Self::WheelsSlipping(side) => format!("wheels {} slipping", word(side, &SIDES)),
            Self::TaskHang(of) => format!("task {} hang", word(of, &LOOPS)),
            simple => word(simple, &SIMPLE).to_owned(),
        };
        f.write_str(&text)
    }
}

impl FromStr for Fault {
    type Err = UnknownFault;

    /// Words are separated by spaces, hyphens or both.
    fn from_str(text: &str) -> Result<Self, UnknownFault> {
        let unknown = || UnknownFault(text.trim().to_owned());
        let words: Vec<String> = text
            .split(|c: char| c.is_whitespace() || c == '-')
            .filter(|word| !word.is_empty())
            .map(str::to_ascii_lowercase)
            .collect();
        let all = words.join(" ");
        if let Some((_, fault)) = SIMPLE.iter().find(|(name, _)| *name == all) {
            return Ok(*fault);
        }
        let (Some((first, rest)), Some((last, _))) = (words.split_first(), words.split_last())
        else {
            return Err(unknown());
        };
        let middle = rest
            .split_last()
            .map_or(String::new(), |(_, m)| m.join(" "));
        let fault = match first.as_str() {
            "ir" => find(&middle, &CHANNELS)
                .zip(find(last, &IR))
                .map(|(channel, of)| of(channel)),
            "task" if last == "hang" => find(&middle, &LOOPS).map(Self::TaskHang),
            _ => MOTOR
                .iter()
                .find(|(part, what, _)| part == first && what == last)
                .and_then(|(_, _, of)| find(&middle, &SIDES).map(of)),
        };
        fault.ok_or_else(unknown)
    }
}

fn find<T: Copy>(text: &str, words: &[(&'static str, T)]) -> Option<T> {
    words
        .iter()
        .find(|(word, _)| *word == text)
        .map(|(_, value)| *value)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn every_fault_is_read_as_it_is_written() {
        let all = Fault::all();
        assert_eq!(all.len(), 14 + 16 + 6 + 5);
        for fault in all {
            assert_eq!(fault.to_string().parse(), Ok(fault));
            let hyphens = fault.to_string().replace(' ', "-").to_uppercase();
            assert_eq!(hyphens.parse(), Ok(fault));
        }
    }

    #[test]
    fn errors_list_what_is_possible() {
        for text in [
            "",
            "ir",
            "ir open",
            "ir middle open",
            "ir left melted",
            "motor left",
            "motor up dead",
            "motor left slipping",
            "task hang",
            "task brake hang",
            "compass",
            "usb",
            "the left wheel falls off",
        ] {
            let error = text.parse::<Fault>().expect_err(text).to_string();
            assert!(error.contains(&format!("\"{text}\"")), "{error}");
            assert!(error.contains("compass silent") && error.contains("task NAME hang"));
        }
    }

    proptest! {
        #[test]
        fn nothing_that_is_written_makes_it_panic(text in "\\PC{0,40}") {
            if let Ok(fault) = text.parse::<Fault>() {
                prop_assert_eq!(fault.to_string().parse(), Ok(fault));
            }
        }
    }
}

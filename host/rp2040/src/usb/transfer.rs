//! A control transfer as the host drives it: SETUP, data, status (USB 2.0 8.5.3).

use super::controller::Pid;

/// A control transfer under way.
#[derive(Clone, Debug)]
pub(super) struct ControlTransfer {
    setup: [u8; 8],
    /// What is sent, or what has come.
    data: Vec<u8>,
    /// How many bytes of it were sent.
    sent: usize,
    stage: Stage,
    /// Of the next data packet.
    pid: Pid,
    /// Bytes in a full packet.
    packet: usize,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stage {
    Setup,
    DataIn,
    DataOut,
    StatusIn,
    StatusOut,
}

/// What the host does next.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Step {
    /// Sends the SETUP packet.
    Setup([u8; 8]),
    /// Asks for data.
    In,
    /// Sends data.
    Out(Pid, Vec<u8>),
}

/// What a step has led to.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Progress {
    /// There is a next step.
    Going,
    /// The transfer is done; the data that came.
    Done(Vec<u8>),
    /// The device has sent a packet of this size, larger than it may.
    Babble(usize),
    /// A packet came again, which was acknowledged before.
    Repeated,
}

impl ControlTransfer {
    /// A transfer with this SETUP packet, in packets of this size; `data` is sent if it goes out.
    pub(super) fn new(setup: [u8; 8], data: Vec<u8>, packet: usize) -> Self {
        Self {
            setup,
            data,
            sent: 0,
            stage: Stage::Setup,
            pid: Pid::Data1,
            packet,
        }
    }

    /// What to do next.
    pub(super) fn step(&self) -> Step {
        match self.stage {
            Stage::Setup => Step::Setup(self.setup),
            Stage::DataIn | Stage::StatusIn => Step::In,
            Stage::DataOut => {
                let end = self.data.len().min(self.sent + self.packet);
                Step::Out(self.pid, self.data[self.sent..end].to_vec())
            }
            Stage::StatusOut => Step::Out(Pid::Data1, Vec::new()),
        }
    }

    /// The SETUP packet was acknowledged.
    pub(super) fn set_up(&mut self) -> Progress {
        let comes = self.setup[0] & 0x80 != 0;
        self.stage = match (self.wanted(), comes) {
            (0, _) => Stage::StatusIn,
            (_, true) => Stage::DataIn,
            (_, false) => Stage::DataOut,
        };
        Progress::Going
    }

    /// Data have come.
    pub(super) fn came(&mut self, pid: Pid, bytes: &[u8]) -> Progress {
        if self.stage == Stage::StatusIn {
            return match (pid, bytes.len()) {
                (Pid::Data1, 0) => Progress::Done(Vec::new()),
                (Pid::Data1, size) => Progress::Babble(size),
                (Pid::Data0, _) => Progress::Repeated,
            };
        }
        if pid != self.pid {
            return Progress::Repeated;
        }
        if bytes.len() > self.packet || self.data.len() + bytes.len() > self.wanted() {
            return Progress::Babble(bytes.len());
        }
        self.pid = self.pid.toggled();
        self.data.extend(bytes);
        if bytes.len() < self.packet || self.data.len() == self.wanted() {
            self.stage = Stage::StatusOut;
        }
        Progress::Going
    }

    /// What was to be sent was acknowledged.
    pub(super) fn went(&mut self) -> Progress {
        if self.stage == Stage::StatusOut {
            return Progress::Done(std::mem::take(&mut self.data));
        }
        self.pid = self.pid.toggled();
        self.sent = self.data.len().min(self.sent + self.packet);
        if self.sent == self.data.len() {
            self.stage = Stage::StatusIn;
        }
        Progress::Going
    }

    /// Length of the data stage, wLength.
    fn wanted(&self) -> usize {
        u16::from_le_bytes([self.setup[6], self.setup[7]]).into()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn data_come_in_packets() {
        let setup = [0x80, 6, 0, 2, 0, 0, 75, 0];
        let mut transfer = ControlTransfer::new(setup, vec![], 64);
        assert_eq!(transfer.step(), Step::Setup(setup));
        transfer.set_up();
        assert_eq!(transfer.came(Pid::Data0, &[9; 64]), Progress::Repeated);
        assert_eq!(transfer.came(Pid::Data1, &[1; 64]), Progress::Going);
        assert_eq!(transfer.step(), Step::In);
        assert_eq!(transfer.came(Pid::Data0, &[2; 12]), Progress::Babble(12));
        assert_eq!(transfer.came(Pid::Data0, &[2; 11]), Progress::Going);
        assert_eq!(transfer.step(), Step::Out(Pid::Data1, vec![]));
        let Progress::Done(data) = transfer.went() else {
            panic!("not done")
        };
        assert_eq!((data.len(), data[63], data[64]), (75, 1, 2));
    }

    #[test]
    fn a_short_packet_ends_the_data() {
        let mut transfer = ControlTransfer::new([0x80, 6, 0, 3, 0, 0, 255, 0], vec![], 8);
        transfer.set_up();
        transfer.came(Pid::Data1, &[0; 8]);
        transfer.came(Pid::Data0, &[]);
        assert_eq!(transfer.went(), Progress::Done(vec![0; 8]));
    }

    #[test]
    fn data_go_in_packets() {
        let mut transfer = ControlTransfer::new([0x21, 0x20, 0, 0, 0, 0, 9, 0], vec![7; 9], 8);
        transfer.set_up();
        assert_eq!(transfer.step(), Step::Out(Pid::Data1, vec![7; 8]));
        transfer.went();
        assert_eq!(transfer.step(), Step::Out(Pid::Data0, vec![7]));
        transfer.went();
        assert_eq!(transfer.step(), Step::In);
        assert_eq!(transfer.came(Pid::Data1, &[]), Progress::Done(vec![]));
    }

    #[test]
    fn requests_without_data_have_a_status_at_once() {
        let mut transfer = ControlTransfer::new([0, 5, 1, 0, 0, 0, 0, 0], vec![], 64);
        transfer.set_up();
        assert_eq!(transfer.came(Pid::Data1, &[1]), Progress::Babble(1));
        assert_eq!(transfer.came(Pid::Data1, &[]), Progress::Done(vec![]));
    }
}

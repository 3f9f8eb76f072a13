//! All that is learned, and its encoding: in the board's flash, in files, on the wire.
//!
//! All numbers are little-endian:
//!
//! | offset | bytes | what |
//! |---|---|---|
//! | 0 | 4 | magic, `TRVK` |
//! | 4 | 2 | version of this layout: 1 |
//! | 6 | 1 | learning rule, [`LearningRule::ID`] |
//! | 7 | 1 | bytes of rule memory per pattern, m |
//! | 8 | 4 | length of the whole, with magic and checksum |
//! | 12 | 192 | the 24 parameters, each a 64-bit float, in [`Parameters::to_array`]'s order |
//! | 204 | 4 | steps made so far |
//! | 208 | 4 | h of the sensing neurons, as a fraction of 2^32 |
//! | 212 | 160 | step amplitudes, Q20: front 0 to 9, left, right, target |
//! | 372 | 4 | number of patterns, n |
//! | 376 | n (10 + m) | each pattern: code (2), last occurrence (4), occurrences (4), rule memory (m) |
//! | 376 + n (10 + m) | 4 | CRC-32/ISO-HDLC of all before it |

use crc::{CRC_32_ISO_HDLC, Crc, Digest};

use crate::action::pattern_vector::{CAPACITY, Element, PatternVector};
use crate::learning::{LearningCoefficients, LearningRule, Memory, SensingLayer};
use crate::parameters::Parameters;
use crate::perception::PatternCode;
use crate::sensing::neuron::{Activation, STEPS, SensingNeuron};

const MAGIC: [u8; 4] = *b"TRVK";
/// Version of the layout described above.
pub const VERSION: u16 = 1;
const HEADER_SIZE: usize = 12;
const FIXED_SIZE: usize = HEADER_SIZE + 8 * Parameters::COUNT + 8 + 4 * 4 * STEPS + 4;
const CRC_SIZE: usize = 4;
/// Bytes of a pattern besides what the rule remembers.
const PATTERN_SIZE: usize = 10;
/// More than any rule's memory: room for one pattern on the stack.
const MAX_MEMORY_SIZE: usize = 32;

// A table of sixteen: 64 bytes instead of a kilobyte, and still one pass over the data per save.
static CRC: Crc<u32, crc::Table<1>> = Crc::<u32, crc::Table<1>>::new(&CRC_32_ISO_HDLC);

/// What a robot has learned; meaningful only with the [`Parameters`] it was learned with.
#[derive(Clone, Debug, PartialEq)]
pub struct Knowledge<M> {
    /// The sensing neurons and h.
    pub sensing: SensingLayer,
    /// The patterns that have occurred, and their actions.
    pub patterns: PatternVector<M, CAPACITY>,
    /// Steps so far: the time scale of occurrences.
    pub steps: u32,
}

impl<M> Knowledge<M> {
    /// Nothing learned, and width 0: for [`Knowledge::read`] to read into. All zeros, so that a
    /// static occupies none of the board's flash.
    pub const EMPTY: Self = Self {
        sensing: SensingLayer {
            neurons: [SensingNeuron::ZERO; 4],
            width: 0,
        },
        patterns: PatternVector::new(),
        steps: 0,
    };
}

impl<M> Default for Knowledge<M> {
    /// [`Knowledge::EMPTY`].
    fn default() -> Self {
        Self::EMPTY
    }
}

impl<M: Memory> Knowledge<M> {
    /// Nothing learned: all amplitudes zero, no patterns.
    pub const fn new(c: &LearningCoefficients) -> Self {
        Self {
            sensing: SensingLayer::new(c),
            patterns: PatternVector::new(),
            steps: 0,
        }
    }

    /// Replaces everything by [`new`](Self::new), in place.
    pub fn begin(&mut self, c: &LearningCoefficients) {
        self.clear();
        self.sensing = SensingLayer::new(c);
    }

    /// Number of bytes that [`write`](Self::write) writes, at most [`max_size`](Self::max_size).
    pub fn size(&self) -> usize {
        size::<M>(self.patterns.elements().len())
    }

    /// Number of bytes with a full pattern vector.
    pub const fn max_size() -> usize {
        size::<M>(CAPACITY)
    }

    /// Writes the knowledge, piece by piece, to `sink`, which may fail.
    ///
    /// # Errors
    /// The first error of `sink`.
    pub fn write<R: LearningRule<Memory = M>, E>(
        &self,
        parameters: &Parameters,
        sink: impl FnMut(&[u8]) -> Result<(), E>,
    ) -> Result<(), E> {
        const { assert!(M::SIZE <= MAX_MEMORY_SIZE) };
        let mut out = Summed {
            digest: CRC.digest(),
            sink,
        };
        out.write(&MAGIC)?;
        out.write(&VERSION.to_le_bytes())?;
        out.write(&[R::ID, M::SIZE as u8])?;
        out.write(&(self.size() as u32).to_le_bytes())?;
        for value in parameters.to_array() {
            out.write(&value.to_le_bytes())?;
        }
        out.write(&self.steps.to_le_bytes())?;
        out.write(&self.sensing.width.to_le_bytes())?;
        for amplitude in self
            .sensing
            .neurons
            .iter()
            .flat_map(SensingNeuron::amplitudes)
        {
            out.write(&amplitude.0.to_le_bytes())?;
        }
        let elements = self.patterns.elements();
        out.write(&(elements.len() as u32).to_le_bytes())?;
        for element in elements {
            let mut memory = [0; MAX_MEMORY_SIZE];
            element.memory.write(&mut memory[..M::SIZE]);
            out.write(&element.code.0.to_le_bytes())?;
            out.write(&element.last_occurrence.to_le_bytes())?;
            out.write(&element.occurrences.to_le_bytes())?;
            out.write(&memory[..M::SIZE])?;
        }
        out.finish()
    }

    /// Reads what [`write`](Self::write) wrote into `self`, and returns the parameters it was
    /// learned with. On an error `self` is left [`EMPTY`](Knowledge::EMPTY).
    ///
    /// Reads in place, so that no second pattern vector is needed on the board.
    ///
    /// # Errors
    /// See [`KnowledgeError`]; the checksum is verified first.
    pub fn read<R: LearningRule<Memory = M>>(
        &mut self,
        bytes: &[u8],
    ) -> Result<Parameters, KnowledgeError> {
        self.clear();
        let mut rest = verified::<R>(bytes)?;
        let parameters = self.read_body(&mut rest);
        if parameters.is_none() {
            self.clear();
        }
        parameters.ok_or(KnowledgeError::Impossible)
    }

    /// Checks header and checksum only, and returns the parameters that the knowledge was learned
    /// with.
    ///
    /// # Errors
    /// As [`read`](Self::read), which may still find an impossible value.
    pub fn inspect<R: LearningRule<Memory = M>>(
        bytes: &[u8],
    ) -> Result<Parameters, KnowledgeError> {
        let mut rest = verified::<R>(bytes)?;
        read_parameters(&mut rest).ok_or(KnowledgeError::Impossible)
    }

    fn clear(&mut self) {
        self.patterns.clear();
        self.sensing = SensingLayer::default();
        self.steps = 0;
    }

    fn read_body(&mut self, rest: &mut &[u8]) -> Option<Parameters> {
        let parameters = read_parameters(rest)?;
        let limit = parameters.learning.amplitude_limit * f64::from(Activation::ONE);
        // `as` saturates: no file can bring in more than the lattice's range.
        let limit = Activation((limit as i32).clamp(0, Activation::LIMIT.0));
        self.steps = u32::from_le_bytes(take(rest)?);
        self.sensing.width = u32::from_le_bytes(take(rest)?);
        for neuron in &mut self.sensing.neurons {
            let mut amplitudes = [Activation(0); STEPS];
            for amplitude in &mut amplitudes {
                *amplitude = Activation(i32::from_le_bytes(take(rest)?));
            }
            *neuron = SensingNeuron::from_amplitudes(amplitudes, limit)?;
        }
        let count = u32::from_le_bytes(take(rest)?);
        for _ in 0..count {
            let code = PatternCode(u16::from_le_bytes(take(rest)?));
            let last_occurrence = u32::from_le_bytes(take(rest)?);
            let occurrences = u32::from_le_bytes(take(rest)?);
            let memory;
            (memory, *rest) = rest.split_at_checked(M::SIZE)?;
            let memory = M::read(memory)?;
            let element = Element {
                code,
                last_occurrence,
                occurrences,
                memory,
            };
            self.patterns.restore(element).then_some(())?;
        }
        rest.is_empty().then_some(parameters)
    }
}

const fn size<M: Memory>(patterns: usize) -> usize {
    FIXED_SIZE + patterns * (PATTERN_SIZE + M::SIZE) + CRC_SIZE
}

fn read_parameters(rest: &mut &[u8]) -> Option<Parameters> {
    let mut values = [0.0; Parameters::COUNT];
    for value in &mut values {
        *value = f64::from_le_bytes(take(rest)?);
    }
    Some(Parameters::from_array(&values))
}

/// Splits off the next `N` bytes.
fn take<const N: usize>(rest: &mut &[u8]) -> Option<[u8; N]> {
    let (head, tail) = rest.split_first_chunk()?;
    *rest = tail;
    Some(*head)
}

/// Returns what is between header and checksum, if both are valid.
fn verified<R: LearningRule>(bytes: &[u8]) -> Result<&[u8], KnowledgeError> {
    if !bytes.starts_with(&MAGIC) {
        return Err(KnowledgeError::Magic);
    }
    let (&header, _) = bytes
        .split_first_chunk::<HEADER_SIZE>()
        .ok_or(KnowledgeError::Length {
            expected: FIXED_SIZE + CRC_SIZE,
            found: bytes.len(),
        })?;
    let [.., v0, v1, rule, memory_size, l0, l1, l2, l3] = header;
    let version = u16::from_le_bytes([v0, v1]);
    if version != VERSION {
        return Err(KnowledgeError::Version(version));
    }
    if (rule, usize::from(memory_size)) != (R::ID, R::Memory::SIZE) {
        return Err(KnowledgeError::Rule(rule));
    }
    let expected = u32::from_le_bytes([l0, l1, l2, l3]) as usize;
    if expected != bytes.len() || expected < FIXED_SIZE + CRC_SIZE {
        return Err(KnowledgeError::Length {
            expected,
            found: bytes.len(),
        });
    }
    let (content, crc) = bytes.split_at(expected - CRC_SIZE);
    if CRC.checksum(content).to_le_bytes() != crc {
        return Err(KnowledgeError::Checksum);
    }
    Ok(&content[HEADER_SIZE..])
}

/// Forwards bytes to a sink and adds them to the checksum.
struct Summed<'c, S> {
    digest: Digest<'c, u32, crc::Table<1>>,
    sink: S,
}

impl<E, S: FnMut(&[u8]) -> Result<(), E>> Summed<'_, S> {
    fn write(&mut self, bytes: &[u8]) -> Result<(), E> {
        self.digest.update(bytes);
        (self.sink)(bytes)
    }

    fn finish(mut self) -> Result<(), E> {
        (self.sink)(&self.digest.finalize().to_le_bytes())
    }
}

/// Why bytes are not knowledge.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum KnowledgeError {
    /// They do not begin as knowledge does.
    Magic,
    /// They are of another version of the layout.
    Version(u16),
    /// They were learned by another rule.
    Rule(u8),
    /// They are cut short, or something follows them.
    Length {
        /// The length they claim, or at least need.
        expected: usize,
        /// Their length.
        found: usize,
    },
    /// Something was damaged: the checksum does not match.
    Checksum,
    /// The checksum matches, but no robot can have learned this.
    Impossible,
}

impl core::fmt::Display for KnowledgeError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Magic => write!(f, "not a knowledge file: expected it to begin with TRVK"),
            Self::Version(found) => {
                write!(
                    f,
                    "knowledge of layout version {found}, expected version {VERSION}"
                )
            }
            Self::Rule(found) => {
                write!(
                    f,
                    "knowledge learned by rule {found}, which this program does not know"
                )
            }
            Self::Length { expected, found } => {
                write!(
                    f,
                    "knowledge of {found} bytes, expected {expected}: cut short or joined"
                )
            }
            Self::Checksum => write!(f, "knowledge is damaged: its checksum does not match"),
            Self::Impossible => write!(
                f,
                "knowledge has values out of range: falling staircases, phases beyond half a turn, or a pattern twice"
            ),
        }
    }
}

impl core::error::Error for KnowledgeError {}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::learning::paper_rule::{MotorWeights, PaperRule};
    use crate::parameters::Coefficients;
    use crate::random::Generator;
    use crate::sensing::neuron::StepIndex;
    use crate::units::Microdegrees;
    use proptest::prelude::*;
    use std::vec::Vec;

    type Known = Knowledge<MotorWeights>;

    fn bytes(knowledge: &Known) -> Vec<u8> {
        let mut bytes = Vec::new();
        let written = knowledge.write::<PaperRule, ()>(&Parameters::ROVER, |part| {
            bytes.extend_from_slice(part);
            Ok(())
        });
        assert_eq!((written, bytes.len()), (Ok(()), knowledge.size()));
        bytes
    }

    fn empty() -> Known {
        Known::new(&Coefficients::new(&Parameters::PAPER).unwrap().learning)
    }

    /// Knowledge as some learning might leave it.
    fn learned(seed: u64, patterns: u32) -> Known {
        let mut rng = Generator::new(seed);
        let mut knowledge = empty();
        for _ in 0..100 {
            let neuron = (rng.bits() % 4) as usize;
            let (step, change) = (rng.bits() % 10, rng.symmetric(1 << 20));
            let step = StepIndex::saturating(step);
            knowledge.sensing.neurons[neuron].shift(step, change, Activation(10 << 20));
        }
        knowledge.sensing.width = rng.bits();
        knowledge.steps = rng.bits();
        for i in 0..patterns {
            let memory = MotorWeights {
                phase: Microdegrees(rng.symmetric(45_000_000)),
                search: Microdegrees(rng.symmetric(6_000_000) + 6_000_000),
                expected_gain: rng.symmetric(1 << 30),
            };
            knowledge
                .patterns
                .store(PatternCode(i as u16), rng.bits(), memory);
        }
        knowledge
    }

    fn read(bytes: &[u8]) -> Result<(Known, Parameters), KnowledgeError> {
        let mut knowledge = learned(99, 3);
        knowledge
            .read::<PaperRule>(bytes)
            .map(|parameters| (knowledge, parameters))
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]

        #[test]
        fn what_was_written_is_read(seed: u64, patterns in 0u32..=2_000) {
            let knowledge = learned(seed, patterns);
            let (back, parameters) = read(&bytes(&knowledge)).unwrap();
            prop_assert!(back == knowledge);
            prop_assert_eq!(parameters, Parameters::ROVER);
        }

        #[test]
        fn any_changed_byte_is_noticed(seed: u64, at: prop::sample::Index, by in 1u8..=255) {
            let mut damaged = bytes(&learned(seed, 20));
            let at = at.index(damaged.len());
            damaged[at] ^= by;
            prop_assert!(read(&damaged).is_err());
        }

        #[test]
        fn any_cut_is_noticed(seed: u64, at: prop::sample::Index) {
            let whole = bytes(&learned(seed, 20));
            prop_assert!(read(&whole[..at.index(whole.len())]).is_err());
        }

        #[test]
        fn no_bytes_make_it_panic(noise in prop::collection::vec(any::<u8>(), 0..600)) {
            let _ = read(&noise);
        }
    }

    #[test]
    fn a_full_pattern_vector_has_the_stated_size() {
        assert_eq!(bytes(&learned(1, 2_000)).len(), Known::max_size());
    }

    /// Damage that a checksum cannot find, because it was made before the sum.
    #[test]
    fn values_no_robot_can_have_learned_are_refused() {
        let mut falling = bytes(&empty());
        falling[212..216].copy_from_slice(&1i32.to_le_bytes());
        let end = falling.len() - 4;
        let sum = CRC.checksum(&falling[..end]);
        falling[end..].copy_from_slice(&sum.to_le_bytes());
        assert_eq!(read(&falling).map(|_| ()), Err(KnowledgeError::Impossible));
    }

    /// The limit is checked with all other parameters only when they are used.
    #[test]
    fn a_limit_below_zero_lets_no_amplitude_in() {
        for limit in [-1.0, f64::NEG_INFINITY, f64::NAN] {
            let mut parameters = Parameters::PAPER;
            parameters.learning.amplitude_limit = limit;
            let mut bytes = Vec::new();
            let written = learned(1, 3).write::<PaperRule, ()>(&parameters, |part| {
                bytes.extend_from_slice(part);
                Ok(())
            });
            assert_eq!(written, Ok(()));
            assert_eq!(read(&bytes).map(|_| ()), Err(KnowledgeError::Impossible));
        }
    }

    #[test]
    fn a_failed_read_leaves_nothing_half_taken() {
        let mut damaged = bytes(&learned(1, 20));
        damaged[300] ^= 1;
        let mut knowledge = learned(2, 5);
        assert_eq!(
            knowledge.read::<PaperRule>(&damaged),
            Err(KnowledgeError::Checksum)
        );
        assert!(knowledge.patterns.elements().is_empty());
        assert_eq!(knowledge.sensing, SensingLayer::default());
    }
}

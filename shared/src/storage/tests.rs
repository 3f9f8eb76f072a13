use super::slots::MAGIC;
use super::*;
use crate::random::Generator;
use proptest::prelude::*;
use std::vec;
use std::vec::Vec;

const SECTORS: u32 = 2;

/// A NOR flash whose power can fail in the middle of any operation.
#[derive(Clone)]
struct Nor {
    bytes: Vec<u8>,
    /// Operations until the cut; `None`: no cut.
    left: Option<u32>,
    /// What the cut operation leaves behind.
    chance: Generator,
    operations: u32,
    erasures: Vec<u32>,
}

#[derive(Debug, PartialEq)]
struct PowerCut;

impl Nor {
    fn new() -> Self {
        let sectors = 2 * SECTORS as usize;
        Self {
            bytes: vec![0xFF; sectors * SECTOR as usize],
            left: None,
            chance: Generator::new(0),
            operations: 0,
            erasures: vec![0; sectors],
        }
    }

    /// Applies `change` to bytes: to all, or, if the power fails now, to random bits of some.
    fn operate(
        &mut self,
        offset: u32,
        length: usize,
        change: impl Fn(u8, usize) -> u8,
    ) -> Result<(), PowerCut> {
        let cut = match &mut self.left {
            Some(0) => return Err(PowerCut),
            Some(left) => {
                *left -= 1;
                *left == 0
            }
            None => false,
        };
        self.operations += 1;
        // Some operations are cut before anything, some after everything happened.
        let share = if cut { self.chance.bits() % 5 } else { 4 };
        for i in 0..length {
            let place = &mut self.bytes[offset as usize + i];
            let mask = match share {
                0 => 0,
                4 => 0xFF,
                // The first pages of it, or bits here and there.
                1 if i < length / 2 => 0xFF,
                1 => 0,
                _ => {
                    self.chance.bits() as u8
                        | if share == 3 {
                            self.chance.bits() as u8
                        } else {
                            0
                        }
                }
            };
            *place = (*place & !mask) | (change(*place, i) & mask);
        }
        if cut { Err(PowerCut) } else { Ok(()) }
    }
}

impl Flash for Nor {
    type Error = PowerCut;

    fn read(&mut self, offset: u32, into: &mut [u8]) -> Result<(), PowerCut> {
        into.copy_from_slice(&self.bytes[offset as usize..][..into.len()]);
        Ok(())
    }

    fn erase(&mut self, offset: u32) -> Result<(), PowerCut> {
        assert!(offset.is_multiple_of(SECTOR));
        self.erasures[(offset / SECTOR) as usize] += 1;
        self.operate(offset, SECTOR as usize, |_, _| 0xFF)
    }

    fn program(&mut self, offset: u32, page: &[u8; PAGE]) -> Result<(), PowerCut> {
        assert!((offset as usize).is_multiple_of(PAGE));
        let page = *page;
        self.operate(offset, PAGE, |old, i| old & page[i])
    }
}

fn write(flash: &mut Nor, slots: &mut Slots, content: &[u8]) -> Result<u32, WriteError<PowerCut>> {
    let mut write = slots.write(content)?;
    loop {
        if let Progress::Done(record) = write.step(flash, content)? {
            slots.written(record);
            return Ok(record.writes());
        }
    }
}

fn opened(flash: &mut Nor) -> Slots {
    let mut slots = Slots::new(0, SECTORS);
    slots.open(flash).expect("reading needs no power budget");
    slots
}

/// What a rover that starts now would find.
fn content(flash: &mut Nor) -> Option<Vec<u8>> {
    let mut buffer = vec![0; Slots::new(0, SECTORS).capacity()];
    let slots = opened(flash);
    slots
        .read(flash, &mut buffer)
        .expect("as above")
        .map(<[u8]>::to_vec)
}

fn bytes(seed: u64, length: usize) -> Vec<u8> {
    let mut rng = Generator::new(seed);
    (0..length).map(|_| rng.bits() as u8).collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// The promise: power may fail in the middle of any operation, of any of several writes in a
    /// row, and what is found is the content before or the content after, whole.
    #[test]
    fn a_power_cut_at_any_operation_leaves_old_or_new(
        seed: u64,
        lengths in prop::collection::vec(0usize..(SECTORS * SECTOR) as usize - PAGE, 1..5),
    ) {
        let mut flash = Nor::new();
        let mut old: Option<Vec<u8>> = None;
        for (i, length) in lengths.into_iter().enumerate() {
            let new = bytes(seed ^ i as u64, length);
            let slots = opened(&mut flash);
            let mut whole = flash.clone();
            let before = whole.operations;
            prop_assert!(write(&mut whole, &mut slots.clone(), &new).is_ok());
            for cut in 1..=whole.operations - before {
                let mut torn = flash.clone();
                torn.left = Some(cut);
                torn.chance = Generator::new(seed.wrapping_add(u64::from(cut)));
                let result = write(&mut torn, &mut slots.clone(), &new);
                prop_assert_eq!(result, Err(WriteError::Flash(PowerCut)));
                let found = content(&mut torn);
                prop_assert!(found == old || found.as_ref() == Some(&new), "operation {}", cut);
                // And the next write works, on whatever the cut left.
                torn.left = None;
                let next = bytes(!seed, 700);
                let mut slots = opened(&mut torn);
                prop_assert!(write(&mut torn, &mut slots, &next).is_ok());
                prop_assert_eq!(content(&mut torn), Some(next));
            }
            flash = whole;
            old = Some(new);
            prop_assert_eq!(content(&mut flash), old.clone());
        }
    }

    /// One cut after another, with no good write between, never costs what was there.
    #[test]
    fn many_cuts_in_a_row_keep_the_content(seed: u64, cuts in prop::collection::vec(1u32..12, 1..12)) {
        let mut flash = Nor::new();
        let old = bytes(seed, 3_000);
        prop_assert!(write(&mut flash, &mut Slots::new(0, SECTORS), &old).is_ok());
        for (i, cut) in cuts.into_iter().enumerate() {
            flash.left = Some(cut);
            flash.chance = Generator::new(seed ^ i as u64);
            let mut slots = opened(&mut flash);
            prop_assert!(write(&mut flash, &mut slots, &bytes(seed ^ 1, 3_000)).is_err());
            prop_assert!(content(&mut flash).as_ref() == Some(&old));
        }
    }

    #[test]
    fn any_damaged_byte_costs_only_its_own_slot(seed: u64, place in any::<prop::sample::Index>(), bit in 0u8..8) {
        let mut flash = Nor::new();
        let mut slots = Slots::new(0, SECTORS);
        let (old, new) = (bytes(seed, 1_000), bytes(!seed, 1_000));
        prop_assert!(write(&mut flash, &mut slots, &old).is_ok());
        prop_assert!(write(&mut flash, &mut slots, &new).is_ok());
        let place = place.index(flash.bytes.len());
        flash.bytes[place] ^= 1 << bit;
        let found = content(&mut flash);
        prop_assert!(found == Some(old) || found == Some(new));
    }

    #[test]
    fn no_flash_content_panics(noise: [u8; 32], seed: u64) {
        let mut flash = Nor::new();
        flash.bytes = bytes(seed, flash.bytes.len());
        flash.bytes[..32].copy_from_slice(&noise);
        flash.bytes[..4].copy_from_slice(&MAGIC);
        prop_assert_eq!(content(&mut flash), None);
    }
}

#[test]
fn blank_damaged_and_whole_are_told_apart() {
    let mut flash = Nor::new();
    assert_eq!(opened(&mut flash).content(), Content::Blank);
    let mut slots = opened(&mut flash);
    assert_eq!(write(&mut flash, &mut slots, b"first"), Ok(1));
    assert!(matches!(opened(&mut flash).content(), Content::Whole(_)));
    flash.bytes[PAGE] ^= 1;
    assert_eq!(opened(&mut flash).content(), Content::Damaged);
    let mut slots = opened(&mut flash);
    assert_eq!(write(&mut flash, &mut slots, b"second"), Ok(1));
    assert_eq!(content(&mut flash).as_deref(), Some(b"second".as_slice()));
}

#[test]
fn wear_is_spread_and_bounded() {
    let mut flash = Nor::new();
    let mut slots = opened(&mut flash);
    for i in 0..10 {
        assert_eq!(
            write(&mut flash, &mut slots, &[i; 100]),
            Ok(u32::from(i) + 1)
        );
    }
    assert_eq!(
        write(&mut flash, &mut slots, &[9; 100]),
        Ok(10),
        "unchanged: not written"
    );
    assert_eq!(
        flash.erasures,
        [5, 0, 5, 0],
        "only what is needed is erased"
    );

    let Content::Whole(newest) = slots.content() else {
        panic!("written")
    };
    slots.written(Record {
        sequence: MOST_WRITES,
        ..newest
    });
    assert_eq!(
        write(&mut flash, &mut slots, b"more"),
        Err(WriteError::WornOut)
    );
}

#[test]
fn too_much_is_refused_and_a_bad_sector_noticed() {
    let mut flash = Nor::new();
    let mut slots = opened(&mut flash);
    let most = slots.capacity();
    assert_eq!(
        write(&mut flash, &mut slots, &vec![0; most + 1]),
        Err(WriteError::TooLong)
    );
    assert_eq!(write(&mut flash, &mut slots, &vec![0; most]), Ok(1));

    struct Stuck(Nor);
    impl Flash for Stuck {
        type Error = PowerCut;
        fn read(&mut self, offset: u32, into: &mut [u8]) -> Result<(), PowerCut> {
            self.0.read(offset, into)
        }
        fn erase(&mut self, _: u32) -> Result<(), PowerCut> {
            Ok(())
        }
        fn program(&mut self, offset: u32, page: &[u8; PAGE]) -> Result<(), PowerCut> {
            self.0.program(offset, page)
        }
    }
    // The other slot still holds zeros, and its erasure does nothing.
    flash.bytes[(SECTORS * SECTOR) as usize..].fill(0);
    let mut stuck = Stuck(flash);
    let mut write = slots.write::<PowerCut>(b"content").unwrap();
    let failed = loop {
        match write.step(&mut stuck, b"content") {
            Ok(Progress::UnderWay) => {}
            other => break other,
        }
    };
    assert_eq!(failed, Err(WriteError::ReadBack));
}

//! Damage.

use proptest::prelude::*;
use proptest::sample::Index;
use rand_core::Rng;
use rand_pcg::Pcg32;

/// Longest input.
const LONGEST: usize = 1 << 17;

/// Numbers and words that readers stumble over.
const TOKENS: [&[u8]; 32] = [
    b"0",
    b"-1",
    b"1e308",
    b"1e-308",
    b"NaN",
    b"inf",
    b"-inf",
    b"99999999999999999999",
    b"4294967296",
    b"-2147483649",
    b"1e5",
    b"0.001",
    b"true",
    b"null",
    b"\"\"",
    b"[[",
    b"]]",
    b"{",
    b"}",
    b"\n",
    b",",
    b"=",
    b": ",
    b"&a [*a, *a]",
    b"[[circle]]\nx_cm = 50\ny_cm = 50\nr_cm = 1e-9\n",
    b"P5 4096 4096 255\n",
    b"P4 1 1\n",
    b"\xff\xff\xff\xff\xff\xff\xff\xff",
    b"\x00\x00\x00\x00",
    b"\x00\x00\x00\x80",
    b"\xff\xff\xff\x7f",
    b"\xef\xbb\xbf",
];

/// One change of an input; places are shares of its length.
#[derive(Clone, Debug)]
pub enum Mutation {
    /// A bit changes.
    Flip(Index, u8),
    /// A byte becomes this.
    Set(Index, u8),
    /// A small number is added to a byte.
    Add(Index, i8),
    /// So many bytes go.
    Remove(Index, u8),
    /// So many bytes come once more.
    Repeat(Index, u8, u8),
    /// A token takes the place of what is there.
    Overwrite(Index, u8),
    /// A token comes in between.
    Insert(Index, u8),
    /// A number in the text becomes this token.
    Number(Index, u8),
    /// The end goes.
    Cut(Index),
    /// From here on it is another seed, from there on.
    Splice(Index, Index, Index),
}

impl Arbitrary for Mutation {
    type Parameters = ();
    type Strategy = BoxedStrategy<Self>;

    fn arbitrary_with((): ()) -> Self::Strategy {
        let (at, byte) = (any::<Index>, any::<u8>);
        prop_oneof![
            (at(), byte()).prop_map(|(a, b)| Self::Flip(a, b)),
            (at(), byte()).prop_map(|(a, b)| Self::Set(a, b)),
            (at(), any::<i8>()).prop_map(|(a, b)| Self::Add(a, b)),
            (at(), byte()).prop_map(|(a, b)| Self::Remove(a, b)),
            (at(), byte(), byte()).prop_map(|(a, b, c)| Self::Repeat(a, b, c)),
            (at(), byte()).prop_map(|(a, b)| Self::Overwrite(a, b)),
            (at(), byte()).prop_map(|(a, b)| Self::Insert(a, b)),
            (at(), byte()).prop_map(|(a, b)| Self::Number(a, b)),
            at().prop_map(Self::Cut),
            (at(), at(), at()).prop_map(|(a, b, c)| Self::Splice(a, b, c)),
        ]
        .boxed()
    }
}

impl Mutation {
    /// The changed input.
    pub fn apply(&self, input: Vec<u8>, seeds: &[Vec<u8>]) -> Vec<u8> {
        change(input, seeds, self.kind(), &mut |most, which| {
            self.draw(most, which)
        })
    }

    fn kind(&self) -> u32 {
        match self {
            Self::Flip(..) => 0,
            Self::Set(..) => 1,
            Self::Add(..) => 2,
            Self::Remove(..) => 3,
            Self::Repeat(..) => 4,
            Self::Overwrite(..) => 5,
            Self::Insert(..) => 6,
            Self::Number(..) => 7,
            Self::Cut(..) => 8,
            Self::Splice(..) => 9,
        }
    }

    /// Its number `which`, below `below`.
    fn draw(&self, below: usize, which: usize) -> usize {
        let below = below.max(1);
        let place = |index: &Index| index.index(below);
        let number = |byte: u8| usize::from(byte) % below;
        match (self, which) {
            (Self::Splice(_, seed, _), 1) => place(seed),
            (Self::Splice(_, _, from), 2) => place(from),
            (Self::Repeat(_, _, times), 2) => number(*times),
            (
                Self::Flip(_, byte)
                | Self::Set(_, byte)
                | Self::Remove(_, byte)
                | Self::Repeat(_, byte, _)
                | Self::Overwrite(_, byte)
                | Self::Insert(_, byte)
                | Self::Number(_, byte),
                1,
            ) => number(*byte),
            (Self::Add(_, byte), 1) => number(byte.cast_unsigned()),
            (
                Self::Flip(at, _)
                | Self::Set(at, _)
                | Self::Add(at, _)
                | Self::Remove(at, _)
                | Self::Repeat(at, _, _)
                | Self::Overwrite(at, _)
                | Self::Insert(at, _)
                | Self::Number(at, _)
                | Self::Cut(at)
                | Self::Splice(at, _, _),
                _,
            ) => place(at),
        }
    }
}

/// A seed with up to eight changes, or bytes by chance.
pub fn input(rng: &mut Pcg32, seeds: &[Vec<u8>]) -> Vec<u8> {
    let mut draw = |below: usize| rng.next_u32() as usize % below.max(1);
    if draw(20) == 0 {
        return (0..draw(600)).map(|_| draw(256) as u8).collect();
    }
    let seed = seeds[draw(seeds.len())].clone();
    (0..1 + draw(8)).fold(seed, |input, _| {
        let kind = draw(10) as u32;
        change(input, seeds, kind, &mut |below, _| draw(below))
    })
}

/// One change; `draw` gives its numbers: below what is asked for, and which of them it is.
fn change(
    mut input: Vec<u8>,
    seeds: &[Vec<u8>],
    kind: u32,
    draw: &mut dyn FnMut(usize, usize) -> usize,
) -> Vec<u8> {
    let at = draw(input.len(), 0);
    let end = |length: usize| (at + length).min(input.len());
    match kind {
        0..=2 => {
            let number = draw(256, 1) as u8;
            if let Some(byte) = input.get_mut(at) {
                *byte = match kind {
                    0 => *byte ^ 1 << (number % 8),
                    1 => number,
                    _ => byte.wrapping_add(number % 8).wrapping_sub(4),
                };
            }
        }
        3 => drop(input.drain(at..end(draw(256, 1)))),
        4 => {
            let part = input[at.min(input.len())..end(draw(256, 1))].to_vec();
            let repeated = part.repeat(draw(16, 2));
            input.splice(at..at, repeated);
        }
        5 => {
            let token = TOKENS[draw(TOKENS.len(), 1)];
            let end = end(token.len());
            input.splice(at..end, token.iter().copied());
        }
        6 => {
            let token = TOKENS[draw(TOKENS.len(), 1)];
            input.splice(at..at, token.iter().copied());
        }
        7 => number(&mut input, at, TOKENS[draw(TOKENS.len(), 1)]),
        8 => input.truncate(at),
        _ => {
            let other = &seeds[draw(seeds.len(), 1)];
            let from = draw(other.len(), 2);
            input.truncate(at);
            input.extend_from_slice(&other[from..]);
        }
    }
    input.truncate(LONGEST);
    input
}

/// Replaces the next number of the text after `at`.
fn number(input: &mut Vec<u8>, at: usize, token: &[u8]) {
    let is_part = |byte: &u8| byte.is_ascii_digit() || b".-".contains(byte);
    let Some(start) = input.iter().skip(at).position(u8::is_ascii_digit) else {
        return;
    };
    let start = at + start;
    let length = input[start..].iter().take_while(|b| is_part(b)).count();
    input.splice(start..start + length, token.iter().copied());
}

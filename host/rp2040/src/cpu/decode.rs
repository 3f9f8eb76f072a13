//! The encodings of ARMv6-M (chapter A5), and which instruction each is.

/// The low register (R0 to R7) that the three bits from `lsb` name.
#[inline(always)]
pub(super) fn register(op: u16, lsb: u32) -> usize {
    usize::from(op >> lsb & 7)
}

/// The register (R0 to R15) that bits 7 and 2 to 0 name: DN:Rdn or D:Rd.
#[inline(always)]
pub(super) fn high_register(op: u16) -> usize {
    usize::from(op >> 4 & 8 | op & 7)
}

/// The unsigned value of `width` bits from `lsb`.
#[inline(always)]
pub(super) fn immediate(op: u16, lsb: u32, width: u32) -> u32 {
    u32::from(op) >> lsb & ((1 << width) - 1)
}

/// The encodings, named as the manual names the instructions (A6.7).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Encoding {
    // Shift (immediate), add, subtract, move, compare (A5.2.1)
    LslImmediateT1,
    LsrImmediateT1,
    AsrImmediateT1,
    AddRegisterT1,
    SubRegisterT1,
    AddImmediateT1,
    SubImmediateT1,
    MovImmediateT1,
    CmpImmediateT1,
    AddImmediateT2,
    SubImmediateT2,
    // Data processing (A5.2.2)
    AndRegisterT1,
    EorRegisterT1,
    LslRegisterT1,
    LsrRegisterT1,
    AsrRegisterT1,
    AdcRegisterT1,
    SbcRegisterT1,
    RorRegisterT1,
    TstRegisterT1,
    RsbImmediateT1,
    CmpRegisterT1,
    CmnRegisterT1,
    OrrRegisterT1,
    MulT1,
    BicRegisterT1,
    MvnRegisterT1,
    // Special data instructions and branch and exchange (A5.2.3)
    AddRegisterT2,
    CmpRegisterT2,
    MovRegisterT1,
    BxT1,
    BlxRegisterT1,
    // Load from the literal pool
    LdrLiteralT1,
    // Load and store single data item (A5.2.4)
    StrRegisterT1,
    StrhRegisterT1,
    StrbRegisterT1,
    LdrsbRegisterT1,
    LdrRegisterT1,
    LdrhRegisterT1,
    LdrbRegisterT1,
    LdrshRegisterT1,
    StrImmediateT1,
    LdrImmediateT1,
    StrbImmediateT1,
    LdrbImmediateT1,
    StrhImmediateT1,
    LdrhImmediateT1,
    StrImmediateT2,
    LdrImmediateT2,
    // Generate PC-relative and SP-relative address
    AdrT1,
    AddSpImmediateT1,
    // Miscellaneous 16-bit instructions (A5.2.5); all hints share one entry.
    AddSpImmediateT2,
    SubSpImmediateT1,
    SxthT1,
    SxtbT1,
    UxthT1,
    UxtbT1,
    PushT1,
    CpsT1,
    RevT1,
    Rev16T1,
    RevshT1,
    PopT1,
    BkptT1,
    Hint,
    // Store and load multiple
    StmT1,
    LdmT1,
    // Conditional branch, and supervisor call (A5.2.6); 1110 is UDF T1.
    BT1,
    SvcT1,
    // Unconditional branch
    BT2,
    // The first half of a 32-bit instruction (A5.3)
    Wide,
    // UDF T1 and what is not allocated
    Undefined,
}

/// The encoding of every instruction: bits 15 to 6 tell. As a table, because a match on ranges
/// would be a search, and this is what is done most often.
const ENCODINGS: &[Encoding; 1 << 10] = &{
    let mut table = [Encoding::Undefined; 1 << 10];
    let mut bits = 0;
    while bits < table.len() {
        table[bits] = encoding_of(bits as u16);
        bits += 1;
    }
    table
};

/// The encoding of the instruction that begins with the halfword `op`.
#[inline(always)]
pub(super) fn decode(op: u16) -> Encoding {
    ENCODINGS[usize::from(op >> 6)]
}

/// A5.2, by bits 15 to 6. Groups of digits are fields of the encodings.
#[allow(clippy::unusual_byte_groupings)]
const fn encoding_of(bits: u16) -> Encoding {
    use Encoding as I;
    match bits {
        // Shift (immediate), add, subtract, move, compare (A5.2.1)
        0b00000_00000..=0b00000_11111 => I::LslImmediateT1,
        0b00001_00000..=0b00001_11111 => I::LsrImmediateT1,
        0b00010_00000..=0b00010_11111 => I::AsrImmediateT1,
        0b0001100_000..=0b0001100_111 => I::AddRegisterT1,
        0b0001101_000..=0b0001101_111 => I::SubRegisterT1,
        0b0001110_000..=0b0001110_111 => I::AddImmediateT1,
        0b0001111_000..=0b0001111_111 => I::SubImmediateT1,
        0b00100_00000..=0b00100_11111 => I::MovImmediateT1,
        0b00101_00000..=0b00101_11111 => I::CmpImmediateT1,
        0b00110_00000..=0b00110_11111 => I::AddImmediateT2,
        0b00111_00000..=0b00111_11111 => I::SubImmediateT2,
        // Data processing (A5.2.2)
        0b010000_0000 => I::AndRegisterT1,
        0b010000_0001 => I::EorRegisterT1,
        0b010000_0010 => I::LslRegisterT1,
        0b010000_0011 => I::LsrRegisterT1,
        0b010000_0100 => I::AsrRegisterT1,
        0b010000_0101 => I::AdcRegisterT1,
        0b010000_0110 => I::SbcRegisterT1,
        0b010000_0111 => I::RorRegisterT1,
        0b010000_1000 => I::TstRegisterT1,
        0b010000_1001 => I::RsbImmediateT1,
        0b010000_1010 => I::CmpRegisterT1,
        0b010000_1011 => I::CmnRegisterT1,
        0b010000_1100 => I::OrrRegisterT1,
        0b010000_1101 => I::MulT1,
        0b010000_1110 => I::BicRegisterT1,
        0b010000_1111 => I::MvnRegisterT1,
        // Special data instructions and branch and exchange (A5.2.3)
        0b010001_00_00..=0b010001_00_11 => I::AddRegisterT2,
        0b010001_01_00..=0b010001_01_11 => I::CmpRegisterT2,
        0b010001_10_00..=0b010001_10_11 => I::MovRegisterT1,
        0b010001_110_0..=0b010001_110_1 => I::BxT1,
        0b010001_111_0..=0b010001_111_1 => I::BlxRegisterT1,
        // Load from the literal pool
        0b01001_00000..=0b01001_11111 => I::LdrLiteralT1,
        // Load and store single data item (A5.2.4)
        0b0101_000_000..=0b0101_000_111 => I::StrRegisterT1,
        0b0101_001_000..=0b0101_001_111 => I::StrhRegisterT1,
        0b0101_010_000..=0b0101_010_111 => I::StrbRegisterT1,
        0b0101_011_000..=0b0101_011_111 => I::LdrsbRegisterT1,
        0b0101_100_000..=0b0101_100_111 => I::LdrRegisterT1,
        0b0101_101_000..=0b0101_101_111 => I::LdrhRegisterT1,
        0b0101_110_000..=0b0101_110_111 => I::LdrbRegisterT1,
        0b0101_111_000..=0b0101_111_111 => I::LdrshRegisterT1,
        0b0110_0_00000..=0b0110_0_11111 => I::StrImmediateT1,
        0b0110_1_00000..=0b0110_1_11111 => I::LdrImmediateT1,
        0b0111_0_00000..=0b0111_0_11111 => I::StrbImmediateT1,
        0b0111_1_00000..=0b0111_1_11111 => I::LdrbImmediateT1,
        0b1000_0_00000..=0b1000_0_11111 => I::StrhImmediateT1,
        0b1000_1_00000..=0b1000_1_11111 => I::LdrhImmediateT1,
        0b1001_0_00000..=0b1001_0_11111 => I::StrImmediateT2,
        0b1001_1_00000..=0b1001_1_11111 => I::LdrImmediateT2,
        // Generate PC-relative and SP-relative address
        0b10100_00000..=0b10100_11111 => I::AdrT1,
        0b10101_00000..=0b10101_11111 => I::AddSpImmediateT1,
        // Miscellaneous 16-bit instructions (A5.2.5)
        0b1011_00000_0..=0b1011_00000_1 => I::AddSpImmediateT2,
        0b1011_00001_0..=0b1011_00001_1 => I::SubSpImmediateT1,
        0b1011_001000 => I::SxthT1,
        0b1011_001001 => I::SxtbT1,
        0b1011_001010 => I::UxthT1,
        0b1011_001011 => I::UxtbT1,
        0b1011_010_000..=0b1011_010_111 => I::PushT1,
        0b1011_011001 => I::CpsT1,
        0b1011_101000 => I::RevT1,
        0b1011_101001 => I::Rev16T1,
        0b1011_101011 => I::RevshT1,
        0b1011_110_000..=0b1011_110_111 => I::PopT1,
        0b1011_1110_00..=0b1011_1110_11 => I::BkptT1,
        0b1011_1111_00..=0b1011_1111_11 => I::Hint,
        // Store and load multiple
        0b11000_00000..=0b11000_11111 => I::StmT1,
        0b11001_00000..=0b11001_11111 => I::LdmT1,
        // Conditional branch, and supervisor call (A5.2.6); 1110 is UDF T1.
        0b1101_0000_00..=0b1101_1101_11 => I::BT1,
        0b1101_1111_00..=0b1101_1111_11 => I::SvcT1,
        // Unconditional branch
        0b11100_00000..=0b11100_11111 => I::BT2,
        // The first half of a 32-bit instruction (A5.3)
        0b11101_00000..=0b11111_11111 => I::Wide,
        _ => I::Undefined,
    }
}

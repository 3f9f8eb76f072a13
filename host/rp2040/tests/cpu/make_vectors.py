#!/usr/bin/env python3
"""Makes test vectors for the Cortex-M0+ core with Unicorn (Cortex-M0), an independent emulator.

A vector is one instruction, a state before and the state after. Every encoding of ARMv6-M that
user code has occurs equally often, with random operands, registers, flags and memory. Left out:
what the architecture calls UNPREDICTABLE, what faults or sleeps, and what Unicorn 2.1.4 is known to
do otherwise than the architecture (APSR.Q, bits 2 and 3 of CONTROL, YIELD).

The committed sample:

    python3 -m venv /tmp/venv && /tmp/venv/bin/pip install unicorn==2.1.4
    /tmp/venv/bin/python host/rp2040/tests/cpu/make_vectors.py host/rp2040/tests/cpu/vectors.bin --count 20000 --seed 1

The full run, more than a million vectors (20 minutes, 18 MB):

    /tmp/venv/bin/python host/rp2040/tests/cpu/make_vectors.py /tmp/cpu-full.bin --count 1200000 --seed 2
    CPU_VECTORS=/tmp/cpu-full.bin cargo test --release -p emulated-rp2040 --test cpu -- \\
        --ignored full_set_of_vectors

Unicorn is licensed under the GPL. It is used by this script only; nothing links it.

File format, little-endian: "TRV1", u32 count, u32 seed, then the vectors. Vector i starts from
state(seed, i) below, and is

    u16       the instruction; another u16 if it is a 32-bit one
    u16       mask of registers R0 to R14 whose value differs from that of state()
    u32 each  these values
    u8        after: N Z C V in bits 7 to 4, bit 1: PC is not that of the next instruction,
              bit 0: PRIMASK
    u16       after: mask of R0 to R14 that changed; bit 15: PSP
    u32 each  their values
    u32       after: PC, if bit 1 above is set
    u8        number of words of memory that changed
    2 u32     each: address, value
"""

import argparse
import random
import struct
import sys

from unicorn import UC_ARCH_ARM, UC_HOOK_MEM_WRITE, UC_MODE_MCLASS, UC_MODE_THUMB, Uc
from unicorn.arm_const import (
    UC_ARM_REG_LR, UC_ARM_REG_PC, UC_ARM_REG_PRIMASK, UC_ARM_REG_PSP,
    UC_ARM_REG_R0, UC_ARM_REG_SP, UC_ARM_REG_XPSR, UC_CPU_ARM_CORTEX_M0,
)

MEMORY = 0x20000000
MEMORY_SIZE = 16 << 20
DATA = MEMORY + 0x10000       # loads and stores stay within
DATA_SIZE = 0x80000
CODE = MEMORY + 0x100000      # vector i is at CODE + 6 i modulo CODE_SIZE
CODE_SIZE = 14 << 20
SP, LR, PC = 13, 14, 15


def mix(x):
    """A hash of 32 bits (the finaliser of MurmurHash3)."""
    x &= 0xFFFFFFFF
    x = ((x ^ x >> 16) * 0x85EBCA6B) & 0xFFFFFFFF
    x = ((x ^ x >> 13) * 0xC2B2AE35) & 0xFFFFFFFF
    return x ^ x >> 16


IMAGE = [mix(i * 0x9E3779B9 + 1) for i in range(1 << 14)]


def word_at(address):
    """What memory holds before every vector."""
    return IMAGE[address >> 2 & 0x3FFF]


def register_value(word):
    """Of random words, makes some small, some negative, some extreme."""
    kind = mix(word + 1) & 7
    if kind == 0:
        return word & 0xFF
    if kind == 1:
        return 0x7FFFFFFF + (word & 3)
    if kind == 2:
        return 0xFFFFFF00 | word & 0xFF
    if kind == 3:
        return word & 0x3F
    return word


def state(seed, i):
    """Registers R0 to R14, PSP, flags (N Z C V in bits 3 to 0), PRIMASK, PC."""
    words = [mix(mix(seed) + i * 32 + k) for k in range(18)]
    registers = [register_value(word) for word in words[:15]]
    registers[SP] = DATA + (words[SP] & 0x3FFFC)
    psp = DATA + (words[15] & 0x3FFFC)
    return registers, psp, words[16] & 15, words[17] & 1, CODE + 6 * i % CODE_SIZE


class Maker:
    """Makes the instruction of a vector and gives some registers values that suit it."""

    def __init__(self, rng, registers, pc):
        self.rng = rng
        self.registers = list(registers)
        self.pc = pc

    def low(self):
        return self.rng.randrange(8)

    def bits(self, n):
        return self.rng.getrandbits(n)

    def high_except(self, *excluded):
        return self.rng.choice([n for n in range(16) if n not in excluded])

    def address(self, size):
        return DATA + self.rng.randrange(DATA_SIZE) // size * size

    def code_address(self):
        return (CODE + self.rng.randrange(CODE_SIZE)) | 1

    def three_registers(self, prefix):
        return prefix << 9 | self.low() << 6 | self.low() << 3 | self.low()

    def shift_immediate(self, prefix):
        return prefix << 11 | self.bits(11)

    def immediate8(self, prefix):
        return prefix << 11 | self.bits(11)

    def data_processing(self, opcode):
        return 0b010000 << 10 | opcode << 6 | self.bits(6)

    def special(self, opcode, d, m):
        return 0b010001 << 10 | opcode << 8 | (d & 8) << 4 | m << 3 | d & 7

    def add_high(self):
        d, m = self.bits(4), self.bits(4)
        if d == SP or m == SP or (d, m) == (PC, PC):
            return self.add_high()     # SP is for add_sp()
        if d == PC:
            self.registers[m] = self.code_address() - (self.pc + 4) & 0xFFFFFFFF
        return self.special(0, d, m)

    def cmp_high(self):
        n, m = self.high_except(PC), self.high_except(PC)
        return self.special(1, n, m) if n > 7 or m > 7 else self.cmp_high()

    def mov_high(self):
        d, m = self.high_except(SP), self.bits(4)
        if d == PC and m not in (SP, PC):
            self.registers[m] = self.code_address()
        return self.special(2, d, m)

    def mov_sp(self):
        m = self.high_except(SP, PC)
        self.registers[m] &= ~3
        return self.special(2, SP, m)

    def add_sp(self):
        m = self.high_except(SP, PC)
        self.registers[m] &= ~3
        return self.special(0, SP, m)

    def add_register_sp(self):
        return self.special(0, self.high_except(SP, PC), SP)

    def branch_exchange(self, link):
        m = self.high_except(SP, PC)
        self.registers[m] = self.code_address()
        return 0b010001110 << 7 | link << 7 | m << 3

    def memory_register(self, opcode, size):
        t, n, m = self.low(), self.low(), self.low()
        if n == m:
            self.registers[n] = self.address(2 * size) >> 1
        else:
            offset = self.registers[m] & 0xFFF
            self.registers[m] = offset if self.bits(1) else -offset & 0xFFFFFFFF
            self.registers[n] = self.address(size) - self.registers[m] & 0xFFFFFFFF
        return 0b0101 << 12 | opcode << 9 | m << 6 | n << 3 | t

    def memory_immediate(self, prefix, size):
        t, n, offset = self.low(), self.low(), self.bits(5)
        self.registers[n] = self.address(size) - offset * size
        return prefix << 11 | offset << 6 | n << 3 | t

    def stm(self):
        n, registers = self.low(), self.rng.randrange(1, 256)
        if registers >> n & 1 and registers & ((1 << n) - 1):
            return self.stm()          # the stored base is UNKNOWN unless it is the lowest
        self.registers[n] = self.address(4)
        return 0b11000 << 11 | n << 8 | registers

    def ldm(self):
        n, registers = self.low(), self.rng.randrange(1, 256)
        self.registers[n] = self.address(4)
        return 0b11001 << 11 | n << 8 | registers

    def push(self):
        return 0b1011010 << 9 | self.rng.randrange(1, 512)

    def pop(self):
        return 0b10111100 << 8 | self.rng.randrange(1, 256)

    def pop_pc(self):
        registers = self.bits(8)
        while True:
            slot = self.registers[SP] + 4 * registers.bit_count()
            target = word_at(slot)
            # Unicorn does not execute from 0x40000000 and above, for devices are there.
            if target & 1 and target < 0x40000000:
                return 0b10111101 << 8 | registers
            self.registers[SP] += 4

    def branch_conditional(self):
        return 0b1101 << 12 | self.rng.randrange(14) << 8 | self.bits(8)

    def bl(self):
        return 0b11110 << 11 | self.bits(11), 0b11 << 14 | self.bits(1) << 13 | 1 << 12 | self.bits(12)

    def mrs(self):
        sysm = self.rng.choice([0, 1, 2, 3, 5, 6, 7, 8, 9, 16, 20])
        return 0xF3EF, 0x8000 | self.high_except(SP, PC) << 8 | sysm

    def msr(self):
        sysm = self.rng.choice([0, 1, 2, 3, 5, 6, 7, 8, 9, 16])
        n = self.high_except(SP, PC)
        if sysm < 4:
            self.registers[n] &= ~(1 << 27)    # APSR.Q is not in ARMv6-M
        if sysm in (8, 9):
            self.registers[n] &= ~3
        return 0xF380 | n, 0x8800 | sysm


CLASSES = [
    *[lambda m, p=p: m.shift_immediate(p) for p in (0b00000, 0b00001, 0b00010)],
    *[lambda m, p=p: m.three_registers(p) for p in (0b0001100, 0b0001101, 0b0001110, 0b0001111)],
    *[lambda m, p=p: m.immediate8(p) for p in (0b00100, 0b00101, 0b00110, 0b00111)],
    *[lambda m, o=o: m.data_processing(o) for o in range(16)],
    Maker.add_high, Maker.cmp_high, Maker.mov_high, Maker.mov_sp, Maker.add_sp,
    Maker.add_register_sp,
    lambda m: m.branch_exchange(0), lambda m: m.branch_exchange(1),
    lambda m: m.immediate8(0b01001),                                  # LDR (literal)
    *[lambda m, o=o, s=s: m.memory_register(o, s) for o, s in enumerate((4, 2, 1, 1, 4, 2, 1, 2))],
    lambda m: m.memory_immediate(0b01100, 4), lambda m: m.memory_immediate(0b01101, 4),
    lambda m: m.memory_immediate(0b01110, 1), lambda m: m.memory_immediate(0b01111, 1),
    lambda m: m.memory_immediate(0b10000, 2), lambda m: m.memory_immediate(0b10001, 2),
    lambda m: m.immediate8(0b10010), lambda m: m.immediate8(0b10011),  # SP-relative
    lambda m: m.immediate8(0b10100), lambda m: m.immediate8(0b10101),  # ADR, ADD (SP)
    lambda m: 0b101100000 << 7 | m.bits(7), lambda m: 0b101100001 << 7 | m.bits(7),
    *[lambda m, o=o: 0b1011001000 << 6 | o << 6 | m.bits(6) for o in range(4)],
    *[lambda m, o=o: 0b1011101000 << 6 | o << 6 | m.bits(6) for o in (0, 1, 3)],
    Maker.push, Maker.pop, Maker.pop_pc, Maker.stm, Maker.ldm,
    Maker.branch_conditional, lambda m: 0b11100 << 11 | m.bits(11), Maker.bl,
    Maker.mrs, Maker.msr, lambda m: 0xB662 | m.bits(1) << 4,           # CPSIE i, CPSID i
    lambda m: 0xBF00, lambda m: (0xF3BF, 0x8F40 + 16 * m.rng.randrange(3) + 15),
]

REGISTERS = [UC_ARM_REG_R0 + n for n in range(13)] + [UC_ARM_REG_SP, UC_ARM_REG_LR]


class Machine:
    """Unicorn with the memory image."""

    def __init__(self):
        self.uc = Uc(UC_ARCH_ARM, UC_MODE_THUMB | UC_MODE_MCLASS)
        self.uc.ctl_set_cpu_model(UC_CPU_ARM_CORTEX_M0)
        self.uc.mem_map(MEMORY, MEMORY_SIZE)
        # Where POP {PC} may lead: Unicorn looks at the next instruction before it stops.
        self.uc.mem_map(0, MEMORY)
        self.uc.mem_map(MEMORY + MEMORY_SIZE, 0x40000000 - MEMORY - MEMORY_SIZE)
        self.image = struct.pack("<16384I", *IMAGE)
        for offset in range(0, MEMORY_SIZE, len(self.image)):
            self.uc.mem_write(MEMORY + offset, self.image)
        self.touched = set()
        self.uc.hook_add(UC_HOOK_MEM_WRITE, self.note_write)
        # Where instructions branched to: Unicorn has translated the code there and does not
        # notice by itself when it is overwritten.
        self.reached = set()

    def note_write(self, _uc, _access, address, size, _value, _data):
        self.touched.update({address & ~3, address + size - 1 & ~3})

    def restore(self, address, size):
        offset = address % len(self.image)
        twice = self.image[offset:offset + size].ljust(size, b"\0")
        if offset + size > len(self.image):
            twice = (self.image + self.image)[offset:offset + size]
        self.uc.mem_write(address, twice)

    def run(self, code, registers, psp, flags, primask, pc):
        """The state after one instruction: registers, PSP, flags, PRIMASK, PC, changed words."""
        uc = self.uc
        uc.mem_write(pc, code)
        self.touched.clear()
        uc.reg_write(UC_ARM_REG_XPSR, flags << 28 | 1 << 24)
        for name, value in zip(REGISTERS, registers):
            uc.reg_write(name, value)
        uc.reg_write(UC_ARM_REG_PSP, psp)
        uc.reg_write(UC_ARM_REG_PRIMASK, primask)
        if pc in self.reached:
            uc.ctl_remove_cache(pc, pc + 4)
        uc.emu_start(pc | 1, 0xFFFFFFFF, count=1)
        after = [uc.reg_read(name) for name in REGISTERS]
        xpsr = uc.reg_read(UC_ARM_REG_XPSR)
        psp_after, primask_after = uc.reg_read(UC_ARM_REG_PSP), uc.reg_read(UC_ARM_REG_PRIMASK)
        pc_after = uc.reg_read(UC_ARM_REG_PC) & ~1
        self.reached.add(pc_after)
        changed = {}
        for address in sorted(self.touched):
            word, = struct.unpack("<I", uc.mem_read(address, 4))
            if word != word_at(address):
                changed[address] = word
        for address in self.touched:
            self.restore(address, 4)
        self.restore(pc, len(code))
        return after, psp_after, xpsr >> 28, primask_after, pc_after, changed


def differences(before, after):
    mask, values = 0, b""
    for n, (old, new) in enumerate(zip(before, after)):
        if old != new:
            mask |= 1 << n
            values += struct.pack("<I", new)
    return struct.pack("<H", mask) + values


def vector(machine, rng, seed, i):
    drawn, psp, flags, primask, pc = state(seed, i)
    maker = Maker(rng, drawn, pc)
    instruction = CLASSES[i % len(CLASSES)](maker)
    halfwords = instruction if isinstance(instruction, tuple) else (instruction,)
    code = struct.pack(f"<{len(halfwords)}H", *halfwords)
    registers = maker.registers
    after, psp_after, flags_after, primask_after, pc_after, changed = machine.run(
        code, registers, psp, flags, primask, pc)
    branched = pc_after != pc + len(code)
    record = code + differences(drawn, registers)
    record += struct.pack("<B", flags_after << 4 | branched << 1 | primask_after)
    record += differences(registers + [psp], after + [psp_after])
    if branched:
        record += struct.pack("<I", pc_after)
    record += struct.pack("<B", len(changed))
    for address, word in changed.items():
        record += struct.pack("<II", address, word)
    return record


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("output")
    parser.add_argument("--count", type=int, default=20000)
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    rng = random.Random(arguments.seed)
    machine = Machine()
    with open(arguments.output, "wb") as output:
        output.write(b"TRV1" + struct.pack("<II", arguments.count, arguments.seed))
        for i in range(arguments.count):
            output.write(vector(machine, rng, arguments.seed, i))
            if i % 100000 == 99999:
                print(f"{i + 1} vectors", file=sys.stderr)
                machine = Machine()        # lets Unicorn forget the code it has translated


if __name__ == "__main__":
    main()

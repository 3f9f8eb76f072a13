#!/usr/bin/env python3
"""Prints what a rover says as lines of JSON: a client of the protocol that wire.md describes, written
from that page, with Python's standard library alone (Linux, macOS).

    python3 docs/telemetry.py /dev/ttyACM0 --seconds 10
    python3 docs/telemetry.py /dev/ttyACM0 --learn --actions 20

--learn arms the rover and has it learn, following directions that change. However the program ends,
by Ctrl-C too, the rover is disarmed before, unless it was only listened to. No heartbeats are sent:
only mode Host needs them."""
import argparse, json, os, select, signal, struct, sys, time, tty, zlib

PROTOCOL, SCHEMA = 2, 0x3a770282
# The tables of wire.md: `?` before an optional type, `*` before a list, `4*` before an array.
STRUCTS = {
    "Hello": "schema:u32 board:str firmware:str reset:ResetReason seed:u64 knowledge:?u32",
    "Ack": "sequence:u16 result:Result",
    "Status": "time_us:u64 state:State motors_enabled:bool task:Task direction_udeg:i32 steps:u32 "
    "counts_adc:4*u16 distances_um:4*u32 heading_udeg:?i32 ranges:4*ChannelHealth "
    "compass:CompassHealth counters:20*u32",
    "ActionRecord": "time_us:u64 counts_adc:4*u16 ranges:4*ChannelHealth compass:CompassHealth "
    "sample:Sample step:StepRecord outcome:Outcome counters:20*u32",
    "Sample": "front_um:u32 left_um:u32 right_um:u32 heading_udeg:i32 target_bearing_udeg:?i32",
    "StepRecord": "step:u32 sensed:?Sensed learned:?Learned perceived:?Perceived action:Action",
    "Sensed": "target_angle_udeg:i32 percept_ppm:4*i32 reward_micro:4*i32",
    "Learned": "code:u16 reward_difference_micro:i32 phase_udeg:i32 staircase:?StaircaseChange",
    "StaircaseChange": "stimulus:Stimulus step:u8 amount_q20:i32",
    "Perceived": "corners_q20:4*i32 code:u16 settle_time_64ths:u32 familiarity:Familiarity",
    "Action": "phase_udeg:i32 module_um:u32",
    "Event": "time_us:u64 kind:EventKind",
    "FaultReport": "time_us:u64 fault:Fault count:u32",
    "Chunk": "total_bytes:u32 fingerprint:u32 offset_bytes:u32 data:*u8",
    "Channel": "channel:u8 health:ChannelHealth",  # the contents of two variants
    "Stored": "fingerprint:u32",
    "Session": "mode:Mode seed:u64 knowledge:u32",
}
ENUMS = {
    "Report": "Hello:Hello Ack:Ack Status:Status Action:ActionRecord Event:Event Fault:FaultReport "
    "Knowledge:Chunk LastWords:str",
    "EventKind": "State:State MoveEnded:Outcome Direction_udeg:i32 KnowledgeStored:Stored "
    "Range:Channel Compass:CompassHealth Session:Session",
    "Result": "Ok Err:Refusal",
    "State": "Disarmed Armed Driving:Mode Faulted:Fault",
    "Mode": "Idle Learn Run Host",
    "Task": "FollowDirection FollowChangingDirection AimAtTarget",
    "ResetReason": "PowerOn RunPin Watchdog Panic HardFault Requested",
    "Outcome": "Completed Obstacle NoProgress TurnTimeout CompassLost Late Stopped",
    "ChannelHealth": "Unknown Good Open Shorted Frozen Silent NotFitted",
    "CompassHealth": "Unknown Good Silent Implausible",
    "Stimulus": "front left right target",
    "Familiarity": "known new replaced:u16",
    "Fault": "ControlSilent TaskSilent Blocked RangeSensor Compass NoProgress Stuck HostLate HostLost "
    "ArmRefused FlashWhileArmed BadFrame Unsettled QueueFull TurnTimeout LateStep BusRecovered "
    "AdcError ClockStepped FlashFailed",
    "Refusal": "NoHello SchemaMismatch NotArmed Armed Fault:Fault KnowledgeInvalid RangeSensor:Channel "
    "Compass:CompassHealth ControlSilent FlashBusy NoHeartbeat NotHostDriven MoveUnderWay OutOfRange "
    "BadCalibration ChunkOutOfOrder TooLong BadChecksum BadKnowledge Unsupported",
}
HELLO, ARM, DISARM, SET_MODE, SET_TASK, READ_STATUS = 0, 3, 4, 5, 6, 11  # variants of Command
LEARN, FOLLOW_CHANGING_DIRECTION = 1, 1


def varint(number):
    low, number = number & 0x7F, number >> 7
    return bytes([low | 0x80]) + varint(number) if number else bytes([low])


def read(kind, data):
    """Takes the value of a type off the beginning of `data`, an iterator over bytes."""
    count, star, each = kind.rpartition("*")
    if star:
        return [read(each, data) for _ in range(int(count) if count else read("u32", data))]
    if kind[0] == "?":
        return read(kind[1:], data) if next(data) else None
    if kind in STRUCTS:
        fields = (field.split(":") for field in STRUCTS[kind].split())
        return {name: read(of, data) for name, of in fields}
    if kind == "str":
        return bytes(read("*u8", data)).decode()
    if kind in ("u8", "bool"):
        return next(data) if kind == "u8" else bool(next(data))
    number, shift, byte = 0, 0, 0x80
    while byte >= 0x80:
        byte = next(data)
        number, shift = number | (byte & 0x7F) << shift, shift + 7
    if kind in ENUMS:
        name, _, contents = ENUMS[kind].split()[number].partition(":")
        return {name: read(contents, data)} if contents else name
    return (number >> 1) ^ -(number & 1) if kind == "i32" else number


def stuff(plain):
    stuffed = b""
    for piece in (plain + b"\0").split(b"\0")[:-1]:
        while len(piece) >= 254:
            stuffed, piece = stuffed + b"\xff" + piece[:254], piece[254:]
        stuffed += bytes([len(piece) + 1]) + piece
    return stuffed + b"\0"


def unstuff(stuffed):
    """Of a frame without its 00. A damaged one gives something that the checksum does not fit."""
    plain = b""
    while stuffed:
        code = stuffed[0]
        plain, stuffed = plain + stuffed[1:code], stuffed[code:]
        if code < 255 and stuffed:
            plain += b"\0"
    return plain


class Rover:
    def __init__(self, path):
        self.port = os.open(path, os.O_RDWR | os.O_NOCTTY)
        tty.setraw(self.port)
        self.sent, self.last, self.bytes = 0, None, b""
        self.actions, self.stopped = 0, None
        os.write(self.port, b"\0")

    def hear(self, patience):
        """The reports that come within `patience` seconds at most, printed."""
        if select.select([self.port], [], [], max(0, patience))[0]:
            self.bytes += os.read(self.port, 4096)
        *frames, self.bytes = self.bytes.split(b"\0")
        for frame in filter(None, frames):
            plain = unstuff(frame)
            if len(plain) < 8 or zlib.crc32(plain[:-4]) != struct.unpack("<I", plain[-4:])[0]:
                continue  # Damaged: its number will be missing.
            version, sequence = struct.unpack("<BH", plain[:3])
            if version != PROTOCOL:
                sys.exit(f"the rover speaks protocol {version}, this program {PROTOCOL}")
            ((name, contents),) = read("Report", iter(plain[3:-4])).items()
            begins = self.last is None or (sequence == 0 and name == "Hello")
            lost = 0 if begins else (sequence - self.last - 1) & 0xFFFF
            self.last = sequence
            fields = contents if isinstance(contents, dict) else {"text": contents}
            print(json.dumps({"report": name, "frame": sequence, "lost_frames": lost} | fields), flush=True)
            self.actions += name == "Action"
            if name == "Event" and "State" in contents["kind"]:
                state = contents["kind"]["State"]
                self.stopped = state if state == "Disarmed" or "Faulted" in state else None
            yield name, contents

    def ask(self, variant, contents=b"", patience=0.6, attempts=3):
        """Has a command carried out; gives the refusal, or None if it was done."""
        for _ in range(attempts):
            sequence, self.sent = self.sent, (self.sent + 1) & 0xFFFF
            plain = struct.pack("<BHB", PROTOCOL, sequence, variant) + contents
            os.write(self.port, stuff(plain + struct.pack("<I", zlib.crc32(plain))))
            until, answer = time.monotonic() + patience, None
            while answer is None and time.monotonic() < until:
                for name, report in self.hear(until - time.monotonic()):
                    if name == "Hello" and report["schema"] != SCHEMA:
                        sys.exit(f"the rover's schema is {report['schema']:08x}, not {SCHEMA:08x}")
                    if name == "Ack" and report["sequence"] == sequence:
                        answer = report["result"]
            if answer is not None:
                return None if answer == "Ok" else answer["Err"]
        sys.exit(f"the rover does not answer command {variant}")

    def must(self, variant, contents=b"", patience=5):
        """The same; what passes by itself, as a flash that is busy, is waited for."""
        until = time.monotonic() + patience
        while refusal := self.ask(variant, contents):
            passing = any(word in str(refusal) for word in ("FlashBusy", "Unknown"))
            if not passing or time.monotonic() > until:
                sys.exit(f"the rover refused command {variant}: {refusal}")
            time.sleep(0.02)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("port")
    parser.add_argument("--seconds", type=float, default=float("inf"))
    parser.add_argument("--actions", type=int, default=float("inf"))
    parser.add_argument("--learn", action="store_true", help="arm it and have it learn")
    options = parser.parse_args()
    signal.signal(signal.SIGINT, lambda *_: sys.exit(130))
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))
    rover = Rover(options.port)
    rover.ask(HELLO, varint(SCHEMA), patience=0.25, attempts=8)
    until, asked = time.monotonic() + options.seconds, float("-inf")
    try:
        if options.learn:
            rover.must(SET_TASK, varint(FOLLOW_CHANGING_DIRECTION))
            rover.must(ARM)
            rover.must(SET_MODE, varint(LEARN))
        while time.monotonic() < until and rover.actions < options.actions:
            if options.learn and rover.stopped:
                sys.exit(f"the rover has stopped by itself: {rover.stopped}")
            if time.monotonic() >= asked + 1:
                asked = time.monotonic()
                rover.must(READ_STATUS)
            for _ in rover.hear(min(until - time.monotonic(), 0.2)):
                pass
    finally:
        if options.learn:
            signal.signal(signal.SIGINT, signal.SIG_IGN)  # One Ctrl-C is enough.
            rover.must(DISARM)
            rover.must(READ_STATUS)


if __name__ == "__main__":
    try:
        main()
    except OSError as error:
        sys.exit(f"the port failed: {error}")

// The firmware on rp2040js, an RP2040 emulator that is not ours, with the chip's own boot ROM: a
// second opinion on both firmware and emulated board. See README.md for how to run it.
//
// Standard input and output are the rover's serial port; what happens is told on standard error.

import { readFileSync } from 'node:fs';
import { ConsoleLogger, LogLevel, Simulator, USBCDC } from 'rp2040js';

const [, , firmware, bootRom] = process.argv;
if (!bootRom) {
  console.error('usage: node drive.mjs FIRMWARE.uf2 BOOTROM.bin < serial port > serial port');
  process.exit(2);
}

const { rp2040: mcu } = new Simulator();
mcu.logger = new ConsoleLogger(LogLevel.Error);
const rom = readFileSync(bootRom);
mcu.loadBootrom(new Uint32Array(rom.buffer, rom.byteOffset, rom.length / 4));
const uf2 = readFileSync(firmware);
for (let at = 0; at < uf2.length; at += 512) {
  const [address, length] = [uf2.readUInt32LE(at + 12), uf2.readUInt32LE(at + 16)];
  mcu.flash.set(uf2.subarray(at + 32, at + 32 + length), address - 0x10000000);
}

// What rp2040js 1.4.1 does otherwise than the chip, as far as the firmware meets it.

// The flash cache's registers are missing; its stream is always empty.
const readWord = mcu.readUint32.bind(mcu);
mcu.readUint32 = (address) => {
  if (address >>> 8 !== 0x140000) return readWord(address);
  return (address & 0xff) === 8 ? 3 : 0;
};
// The watchdog's alarm goes off for ever once it has gone off.
const watchdog = mcu.peripherals[0x40058];
watchdog.alarm.clockAlarm.callback = () => {
  console.error('the watchdog bites');
  process.exit(1);
};
// An OUT buffer is available until its packet has come, not only until it was offered.
const AVAILABLE = 1 << 10;
const usb = mcu.usbCtrl;
const dpram = mcu.usbDPRAMView;
const updated = usb.DPRAMUpdated.bind(usb);
usb.DPRAMUpdated = (offset, value) => {
  updated(offset, value);
  const isOut = offset >= 0x84 && offset <= 0xfc && offset & 4;
  if (isOut && value & AVAILABLE) dpram.setUint32(offset, value, true);
};
const finishRead = usb.finishRead.bind(usb);
usb.finishRead = (endpoint, packet) => {
  const control = 0x84 + 8 * endpoint;
  dpram.setUint32(control, dpram.getUint32(control, true) & ~AVAILABLE, true);
  finishRead(endpoint, packet);
};
// SET_CONTROL_LINE_STATE goes to the interface (PSTN 1.2, 6.3.12), not to the device.
const sendSetup = usb.sendSetupPacket.bind(usb);
usb.sendSetupPacket = (packet) => {
  if (packet[0] === 0x20 && packet[1] === 0x22) packet[0] = 0x21;
  sendSetup(packet);
};
// The converter goes round channel 0 only.
const adc = mcu.adc;
Object.defineProperty(adc, 'activeChannel', {
  get: () => (adc.cs >> 12) & 7,
  set: (channel) => (adc.cs = (adc.cs & ~(7 << 12)) | (channel << 12)),
});

// The serial port. Packets are given when there is something in them.
const cdc = new USBCDC(usb);
const toRover = [];
let wanted = null;
function give() {
  if (wanted === null || toRover.length === 0) return;
  const packet = Uint8Array.from(toRover.splice(0, wanted));
  wanted = null;
  usb.endpointReadDone(cdc.outEndpoint, packet);
}
usb.onEndpointRead = (endpoint, size) => {
  if (endpoint !== cdc.outEndpoint) return;
  wanted = size;
  give();
};
cdc.onDeviceConnected = () => console.error('the serial port is there');
cdc.onSerialData = (packet) => process.stdout.write(packet);
process.stdin.on('data', (bytes) => {
  toRover.push(...bytes);
  give();
});

// The rover: on the spot it turns 160 degrees a second at most, and sees walls in the distance.
const [FULL, DEGREES_PER_MS] = [6250, 0.16];
let heading = 90;
function side(compare, forward, reverse) {
  const sign = mcu.gpio[forward].outputValue - mcu.gpio[reverse].outputValue;
  return (sign * compare) / FULL;
}
function move() {
  const compare = mcu.pwm.channels[0].cc;
  const turn = (side(compare & 0xffff, 2, 3) - side(compare >>> 16, 4, 5)) / 2;
  heading = (heading + DEGREES_PER_MS * turn + 360) % 360;
}
let flicker = 0;
adc.onADCRead = (channel) => {
  flicker = (flicker * 5 + 3) % 64;
  adc.channelValues[channel] = 450 + 50 * channel + (flicker >> 2);
  adc.currentChannel = channel;
  adc.sampleAlarm.schedule(2_000);
};

// The compass at 0x60: software version, bearing in 256ths of a turn, bearing in tenths of a degree.
const compass = mcu.i2c[1];
let register = null;
function compassRegister(number) {
  const tenths = Math.floor(10 * heading) % 3600;
  return [14, Math.floor((tenths * 256) / 3600), tenths >> 8, tenths & 0xff][number] ?? 0;
}
compass.onStart = () => compass.completeStart();
compass.onStop = () => compass.completeStop();
compass.onConnect = (address) => {
  register = null;
  compass.completeConnect(address === 0x60);
};
// Reads go on from the register written last, in the same connection.
let next = 0;
compass.onWriteByte = (byte) => {
  register = register ?? (next = byte);
  compass.completeWrite(true);
};
compass.onReadByte = () => compass.completeRead(compassRegister(next++));

// Real time, a millisecond at a time.
mcu.core.PC = 0x10000000;
const MS = 1e6;
const start = Date.now();
let moved = 0;
function run() {
  const until = (Date.now() - start) * MS;
  for (let budget = 2e6; mcu.clock.nanos < until && budget > 0; budget--) {
    if (mcu.core.waiting) mcu.clock.tick(Math.max(8, Math.min(MS, mcu.clock.nanosToNextAlarm)));
    else mcu.clock.tick(mcu.core.executeInstruction() * 8);
    for (; moved + MS <= mcu.clock.nanos; moved += MS) move();
  }
  setTimeout(run, 1);
}
run();

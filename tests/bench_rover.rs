//! The whole rover of `shared`, as the firmware's tasks drive it, in closed loop with the vehicle:
//! without the board, and some thousand times faster than real time.

#[path = "bench_rover/drive.rs"]
mod drive;
#[path = "bench_rover/faults.rs"]
mod faults;
#[path = "bench_rover/fixture.rs"]
mod fixture;
#[path = "bench_rover/host_driven.rs"]
mod host_driven;
#[path = "bench_rover/learning.rs"]
mod learning;

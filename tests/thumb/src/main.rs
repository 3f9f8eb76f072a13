//! Prints the checksum of each group of results, and how many cycles a perception takes.
//!
//! For the board's processor it is a program for the emulator's bare machine, which prints by
//! semihosting; on a host it prints the checksums that are expected.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod bare;
mod groups;

#[cfg(not(target_os = "none"))]
fn main() {
    struct Print;

    impl groups::Report for Print {
        fn group(&mut self, name: &str, checksum: u32) {
            println!("{name} {checksum:08x}");
        }
    }

    groups::run(&mut Print);
}

//! The program `rover`; all of it is in [`rover_host::cli`].

fn main() -> std::process::ExitCode {
    rover_host::cli::main()
}

//! The program `rover`; all of it is in [`rover_cli::cli`].

fn main() -> std::process::ExitCode {
    rover_cli::cli::main()
}

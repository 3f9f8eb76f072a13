//! `rover completions`

use clap_complete::Shell;

use super::output::{Failure, print};

#[derive(Debug, clap::Args)]
#[command(after_help = "Bash:  rover completions bash > \
~/.local/share/bash-completion/completions/rover\nFish:  rover completions fish > \
~/.config/fish/completions/rover.fish\nZsh:   rover completions zsh > \"${fpath[1]}/_rover\"")]
pub struct Arguments {
    /// The shell that is to complete commands
    #[arg(value_name = "SHELL")]
    shell: Shell,
}

/// Prints the script for the whole command line, `program`.
pub fn run(arguments: &Arguments, mut program: clap::Command) -> Result<(), Failure> {
    let mut script = Vec::new();
    clap_complete::generate(arguments.shell, &mut program, "rover", &mut script);
    print(&String::from_utf8(script)?)
}

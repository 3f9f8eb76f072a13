//! `rover completions`

use clap::CommandFactory;
use clap_complete::Shell;

use super::{Failure, print};

#[derive(Debug, clap::Args)]
#[command(after_help = "Bash:  rover completions bash > \
~/.local/share/bash-completion/completions/rover\nFish:  rover completions fish > \
~/.config/fish/completions/rover.fish\nZsh:   rover completions zsh > \"${fpath[1]}/_rover\"")]
pub struct Arguments {
    /// The shell that is to complete commands
    #[arg(value_name = "SHELL")]
    shell: Shell,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let mut command = super::Arguments::command();
    let mut script = Vec::new();
    clap_complete::generate(arguments.shell, &mut command, "rover", &mut script);
    print(&String::from_utf8(script)?)
}

//! `rover man`

use std::path::PathBuf;

use clap_mangen::Man;

use super::output::{Failure, print};
use rover_log::files::{writable_folder, write_whole};

#[derive(Debug, clap::Args)]
#[command(after_help = "Read the first one:  rover man | man -l -\n\
All commands:        rover man --out ~/.local/share/man/man1; man rover-learn")]
pub struct Arguments {
    /// Write a page for every command to this folder, instead of the first one to stdout
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

/// Prints or writes the pages of the whole command line, `program`.
pub fn run(arguments: &Arguments, program: clap::Command) -> Result<(), Failure> {
    let mut rover = program.disable_help_subcommand(true);
    // Sets every command its full name, as in rover-knowledge-pull.
    rover.build();
    let Some(folder) = &arguments.out else {
        return print(&String::from_utf8(page(&rover)?.1)?);
    };
    writable_folder(folder)?;
    let mut commands = vec![&rover];
    while let Some(command) = commands.pop() {
        let (name, text) = page(command)?;
        write_whole(&folder.join(name), &text)?;
        commands.extend(command.get_subcommands().filter(|c| !c.is_hide_set()));
    }
    Ok(())
}

/// A command's page: the name of its file, and its text.
fn page(command: &clap::Command) -> Result<(String, Vec<u8>), Failure> {
    let man = Man::new(command.clone());
    let mut text = Vec::new();
    man.render(&mut text)?;
    Ok((man.get_filename(), text))
}

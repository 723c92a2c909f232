//! `completions`: what a shell needs to complete subcommands and flags.

use clap::CommandFactory;
use std::io::Write;

/// Print a completion script for a shell
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  ballroom completions bash > ~/.local/share/bash-completion/completions/ballroom
  ballroom completions zsh > ~/.zfunc/_ballroom
  ballroom completions fish > ~/.config/fish/completions/ballroom.fish")]
pub struct Completions {
    /// Which shell
    shell: clap_complete::Shell,
}

impl Completions {
    pub fn run(self) -> anyhow::Result<()> {
        let mut script = Vec::new();
        clap_complete::generate(self.shell, &mut super::Cli::command(), "ballroom", &mut script);
        Ok(std::io::stdout().write_all(&script)?)
    }
}

//! `maquette completions` and `maquette man`: what a shell and a reader of manuals want to know of the program.

use clap::Args;
use clap_complete::Shell;

use super::print;

pub(super) const COMPLETIONS: &str = "\
Print what a shell needs to complete the program's arguments.

  bash:  maquette completions bash > ~/.local/share/bash-completion/completions/maquette
  zsh:   maquette completions zsh > a folder of $fpath/_maquette
  fish:  maquette completions fish > ~/.config/fish/completions/maquette.fish";

pub(super) const MAN: &str = "\
Print the manual: `maquette man > maquette.1`, and `man ./maquette.1` shows it.";

/// Arguments of `maquette completions`.
#[derive(Debug, Args)]
pub(super) struct CompletionsArguments {
    /// The shell
    #[arg(value_enum)]
    shell: Shell,
}

/// Prints the completions of a shell.
pub(super) fn completions(mut program: clap::Command, arguments: &CompletionsArguments) {
    let mut script = Vec::new();
    clap_complete::generate(arguments.shell, &mut program, "maquette", &mut script);
    print(&String::from_utf8_lossy(&script));
}

/// Prints the manual: the program's page, and after it one for each command.
pub(super) fn man(mut program: clap::Command) -> std::io::Result<()> {
    program.build();
    let mut page = Vec::new();
    clap_mangen::Man::new(program.clone()).render(&mut page)?;
    let commands = program.get_subcommands().filter(|command| command.get_name() != "help");
    for command in commands {
        // within the one page, a command is a section of its own
        let man = clap_mangen::Man::new(command.clone());
        page.extend(format!(".SH \"MAQUETTE {}\"\n", command.get_name().to_uppercase()).bytes());
        man.render_description_section(&mut page)?;
        man.render_synopsis_section(&mut page)?;
        man.render_options_section(&mut page)?;
    }
    print(&String::from_utf8_lossy(&page));
    Ok(())
}

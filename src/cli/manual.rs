//! `pintle completions` and `pintle man`: written from the definition of the command line, so that they cannot fall behind it.

use super::{Cli, Failure};
use clap::{Args, CommandFactory};
use clap_complete::Shell;
use clap_mangen::roff::{Roff, roman};
use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

#[derive(Debug, Args)]
pub(crate) struct Completions {
    /// The shell
    #[arg(value_enum)]
    shell: Shell,
}

pub(crate) const COMPLETIONS_HELP: &str = "\
Examples:
  pintle completions bash > ~/.local/share/bash-completion/completions/pintle
  pintle completions zsh > ~/.zfunc/_pintle      # ~/.zfunc must be in fpath
  pintle completions fish > ~/.config/fish/completions/pintle.fish";

#[derive(Debug, Args)]
pub(crate) struct Man {
    /// The page of this command, such as eval; without it, that of pintle
    #[arg(value_name = "COMMAND", conflicts_with = "folder")]
    command: Option<String>,
    /// Write all pages into this folder: pintle.1, pintle-eval.1 …
    #[arg(long, value_name = "FOLDER")]
    folder: Option<PathBuf>,
}

/// `pintle completions`.
pub(crate) fn completions(arguments: &Completions) -> Result<(), Failure> {
    Ok(io::stdout().lock().write_all(&script(arguments.shell))?)
}

fn script(shell: Shell) -> Vec<u8> {
    let mut text = Vec::new();
    clap_complete::generate(shell, &mut definition(), "pintle", &mut text);
    text
}

/// `pintle man`.
pub(crate) fn man(arguments: &Man) -> Result<(), Failure> {
    let pages = pages()?;
    if let Some(folder) = &arguments.folder {
        return save(folder, &pages);
    }
    let name = match arguments.command.as_deref() {
        None | Some("pintle") => "pintle".to_string(),
        Some(command) => format!("pintle-{command}"),
    };
    let Some((_, page)) = pages.iter().find(|(known, _)| *known == name) else {
        let known: Vec<&str> = pages.iter().filter_map(|(name, _)| name.strip_prefix("pintle-")).collect();
        let wanted = arguments.command.as_deref().unwrap_or_default();
        return Err(Failure::Usage(format!("there is no command {wanted}; there are {}", known.join(", "))));
    };
    Ok(io::stdout().lock().write_all(page)?)
}

fn save(folder: &Path, pages: &[(String, Vec<u8>)]) -> Result<(), Failure> {
    let cannot = |path: &Path, error: &io::Error| {
        Failure::Input(format!("cannot write manual pages to {}: {error}", path.display()))
    };
    fs::create_dir_all(folder).map_err(|error| cannot(folder, &error))?;
    for (name, page) in pages {
        let path = folder.join(format!("{name}.1"));
        fs::write(&path, page).map_err(|error| cannot(&path, &error))?;
    }
    Ok(())
}

/// The command line, without what is hidden from its help.
fn definition() -> clap::Command {
    let command = Cli::command();
    let visible: Vec<clap::Command> =
        command.get_subcommands().filter(|sub| !sub.is_hide_set()).cloned().collect();
    let bare = clap::Command::new("pintle")
        .version(pintle::VERSION)
        .about(command.get_about().cloned().unwrap_or_default())
        .after_help(command.get_after_help().cloned().unwrap_or_default());
    bare.subcommands(visible)
}

/// Every page by name, that of the program first.
fn pages() -> io::Result<Vec<(String, Vec<u8>)>> {
    let command = definition();
    let mut found = vec![("pintle".to_string(), page(command.clone())?)];
    for sub in command.get_subcommands() {
        let name = format!("pintle-{}", sub.get_name());
        let shown = format!("pintle {}", sub.get_name());
        let of_it = sub.clone().name(name.clone()).bin_name(shown).version(pintle::VERSION);
        found.push((name, page(of_it)?));
    }
    Ok(found)
}

/// One page; what stands after the options keeps its lines, for it has tables and examples.
fn page(command: clap::Command) -> io::Result<Vec<u8>> {
    let after = command.get_after_long_help().or_else(|| command.get_after_help()).map(ToString::to_string);
    let has_subcommands = command.has_subcommands();
    let man = clap_mangen::Man::new(command);
    let mut page = Vec::new();
    man.render_title(&mut page)?;
    man.render_name_section(&mut page)?;
    man.render_synopsis_section(&mut page)?;
    man.render_description_section(&mut page)?;
    man.render_options_section(&mut page)?;
    if has_subcommands {
        man.render_subcommands_section(&mut page)?;
    }
    if let Some(after) = after {
        let mut notes = Roff::new();
        notes.control("SH", ["NOTES"]);
        notes.control("nf", []);
        for line in after.lines() {
            notes.text([roman(line)]);
        }
        notes.control("fi", []);
        notes.to_writer(&mut page)?;
    }
    man.render_version_section(&mut page)?;
    Ok(page)
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::ValueEnum;

    fn commands() -> Vec<String> {
        let names: Vec<String> =
            definition().get_subcommands().map(|sub| sub.get_name().to_string()).collect();
        assert!(names.contains(&"eval".to_string()) && names.contains(&"man".to_string()), "{names:?}");
        names
    }

    #[test]
    fn completions_have_every_command_and_option() {
        for shell in Shell::value_variants() {
            let text = String::from_utf8(script(*shell)).unwrap();
            for command in definition().get_subcommands() {
                assert!(text.contains(command.get_name()), "{shell}: {}", command.get_name());
                for option in command.get_arguments().filter_map(clap::Arg::get_long) {
                    assert!(text.contains(option), "{shell}: {} --{option}", command.get_name());
                }
            }
            assert!(!text.contains("panic"), "{shell}");
        }
    }

    #[test]
    fn manual_pages_have_every_command_and_option() {
        let pages = pages().unwrap();
        let text = |name: &str| {
            let (_, page) = pages.iter().find(|(known, _)| known == name).unwrap();
            String::from_utf8(page.clone()).unwrap().replace("\\-", "-")
        };
        for name in commands() {
            assert!(text("pintle").contains(&format!("pintle-{name}(1)")), "{name}");
            assert!(text(&format!("pintle-{name}")).contains(&format!("pintle {name}")), "{name}");
        }
        for command in definition().get_subcommands() {
            let page = text(&format!("pintle-{}", command.get_name()));
            let visible = command.get_arguments().filter(|option| !option.is_hide_set());
            for option in visible.filter_map(clap::Arg::get_long) {
                assert!(page.contains(&format!("--{option}")), "{} --{option}", command.get_name());
            }
        }
        assert!(text("pintle").contains("70 internal error"));
        assert!(text("pintle-eval").contains("  CSLST          stop and lock status"));
        assert_eq!(pages.len(), commands().len() + 1);
    }
}

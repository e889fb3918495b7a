//! `pintle completions` and `pintle man`: written from the definition of the command line, so that they cannot fall behind it.

use super::{Cli, Failure, Files};
use clap::{Args, CommandFactory};
use clap_complete::Shell;
use clap_mangen::roff::{Roff, bold, roman};
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
pub(crate) fn man(arguments: &Man, files: Files) -> Result<(), Failure> {
    let pages = pages()?;
    if let Some(folder) = &arguments.folder {
        return save(folder, &pages, files);
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

fn save(folder: &Path, pages: &[(String, Vec<u8>)], files: Files) -> Result<(), Failure> {
    files.check_folder(Some(folder), "1")?;
    files.folder(folder)?;
    pages.iter().try_for_each(|(name, page)| files.text(&folder.join(format!("{name}.1")), page))
}

/// The command line as it parses, options of every command among those of each, without what is hidden from its help.
fn definition() -> clap::Command {
    let mut command = Cli::command();
    command.build();
    visible(&command)
}

/// A command with what its help shows, and nothing else.
fn visible(command: &clap::Command) -> clap::Command {
    let mut shown = clap::Command::new(command.get_name().to_string())
        .bin_name(command.get_bin_name().unwrap_or(command.get_name()).to_string())
        .about(command.get_about().cloned().unwrap_or_default())
        // Its arguments have them where the command line takes them.
        .disable_help_flag(true)
        .disable_version_flag(true)
        .disable_help_subcommand(true)
        .args(command.get_arguments().filter(|argument| !argument.is_hide_set()))
        .subcommands(command.get_subcommands().filter(|sub| !sub.is_hide_set()).map(visible));
    if let Some(version) = command.get_version() {
        shown = shown.version(version.to_string());
    }
    if let Some(long) = command.get_long_about() {
        shown = shown.long_about(long.clone());
    }
    if let Some(after) = command.get_after_help() {
        shown = shown.after_help(after.clone());
    }
    if let Some(after) = command.get_after_long_help() {
        shown = shown.after_long_help(after.clone());
    }
    shown
}

/// Every page by name, that of the program first.
fn pages() -> io::Result<Vec<(String, Vec<u8>)>> {
    let command = definition();
    let mut found = vec![("pintle".to_string(), page(&command, "pintle")?)];
    for sub in command.get_subcommands().filter(|sub| sub.get_name() != "help") {
        let name = format!("pintle-{}", sub.get_name());
        let page = page(sub, &name)?;
        found.push((name, page));
    }
    Ok(found)
}

/// How a command is called: every option with the names of its values, then what has no name.
fn synopsis(command: &clap::Command) -> Roff {
    let mut line = vec![bold(command.get_bin_name().unwrap_or_default())];
    let mut add = |text: String| line.extend([roman(" "), roman(text)]);
    for option in command.get_arguments().filter(|argument| !argument.is_positional()) {
        let short = option.get_short().map_or_else(String::new, |short| format!("-{short}|"));
        add(format!("[{short}{option}]"));
    }
    for positional in command.get_positionals() {
        add(positional.to_string());
    }
    if command.has_subcommands() {
        add("<COMMAND>".to_string());
    }
    let mut section = Roff::new();
    section.control("SH", ["SYNOPSIS"]);
    section.text(line);
    section
}

/// One page; what stands after the options keeps its lines, for it has tables and examples.
fn page(command: &clap::Command, name: &str) -> io::Result<Vec<u8>> {
    let after = command.get_after_long_help().or_else(|| command.get_after_help()).map(ToString::to_string);
    let man = clap_mangen::Man::new(command.clone().name(name.to_string()).version(crate::VERSION));
    let mut page = Vec::new();
    man.render_title(&mut page)?;
    man.render_name_section(&mut page)?;
    synopsis(command).to_writer(&mut page)?;
    man.render_description_section(&mut page)?;
    man.render_options_section(&mut page)?;
    if command.has_subcommands() {
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

    /// The options that the help of each command shows, as it is typed for.
    fn helped() -> Vec<(String, Vec<String>)> {
        let mut command = Cli::command();
        command.build();
        let options = |help: String| -> Vec<String> {
            let lines = help.lines().map(str::trim_start).filter(|line| line.starts_with('-'));
            let long = |line: &str| {
                let rest = line.split("--").nth(1)?;
                rest.split(|c: char| c != '-' && !c.is_ascii_alphanumeric()).next().map(str::to_string)
            };
            lines.filter_map(long).collect()
        };
        let shown =
            command.get_subcommands_mut().filter(|sub| !sub.is_hide_set() && sub.get_name() != "help");
        let found: Vec<(String, Vec<String>)> = shown
            .map(|sub| (sub.get_name().to_string(), options(sub.render_long_help().to_string())))
            .collect();
        let of =
            |name: &str| found.iter().find(|(known, _)| known == name).map(|(_, options)| options.clone());
        let audit = of("audit").unwrap();
        for option in ["threads", "deny", "help"] {
            assert!(audit.iter().any(|known| known == option), "{option}: {audit:?}");
        }
        assert!(of("man").is_some_and(|options| options.contains(&"folder".to_string())));
        found
    }

    /// The words of a text that look like long options.
    fn long_options(text: &str) -> std::collections::BTreeSet<String> {
        let after = text.split("--").skip(1).map(|rest| {
            rest.split(|c: char| c != '-' && !c.is_ascii_alphanumeric())
                .next()
                .unwrap_or_default()
                .to_string()
        });
        after.filter(|name| !name.is_empty()).collect()
    }

    #[test]
    fn completions_have_the_options_of_each_command_and_no_others() {
        let text = |shell| String::from_utf8(script(shell)).unwrap();
        let [bash, zsh, fish] = [Shell::Bash, Shell::Zsh, Shell::Fish].map(text);
        let mut asked = 0;
        for (command, options) in helped() {
            let options: std::collections::BTreeSet<String> = options.into_iter().collect();
            let start = bash.find(&format!("        pintle__subcmd__{command})\n            opts=")).unwrap();
            let line = bash[start..].lines().nth(1).unwrap();
            assert_eq!(long_options(line), options, "bash: {command}");
            let start = zsh.find(&format!("({command})\n_arguments")).unwrap();
            let section = &zsh[start..start + zsh[start..].find("&& ret=0").unwrap()];
            for option in &options {
                assert!(section.contains(&format!("--{option}")), "zsh: {command} --{option}");
                let line = format!("__fish_pintle_using_subcommand {command}\"");
                let mut lines = fish.lines().filter(|text| text.contains(&line));
                let option = format!(" -l {option}");
                assert!(lines.any(|line| line.contains(&option)), "fish: {command}{option}");
                asked += 1;
            }
        }
        assert!(asked > 160, "{asked}");
        for shell in Shell::value_variants() {
            let text = text(*shell);
            for hidden in ["plant", "panic"] {
                assert!(!text.contains(hidden), "{shell}: {hidden}");
            }
            for (command, options) in helped() {
                assert!(text.contains(&command), "{shell}: {command}");
                options
                    .iter()
                    .for_each(|option| assert!(text.contains(option), "{shell}: {command} --{option}"));
            }
        }
    }

    #[test]
    fn manual_pages_have_the_options_of_each_command_and_no_others() {
        let pages = pages().unwrap();
        let text = |name: &str| {
            let (_, page) = pages.iter().find(|(known, _)| known == name).unwrap();
            String::from_utf8(page.clone()).unwrap().replace("\\-", "-")
        };
        let all = helped();
        for (name, options) in &all {
            assert!(text("pintle").contains(&format!("pintle-{name}(1)")), "{name}");
            let page = text(&format!("pintle-{name}"));
            let section = |title: &str| {
                let from = page.split(&format!(".SH {title}\n")).nth(1).unwrap();
                from.split(".SH ").next().unwrap().to_string()
            };
            assert!(page.contains(&format!("pintle {name}")), "{name}");
            let options: std::collections::BTreeSet<String> = options.iter().cloned().collect();
            assert_eq!(long_options(&section("SYNOPSIS")), options, "{name}");
            for option in &options {
                assert!(section("OPTIONS").contains(&format!("--{option}")), "{name} --{option}");
            }
            assert!(!page.contains("--plant") && !page.contains("--version"), "{name}");
        }
        let audit = text("pintle-audit");
        assert!(audit.contains("[--deny <CODE[@FILE[:LINE]]>]") && audit.contains(" [SCENE]..."), "{audit}");
        assert!(
            text("pintle").contains(
                "\\fBpintle\\fR [--threads <COUNT>] [--force] [-h|--help] [-V|--version] <COMMAND>"
            )
        );
        assert!(text("pintle").contains("70 internal error") && !text("pintle").contains("panic"));
        assert!(text("pintle-eval").contains("  CSLST          stop and lock status"));
        assert_eq!(pages.len(), all.len() + 1);
    }
}

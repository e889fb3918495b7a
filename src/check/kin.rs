//! The processes that a process has started, whatever groups they made: found by a mark in their environment.
//!
//! Linux tells of every process what was in its environment when it began (`/proc`). Elsewhere nothing is found, and the group of the
//! process is what can be ended.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::atomic::{AtomicU64, Ordering};
use std::thread;
use std::time::Duration;

/// The variable that bears the mark.
const VARIABLE: &str = "PINTLE_CHECKED";

/// Processes with one mark.
#[derive(Debug)]
pub(crate) struct Kin {
    mark: String,
    /// What they write to.
    output: Option<PathBuf>,
}

impl Kin {
    /// Gives a command a mark that no other has.
    pub(crate) fn mark(command: &mut Command) -> Self {
        static COUNT: AtomicU64 = AtomicU64::new(0);
        let mark = format!("{}-{}", std::process::id(), COUNT.fetch_add(1, Ordering::Relaxed));
        command.env(VARIABLE, &mark);
        Self { mark, output: None }
    }

    /// They write to that pipe, by the number of the end that reads.
    pub(crate) fn write_to(&mut self, descriptor: i32) {
        self.output = fs::read_link(format!("/proc/self/fd/{descriptor}")).ok();
    }

    /// Those that there are.
    fn found(&self) -> Vec<PathBuf> {
        let bears = |folder: &PathBuf| {
            let environment = fs::read(folder.join("environ")).unwrap_or_default();
            environment.split(|byte| *byte == 0).any(|entry| {
                entry.strip_prefix(VARIABLE.as_bytes()).and_then(|rest| rest.strip_prefix(b"="))
                    == Some(self.mark.as_bytes())
            })
        };
        let folders = fs::read_dir("/proc").into_iter().flatten().flatten();
        folders
            .filter(|folder| number(&folder.path()).is_some())
            .map(|folder| folder.path())
            .filter(bears)
            .collect()
    }

    /// Whether none of them can write any more: shells that wait for others hold the pipe, and do not count.
    pub(crate) fn is_mute(&self) -> bool {
        let (Some(output), found) = (&self.output, self.found()) else { return false };
        let parents: Vec<Option<u32>> = found.iter().map(|folder| parent(folder)).collect();
        let waits = |folder: &&PathBuf| parents.contains(&number(folder));
        let holds = |folder: &PathBuf| {
            let open = fs::read_dir(folder.join("fd")).into_iter().flatten().flatten();
            open.filter_map(|end| fs::read_link(end.path()).ok()).any(|target| target == *output)
        };
        let last: Vec<&PathBuf> = found.iter().filter(|folder| !waits(folder)).collect();
        !last.is_empty() && !last.into_iter().any(holds)
    }

    /// Ends them all, those too that are started meanwhile.
    pub(crate) fn end(&self) {
        /// How often it is looked for more.
        const ROUNDS: usize = 50;
        for _ in 0..ROUNDS {
            let found: Vec<String> =
                self.found().iter().filter_map(|folder| number(folder)).map(|id| id.to_string()).collect();
            if found.is_empty() {
                return;
            }
            let _ = Command::new("kill").args(["-KILL", "--"]).args(found).stderr(Stdio::null()).status();
            thread::sleep(Duration::from_millis(2));
        }
    }
}

/// The number of a process, from its folder.
fn number(folder: &Path) -> Option<u32> {
    folder.file_name()?.to_str()?.parse().ok()
}

/// The parent of a process: the second field after its name, which stands in parentheses.
fn parent(folder: &Path) -> Option<u32> {
    let text = fs::read_to_string(folder.join("stat")).ok()?;
    text.rsplit_once(')')?.1.split_whitespace().nth(1)?.parse().ok()
}

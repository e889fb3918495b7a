//! The processes that a process has started, whatever groups they made: found by a mark in their environment.
//!
//! Linux tells of every process what was in its environment when it began (`/proc`). Elsewhere nothing is found, and the group of the
//! process is what can be ended.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::atomic::{AtomicU64, Ordering};
use std::thread;
use std::time::{Duration, SystemTime, UNIX_EPOCH};

/// The variable that bears the mark.
const VARIABLE: &str = "PINTLE_CHECKED";

/// Processes with one mark.
#[derive(Debug)]
pub(crate) struct Kin {
    mark: String,
    /// What they write to.
    output: Option<PathBuf>,
    /// The shell that was started.
    shell: u32,
}

impl Kin {
    /// Gives a command a mark that no other has. It begins with that of this process, if a check started it.
    pub(crate) fn mark(command: &mut Command) -> Self {
        static COUNT: AtomicU64 = AtomicU64::new(0);
        let outer = std::env::var(VARIABLE).map(|outer| outer + "/").unwrap_or_default();
        let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default().as_nanos();
        let count = COUNT.fetch_add(1, Ordering::Relaxed);
        let mark = format!("{outer}{}-{since}-{count}", std::process::id());
        command.env(VARIABLE, &mark);
        Self { mark, output: None, shell: 0 }
    }

    /// What that process starts writes to its pipe, by the number of the end that reads.
    pub(crate) fn write_to(&mut self, descriptor: i32, shell: u32) {
        (self.output, self.shell) = (fs::read_link(format!("/proc/self/fd/{descriptor}")).ok(), shell);
    }

    /// Those that there are.
    fn found(&self) -> Vec<PathBuf> {
        let bears = |folder: &PathBuf| {
            let environment = fs::read(folder.join("environ")).unwrap_or_default();
            let marks = environment.split(|byte| *byte == 0).filter_map(|entry| {
                entry
                    .strip_prefix(VARIABLE.as_bytes())?
                    .strip_prefix(b"=")?
                    .strip_prefix(self.mark.as_bytes())
            });
            // Its own, or one that begins with it.
            marks.into_iter().any(|rest| matches!(rest, [] | [b'/', ..]))
        };
        let folders = fs::read_dir("/proc").into_iter().flatten().flatten();
        folders
            .filter(|folder| number(&folder.path()).is_some())
            .map(|folder| folder.path())
            .filter(bears)
            .collect()
    }

    /// Whether none of them can write any more: the shell that only waits for others holds the pipe, and does not count.
    pub(crate) fn is_mute(&self) -> bool {
        let Some(output) = &self.output else { return false };
        let waits = |folder: &PathBuf| {
            let line = fs::read(folder.join("cmdline")).unwrap_or_default();
            number(folder) == Some(self.shell) && line.starts_with(b"sh\0-c\0")
        };
        let holds = |folder: &PathBuf| {
            let open = fs::read_dir(folder.join("fd")).into_iter().flatten().flatten();
            open.filter_map(|end| fs::read_link(end.path()).ok()).any(|target| target == *output)
        };
        let others: Vec<PathBuf> = self.found().into_iter().filter(|folder| !waits(folder)).collect();
        !others.is_empty() && !others.iter().any(holds)
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

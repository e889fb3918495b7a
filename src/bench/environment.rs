//! The machine and the program.

use serde::{Deserialize, Serialize};
use std::borrow::Cow;
use std::fs;

/// What numbers were measured on, by what and when.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Environment {
    /// The version of pintle.
    pub pintle: Cow<'static, str>,
    /// The commit that it was built from, with a mark where its sources had changes; none of a crate from a registry.
    #[serde(default)]
    pub commit: Option<Cow<'static, str>>,
    /// The day, UTC: 2026-01-31.
    pub date: String,
    /// The processor's own name, as far as the system tells it.
    pub processor: String,
    /// The vector units that it has, of those that matter here.
    pub features: Vec<Cow<'static, str>>,
    /// Its cores that are online.
    pub cores: usize,
    /// Those of them that this program may use.
    pub usable: usize,
    /// What runs or waits on them, averaged over a minute, where the system tells it.
    pub load: Option<f64>,
    /// Operating system and architecture.
    pub system: String,
    /// The compiler.
    pub rustc: Cow<'static, str>,
    /// The target that it compiled for.
    pub target: Cow<'static, str>,
    /// Whether it was asked for the fastest program: if not, times mean little.
    pub is_optimised: bool,
}

impl Environment {
    /// This machine and program, now.
    pub fn here() -> Self {
        Self {
            pintle: pintle_kinematics::VERSION.into(),
            commit: crate::COMMIT.map(Into::into),
            date: chrono::Utc::now().format("%Y-%m-%d").to_string(),
            processor: processor(),
            features: features(),
            cores: online().unwrap_or_else(usable),
            usable: usable(),
            load: fs::read_to_string("/proc/loadavg")
                .ok()
                .and_then(|text| text.split_whitespace().next()?.parse().ok()),
            system: format!("{} {}", std::env::consts::OS, std::env::consts::ARCH),
            rustc: env!("PINTLE_RUSTC").into(),
            target: env!("PINTLE_TARGET").into(),
            is_optimised: env!("PINTLE_OPT_LEVEL") == "3" && !cfg!(debug_assertions),
        }
    }

    /// Machine, day and commit.
    pub fn short(&self) -> String {
        let features =
            if self.features.is_empty() { String::new() } else { format!(" ({})", self.features.join("/")) };
        let version = self.commit.as_ref().unwrap_or(&self.pintle);
        format!("{}{features}, {}, pintle {version}", self.processor, self.date)
    }

    /// In one line.
    pub fn line(&self) -> String {
        let load = self.load.map_or_else(String::new, |load| format!(", load {load:.1}"));
        let features =
            if self.features.is_empty() { String::new() } else { format!(" ({})", self.features.join("/")) };
        let commit = self.commit.as_ref().map_or_else(String::new, |commit| format!(" ({commit})"));
        let Self { date, processor, cores, usable, system, rustc, pintle, .. } = self;
        let bound = if usable < cores { format!(", bound to {usable} of them") } else { String::new() };
        format!(
            "{date}, {processor}{features}, one of {cores} cores{bound}{load}, {system}; pintle {pintle}{commit}, {rustc}"
        )
    }
}

/// The cores that this process may run on.
fn usable() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}

/// The cores of the machine, where the system tells them as ranges: `0-3,8`.
fn online() -> Option<usize> {
    let text = fs::read_to_string("/sys/devices/system/cpu/online").ok()?;
    count(text.trim())
}

fn count(ranges: &str) -> Option<usize> {
    let of = |range: &str| {
        let (from, to) = range.split_once('-').unwrap_or((range, range));
        to.parse::<usize>().ok()?.checked_sub(from.parse().ok()?).map(|more| more + 1)
    };
    ranges.split(',').map(of).sum()
}

fn processor() -> String {
    let text = fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let line = text.lines().find(|line| line.starts_with("model name") || line.starts_with("Model"));
    let name = line.and_then(|line| line.split_once(':')).map(|(_, name)| name.trim());
    name.map_or_else(|| std::env::consts::ARCH.to_string(), str::to_string)
}

#[cfg(target_arch = "x86_64")]
fn features() -> Vec<Cow<'static, str>> {
    let all = [
        ("AVX2", std::is_x86_feature_detected!("avx2")),
        ("FMA", std::is_x86_feature_detected!("fma")),
        ("AVX-512", std::is_x86_feature_detected!("avx512f")),
    ];
    all.into_iter().filter(|(_, has)| *has).map(|(name, _)| name.into()).collect()
}

#[cfg(not(target_arch = "x86_64"))]
fn features() -> Vec<Cow<'static, str>> {
    Vec::new()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cores_are_those_of_the_machine() {
        assert_eq!(
            ["0-3", "0-3,8,10-11", "0", "", "3-1"].map(count),
            [Some(4), Some(7), Some(1), None, None]
        );
        let here = Environment::here();
        assert!(here.usable <= here.cores, "{here:?}");
    }
}

//! The file in which a run is kept: both of its methods, replaced as a whole, so that it is whole at any time.

use crate::cli::{Failure, Files};
use pintle_scene::{Format, Scene};
use pintle_solve::{Keeping, Kept, Number, Options};
use serde::{Deserialize, Serialize};
use serde_json::value::RawValue;
use std::path::Path;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Duration;

/// The version of its form.
const SCHEMA: &str = "pintle-run/1";

/// How often it is written.
const EVERY: Duration = Duration::from_millis(500);

#[derive(Serialize, Deserialize)]
struct Document {
    schema: String,
    version: String,
    /// The scene and what was asked for.
    of: String,
    methods: [Option<Box<RawValue>>; 2],
}

/// What is kept of each method, and the first failure.
type Now = ([Option<Box<RawValue>>; 2], Option<Failure>);

/// A run that is kept.
pub(super) struct Book<'a> {
    path: &'a Path,
    of: String,
    now: Mutex<Now>,
}

impl<'a> Book<'a> {
    /// A new one, or the one of a file to go on with.
    pub(super) fn open(
        path: &'a Path,
        is_there: bool,
        scene: &Scene,
        options: &Options,
    ) -> Result<Self, Failure> {
        let of = fingerprint(scene, options);
        let mut methods = [None, None];
        if is_there {
            let named = |why: &str| Failure::Input(format!("{}: {why}", path.display()));
            let text = std::fs::read_to_string(path).map_err(|error| named(&error.to_string()))?;
            let found: Document = serde_json::from_str(&text)
                .map_err(|error| named(&format!("{error}; it is to be a file that --keep wrote")))?;
            if found.schema != SCHEMA || found.version != pintle_kinematics::VERSION {
                return Err(named("another version of pintle kept it: begin again with --keep"));
            }
            if found.of != of {
                return Err(named(
                    "it was kept of another scene, or with other options: give the same ones, or begin again with --keep",
                ));
            }
            methods = found.methods;
        }
        Ok(Self { path, of, now: Mutex::new((methods, None)) })
    }

    fn now(&self) -> MutexGuard<'_, Now> {
        self.now.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Where a method was.
    pub(super) fn from<R: Number>(&self, method: usize) -> Result<Option<Kept<R>>, Failure> {
        let now = self.now();
        let read = |text: &RawValue| {
            serde_json::from_str(text.get())
                .map_err(|error| Failure::Input(format!("{}: {error}", self.path.display())))
        };
        now.0[method].as_deref().map(read).transpose()
    }

    /// Keeps a method.
    pub(super) fn keeping<R: Number>(&self, method: usize) -> Keeping<'_, R> {
        Keeping::new(EVERY, move |kept: Kept<R>| {
            let Ok(text) = serde_json::value::to_raw_value(&kept) else { return };
            let mut now = self.now();
            now.0[method] = Some(text);
            let document = Document {
                schema: SCHEMA.to_string(),
                version: pintle_kinematics::VERSION.to_string(),
                of: self.of.clone(),
                methods: now.0.clone(),
            };
            let written = serde_json::to_string(&document)
                .map_err(|error| Failure::Output(error.into()))
                .and_then(|text| Files::new(true).text(self.path, text));
            if let Err(failure) = written {
                now.1.get_or_insert(failure);
            }
        })
    }

    /// Whether all of it could be written.
    pub(super) fn close(self) -> Result<(), Failure> {
        let (_, failure) = self.now.into_inner().unwrap_or_else(PoisonError::into_inner);
        failure.map_or(Ok(()), Err)
    }
}

/// What a run depends on, in few letters: FNV-1a of the scene and the options.
fn fingerprint(scene: &Scene, options: &Options) -> String {
    let text = scene.write(Format::Json).map_or_else(|_| scene.name.clone(), |written| written.text);
    let Options { digits, until, times, from, stick, .. } = options;
    let asked = format!("{digits} {until:?} {times:?} {from:?} {stick:?}");
    let all = text.bytes().chain(asked.bytes());
    let hash = all
        .fold(0xcbf2_9ce4_8422_2325_u64, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x100_0000_01b3));
    format!("{hash:016x}")
}

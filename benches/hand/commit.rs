//! Which commit a program was built from: what `scripts/measure.py` writes beside its numbers.

/// Where `--commit` is all that is asked for, prints it, or `none` where the program knows none, and says so.
pub(crate) fn is_told() -> bool {
    let is_asked = std::env::args().skip(1).eq(["--commit"]);
    if is_asked {
        println!("{}", pintle_bench::COMMIT.unwrap_or("none"));
    }
    is_asked
}

//! Matrices in files: Matrix Market text, dense arrays and sparse matrices of NumPy and SciPy.

use crate::numpy::{Array, arrays};
use crate::printed::Printed;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufRead, BufReader};
use std::path::Path;

/// A matrix by its entries; those that are not in it are zero.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Entries {
    pub(crate) rows: usize,
    pub(crate) columns: usize,
    pub(crate) at: BTreeMap<(usize, usize), Printed>,
}

impl Entries {
    fn put(&mut self, (i, j): (usize, usize), x: Printed) -> Result<(), String> {
        if i >= self.rows || j >= self.columns {
            return Err(format!("entry {}, {} is outside of {} × {}", i + 1, j + 1, self.rows, self.columns));
        }
        // Entries that come twice add up, as SciPy has it.
        let entry = self.at.entry((i, j)).or_default();
        *entry = Printed { x: entry.x + x.x, half: entry.half + x.half };
        Ok(())
    }
}

/// Whether arrays are a matrix, and not columns of a table.
pub(crate) fn is_matrix(all: &[Array], is_known: impl Fn(&str) -> bool) -> bool {
    let is_sparse = |of: &Array| matches!(of.name.as_str(), "indptr" | "row");
    match all {
        [one] if one.name.is_empty() => one.fields == [String::new()],
        all => all.iter().any(is_sparse) || !all.iter().any(|of| is_known(&of.name)),
    }
}

/// The matrices of a file: one, or one for each state.
///
/// # Errors
/// What is none, and where.
pub(crate) fn read(path: &Path) -> Result<Vec<Entries>, String> {
    let named = |why: String| format!("{}: {why}", path.display());
    if path.extension().is_some_and(|of| of.eq_ignore_ascii_case("mtx")) {
        let file = File::open(path).map_err(|error| format!("cannot read {}: {error}", path.display()))?;
        return Ok(vec![
            market(BufReader::new(file))
                .map_err(|(line, why)| format!("{}:{line}: {why}", path.display()))?,
        ]);
    }
    let (mut all, format) = arrays(path)?;
    if all.iter().any(|of| matches!(of.name.as_str(), "indptr" | "row")) {
        return Ok(vec![sparse(&mut all, format.as_deref()).map_err(named)?]);
    }
    let [one] = all.as_mut_slice() else {
        let names: Vec<&str> = all.iter().map(|of| of.name.as_str()).collect();
        return Err(named(format!("which of its arrays is the matrix? They are {}", names.join(", "))));
    };
    dense(one).map_err(named)
}

fn dense(one: &mut Array) -> Result<Vec<Entries>, String> {
    let (count, rows, columns) = match one.shape.as_slice() {
        [rows, columns] => (1, *rows, *columns),
        [count, rows, columns] => (*count, *rows, *columns),
        shape => {
            return Err(format!(
                "an array of {} dimensions is no matrix: it is to have two, or three with that of states first",
                shape.len()
            ));
        }
    };
    let mut found = vec![Entries { rows, columns, at: BTreeMap::new() }; count];
    for n in 0..count * rows * columns {
        let Some(x) = one.next()?.and_then(|record| record.first().copied()) else {
            return Err(format!("it ends after {n} of {} numbers", count * rows * columns));
        };
        let (of, i, j) = if one.is_fortran {
            (n % count, n / count % rows, n / count / rows)
        } else {
            (n / columns / rows, n / columns % rows, n % columns)
        };
        if x.x != 0.0 {
            found[of].put((i, j), x)?;
        }
    }
    Ok(found)
}

/// A matrix as `scipy.sparse.save_npz` writes it.
fn sparse(all: &mut [Array], format: Option<&str>) -> Result<Entries, String> {
    let mut list = |name: &str| -> Result<Vec<Printed>, String> {
        let array =
            all.iter_mut().find(|of| of.name == name).ok_or(format!("a sparse matrix without {name}"))?;
        let count = array.shape.iter().product();
        array.take(count)
    };
    let whole = |of: Vec<Printed>| of.into_iter().map(|x| x.x as usize).collect::<Vec<usize>>();
    let [rows, columns] =
        <[usize; 2]>::try_from(whole(list("shape")?)).map_err(|_| "its shape is no pair".to_string())?;
    let mut found = Entries { rows, columns, at: BTreeMap::new() };
    let data = list("data")?;
    let places: Vec<(usize, usize)> = match format {
        Some("coo") => whole(list("row")?).into_iter().zip(whole(list("col")?)).collect(),
        Some(of @ ("csr" | "csc")) => {
            let (starts, inner) = (whole(list("indptr")?), whole(list("indices")?));
            let outer =
                starts.windows(2).enumerate().flat_map(|(n, pair)| (pair[0]..pair[1]).map(move |_| n));
            let both = outer.zip(inner);
            if of == "csr" { both.collect() } else { both.map(|(j, i)| (i, j)).collect() }
        }
        other => {
            return Err(format!("a sparse matrix of format {other:?} is not read; csr, csc and coo are"));
        }
    };
    if places.len() != data.len() {
        return Err(format!("{} places, and {} numbers", places.len(), data.len()));
    }
    for (place, x) in places.into_iter().zip(data) {
        found.put(place, x)?;
    }
    Ok(found)
}

/// Matrix Market text: coordinates or an array, general, symmetric or skew-symmetric.
fn market(from: impl BufRead) -> Result<Entries, (usize, String)> {
    let mut lines = from.lines().enumerate().map(|(n, line)| (n + 1, line));
    let mut next = move || -> Result<Option<(usize, String)>, (usize, String)> {
        match lines.next() {
            None => Ok(None),
            Some((n, line)) => line.map(|line| Some((n, line))).map_err(|error| (n, error.to_string())),
        }
    };
    let head = next()?.map(|(_, line)| line.to_ascii_lowercase()).unwrap_or_default();
    let words: Vec<&str> = head.split_whitespace().collect();
    let [
        "%%matrixmarket",
        "matrix",
        format @ ("coordinate" | "array"),
        "real" | "integer" | "double",
        symmetry,
    ] = words.as_slice()
    else {
        return Err((1, format!("{head:?} is no head of a real matrix in Matrix Market text")));
    };
    let is_list = *format == "coordinate";
    let mirrored = match *symmetry {
        "general" => None,
        "symmetric" => Some(1.0),
        "skew-symmetric" => Some(-1.0),
        other => return Err((1, format!("a matrix that is {other} is not read"))),
    };
    let (mut found, mut left, mut place) = (None::<Entries>, 0_usize, (0, 0));
    while let Some((n, line)) = next()? {
        let text = line.trim();
        if text.is_empty() || text.starts_with('%') {
            continue;
        }
        let words: Vec<&str> = text.split_whitespace().collect();
        let whole = |at: usize| -> Result<usize, (usize, String)> {
            let word = words.get(at).copied().unwrap_or("");
            word.parse().map_err(|_| (n, format!("{word:?} is no whole number")))
        };
        let Some(entries) = &mut found else {
            let (rows, columns) = (whole(0)?, whole(1)?);
            left = if is_list {
                whole(2)?
            } else if mirrored.is_some() {
                rows * (rows + 1) / 2
            } else {
                rows.saturating_mul(columns)
            };
            found = Some(Entries { rows, columns, at: BTreeMap::new() });
            continue;
        };
        if left == 0 {
            return Err((n, "there are more entries than the head says".into()));
        }
        left -= 1;
        let at = if is_list {
            let (i, j) = (whole(0)?, whole(1)?);
            (i.wrapping_sub(1), j.wrapping_sub(1))
        } else {
            let now = place;
            place.0 += 1;
            if place.0 >= entries.rows {
                place = (if mirrored.is_some() { place.1 + 1 } else { 0 }, place.1 + 1);
            }
            now
        };
        let word = words.last().copied().unwrap_or("");
        let x = Printed::parse(word).ok_or_else(|| (n, format!("{word:?} is no number")))?;
        entries.put(at, x).map_err(|why| (n, why))?;
        if let Some(sign) = mirrored.filter(|_| at.0 != at.1) {
            entries.put((at.1, at.0), x.times(sign)).map_err(|why| (n, why))?;
        }
    }
    match found {
        Some(found) if left == 0 => Ok(found),
        Some(_) => Err((0, format!("{left} entries are missing at its end"))),
        None => Err((0, "there is no matrix in it".into())),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn matrix_market_is_read() {
        let text = "%%MatrixMarket matrix coordinate real symmetric\n% a comment\n2 2 2\n1 1 2.50\n2 1 -1\n";
        let found = market(text.as_bytes()).unwrap();
        assert_eq!(found.at[&(0, 1)].x, -1.0);
        assert_eq!(found.at[&(1, 0)], found.at[&(0, 1)]);
        assert!((found.at[&(0, 0)].half - 0.005).abs() < 1e-15);
        let text = "%%MatrixMarket matrix array real general\n2 2\n1\n2\n3\n4\n";
        let found = market(text.as_bytes()).unwrap();
        assert_eq!((found.at[&(1, 0)].x, found.at[&(0, 1)].x), (2.0, 3.0));
        for (wrong, line) in [
            ("%%MatrixMarket matrix coordinate complex general\n", 1),
            ("%%MatrixMarket matrix coordinate real general\n2 2 1\n3 1 1.0\n", 3),
            ("%%MatrixMarket matrix coordinate real general\n2 2 1\n1 1 x\n", 3),
            ("%%MatrixMarket matrix coordinate real general\n2 2 2\n1 1 1.\n", 0),
        ] {
            assert_eq!(market(wrong.as_bytes()).unwrap_err().0, line, "{wrong}");
        }
    }
}

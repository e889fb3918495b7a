//! `*PARAMETER`: names for numbers, and their plain arithmetic.

use std::collections::HashMap;

/// The longest text of an expression, and how deep parentheses and signs may lie in it.
const LONGEST: usize = 1000;
const DEEPEST: usize = 50;

/// What may stand before parentheses.
type Function = fn(f64) -> f64;
const FUNCTIONS: [(&str, Function); 11] = [
    ("abs", f64::abs),
    ("acos", f64::acos),
    ("asin", f64::asin),
    ("atan", f64::atan),
    ("cos", f64::cos),
    ("exp", f64::exp),
    ("log", f64::ln),
    ("log10", f64::log10),
    ("sin", f64::sin),
    ("sqrt", f64::sqrt),
    ("tan", f64::tan),
];

/// What a parameter stands for.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Number {
    Whole(i64),
    Real(f64),
}

use Number::{Real, Whole};

/// Parameters by name.
#[derive(Debug, Clone, Default)]
pub(crate) struct Parameters {
    numbers: HashMap<String, Number>,
    /// Those in quotation marks.
    texts: HashMap<String, String>,
}

impl Parameters {
    /// Reads a line `name = expression`. False if it is nothing, or more than a text, or than numbers, names, `+ - * / // % **`, parentheses,
    /// [`FUNCTIONS`] and those of Python that give the same to everybody.
    pub(crate) fn define(&mut self, line: &str) -> bool {
        let line = line.split('#').next().unwrap_or_default().trim();
        let Some((name, expression)) = line.split_once('=') else { return line.is_empty() };
        let name = name.trim();
        self.numbers.remove(name);
        self.texts.remove(name);
        if !is_name(name) {
            return false;
        }
        if let Some(text) = quoted(expression.trim()) {
            self.texts.insert(name.to_owned(), text.to_owned());
            return true;
        }
        let value = self.value(expression);
        value.map(|value| self.numbers.insert(name.to_owned(), value)).is_some()
    }

    fn value(&self, text: &str) -> Option<Number> {
        let mut expression = Expression { parameters: self, rest: text.trim_start(), depth: 0 };
        let value = expression.sum().filter(|_| text.len() <= LONGEST)?;
        expression.rest.is_empty().then_some(value)
    }

    fn shown(&self, name: &str) -> Option<String> {
        match self.numbers.get(name) {
            Some(Whole(number)) => Some(number.to_string()),
            Some(Real(number)) => Some(format!("{number:?}")),
            None => self.texts.get(name).cloned(),
        }
    }

    /// Puts numbers and texts in the place of `<name>`; whether there was one. Names that are not known stay.
    pub(super) fn replace(&self, line: &mut Vec<u8>) -> bool {
        if (self.numbers.is_empty() && self.texts.is_empty()) || !line.contains(&b'<') {
            return false;
        }
        let Ok(text) = std::str::from_utf8(line) else { return false };
        let mut replaced = String::with_capacity(text.len());
        let mut rest = text;
        let mut any = false;
        while let Some((before, after)) = rest.split_once('<') {
            replaced.push_str(before);
            let known =
                after.split_once('>').and_then(|(name, after)| Some((self.shown(name.trim())?, after)));
            match known {
                Some((shown, after)) => {
                    replaced.push_str(&shown);
                    (rest, any) = (after, true);
                }
                None => {
                    replaced.push('<');
                    rest = after;
                }
            }
        }
        replaced.push_str(rest);
        *line = replaced.into_bytes();
        any
    }
}

/// What stands between quotation marks, if that is all.
fn quoted(text: &str) -> Option<&str> {
    let of = |mark: char| text.strip_prefix(mark)?.strip_suffix(mark).filter(|inner| !inner.contains(mark));
    of('\'').or_else(|| of('"'))
}

fn is_name(text: &str) -> bool {
    text.starts_with(|letter: char| letter.is_ascii_alphabetic() || letter == '_')
        && text.bytes().all(|byte| byte.is_ascii_alphanumeric() || byte == b'_')
}

/// An expression that is being read, by the rules of precedence that Python has.
struct Expression<'a> {
    parameters: &'a Parameters,
    rest: &'a str,
    depth: usize,
}

impl Expression<'_> {
    fn take(&mut self, sign: &str) -> bool {
        let rest = self.rest.strip_prefix(sign);
        self.rest = rest.unwrap_or(self.rest).trim_start();
        rest.is_some()
    }

    fn sum(&mut self) -> Option<Number> {
        let mut sum = self.product()?;
        loop {
            if self.take("+") {
                sum = combined(sum, self.product()?, i64::checked_add, |a, b| a + b)?;
            } else if self.take("-") {
                sum = combined(sum, self.product()?, i64::checked_sub, |a, b| a - b)?;
            } else {
                return Some(sum);
            }
        }
    }

    fn product(&mut self) -> Option<Number> {
        let mut product = self.signed()?;
        loop {
            if self.take("//") {
                let floor = |a: i64, b: i64| Some(a.checked_div_euclid(b)? - i64::from(b < 0 && a % b != 0));
                product = combined(product, self.signed()?, floor, |a, b| (a / b).floor())?;
            } else if self.take("%") {
                let rest = |a: i64, b: i64| {
                    let rest = a.checked_rem_euclid(b)?;
                    Some(if b < 0 && rest != 0 { rest + b } else { rest })
                };
                product = combined(product, self.signed()?, rest, |a, b| a - b * (a / b).floor())?;
            } else if self.take("*") {
                product = combined(product, self.signed()?, i64::checked_mul, |a, b| a * b)?;
            } else if self.take("/") {
                // What a division of whole numbers that leaves a rest gives depends on who reads it.
                let exact = |a: i64, b: i64| (b != 0 && a % b == 0).then(|| a / b);
                product = combined(product, self.signed()?, exact, |a, b| a / b)?;
            } else {
                return Some(product);
            }
        }
    }

    fn signed(&mut self) -> Option<Number> {
        self.depth += 1;
        if self.depth > DEEPEST {
            return None;
        }
        let value = if self.take("-") {
            combined(Whole(0), self.signed()?, i64::checked_sub, |_, b| -b)
        } else if self.take("+") {
            self.signed()
        } else {
            self.power()
        };
        self.depth -= 1;
        value
    }

    fn power(&mut self) -> Option<Number> {
        let base = self.atom()?;
        if !self.take("**") {
            return Some(base);
        }
        let exponent = self.signed()?;
        let whole = |a: i64, b: i64| a.checked_pow(u32::try_from(b).ok()?);
        combined(base, exponent, whole, f64::powf)
    }

    fn atom(&mut self) -> Option<Number> {
        if self.take("(") {
            let value = self.sum()?;
            return self.take(")").then_some(value);
        }
        let first = self.rest.bytes().next()?;
        if first.is_ascii_alphabetic() || first == b'_' {
            let letter = |byte: u8| byte.is_ascii_alphanumeric() || byte == b'_';
            let end = self.rest.bytes().position(|byte| !letter(byte)).unwrap_or(self.rest.len());
            let (name, rest) = self.rest.split_at(end);
            self.rest = rest.trim_start();
            if self.take("(") {
                let mut arguments = vec![self.sum()?];
                while self.take(",") {
                    arguments.push(self.sum()?);
                }
                return if self.take(")") { called(name, &arguments) } else { None };
            }
            return self.parameters.numbers.get(name).copied();
        }
        let bytes = self.rest.as_bytes();
        let end = (0..bytes.len()).find(|&place| match bytes[place] {
            b'+' | b'-' => !(place > 0 && matches!(bytes[place - 1], b'e' | b'E')),
            byte => !(byte.is_ascii_digit() || matches!(byte, b'.' | b'e' | b'E')),
        });
        let (number, rest) = self.rest.split_at(end.unwrap_or(bytes.len()));
        self.rest = rest.trim_start();
        let real = || super::parse_number(number).ok().map(Real);
        number.parse().ok().map(Whole).or_else(real)
    }
}

/// What a function gives.
fn called(name: &str, arguments: &[Number]) -> Option<Number> {
    let double = |number: &Number| match *number {
        Whole(number) => number as f64,
        Real(number) => number,
    };
    match (name, arguments) {
        ("int", [Real(x)]) => (x.abs() < 9e15).then(|| Whole(x.trunc() as i64)),
        ("int", [x @ Whole(_)]) => Some(*x),
        ("float", [x]) => Some(Real(double(x))),
        ("pow", [a, b]) => {
            let whole = |a: i64, b: i64| a.checked_pow(u32::try_from(b).ok()?);
            combined(*a, *b, whole, f64::powf)
        }
        ("min", [first, rest @ ..]) => {
            Some(*rest.iter().fold(first, |least, x| if double(x) < double(least) { x } else { least }))
        }
        ("max", [first, rest @ ..]) => {
            Some(*rest.iter().fold(first, |most, x| if double(x) > double(most) { x } else { most }))
        }
        (_, [argument]) => {
            let (_, of) = FUNCTIONS.iter().find(|(known, _)| *known == name)?;
            combined(Real(0.0), *argument, |_, _| None, |_, x| of(x))
        }
        _ => None,
    }
}

/// Two numbers in one: whole where both are, nothing where the result is not a finite number.
fn combined(
    a: Number,
    b: Number,
    whole: impl Fn(i64, i64) -> Option<i64>,
    real: impl Fn(f64, f64) -> f64,
) -> Option<Number> {
    let double = |number| match number {
        Whole(number) => number as f64,
        Real(number) => number,
    };
    match (a, b) {
        (Whole(a), Whole(b)) => whole(a, b).map(Whole),
        (a, b) => Some(real(double(a), double(b))).filter(|value| value.is_finite()).map(Real),
    }
}

#[cfg(test)]
mod tests {
    use super::Parameters;

    #[test]
    fn plain_arithmetic_is_read() {
        let mut parameters = Parameters::default();
        let lines = [
            ("a = 2", true, "2"),
            ("b = 2.5", true, "2.5"),
            ("c = a + b*2", true, "7.0"),
            ("d = -(a + 1)**2 # a comment", true, "-9"),
            ("e = 2**-1.", true, "0.5"),
            ("f = 10/5*3 - 1e-1", true, "5.9"),
            ("g = 7/2", false, "<g>"),
            ("h = 3*sqrt(a + 2)", true, "6.0"),
            ("n = cos(0) - abs(-1.5)", true, "-0.5"),
            ("o = sqrt(-1.)", false, "<o>"),
            ("p = sinc(1.)", false, "<p>"),
            ("q = sqrt 4", false, "<q>"),
            ("r = log(0)", false, "<r>"),
            ("i = 1/0.", false, "<i>"),
            ("j = 'name'", true, "name"),
            ("j1 = \"OZ 1\"", true, "OZ 1"),
            ("j2 = 'a' + 'b'", false, "<j2>"),
            ("k = a b", false, "<k>"),
            ("l = 2**3**2", true, "512"),
            ("m = 8//2", true, "4"),
            ("m1 = -7//2", true, "-4"),
            ("m2 = 7//-2", true, "-4"),
            ("m3 = -7 % 3", true, "2"),
            ("m4 = 7 % -3", true, "-2"),
            ("m5 = 7.5//2", true, "3.0"),
            ("m6 = 1//0", false, "<m6>"),
            ("n1 = int(2.9) + float(1)", true, "3.0"),
            ("n2 = pow(2, 5)", true, "32"),
            ("n3 = max(1, 2.5, 2)", true, "2.5"),
            ("n4 = min(3, 1, 2)", true, "1"),
            ("n5 = int(1, 2)", false, "<n5>"),
            ("a = b - 1", true, "1.5"),
        ];
        for (line, is_plain, shown) in lines {
            assert_eq!(parameters.define(line), is_plain, "{line}");
            let name = line.split(' ').next().unwrap();
            let mut text = format!("1, <{name}>, < {name} >").into_bytes();
            assert_eq!(parameters.replace(&mut text), is_plain);
            let expected =
                if is_plain { format!("1, {shown}, {shown}") } else { format!("1, {shown}, < {name} >") };
            assert_eq!(String::from_utf8(text).unwrap(), expected);
        }
        let deep = format!("z = {}1", "-".repeat(100_000));
        assert!(!parameters.define(&deep) && !parameters.define(&format!("z = {}", "(".repeat(100_000))));
    }
}

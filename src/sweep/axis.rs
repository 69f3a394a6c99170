//! A parameter that varies, and its values as people write them.

use super::AxisError;
use crate::run::{COLONIES, ELEMENTS, Settings};

/// The letters of the thesis for the parameters that it varies, and their names.
pub const SYMBOLS: [(&str, &str); 3] = [("L", "curvature-radius"), ("B", "bias"), ("A", "gain")];

/// Settings that are no axes, and what to do instead.
const FIXED: [(&str, &str); 7] = [
    (
        "seed",
        "several seeds a cell are seeds = N of the grid (--seeds N)",
    ),
    ("mesh", "a sweep is on one mesh"),
    ("mesh-hash", "a sweep is on one mesh"),
    ("mesh-up", "a sweep is on one mesh"),
    (
        "mask",
        "all lichens of a sweep grow with the same masks: make a sweep for each",
    ),
    (
        "mask-hash",
        "all lichens of a sweep grow with the same masks",
    ),
    ("version", "it says which program made a recipe"),
];

/// Most values of a range.
const MOST: usize = 10_000;

/// A setting and the values that it takes, in order.
#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    /// The setting's key in a recipe.
    key: &'static str,
    values: Vec<AxisValue>,
}

/// One value of an axis.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AxisValue {
    /// As TOML.
    literal: String,
    /// As people read it.
    label: String,
}

impl AxisValue {
    /// The value as people read it: `10r`, `0.5`, `foliose`.
    pub fn label(&self) -> &str {
        &self.label
    }

    /// The number in it, and its unit: `r`, `%` or nothing.
    pub fn number(&self) -> Option<(f64, &str)> {
        split_unit(&self.label)
    }

    /// Of a word of a list: a number, or else a text.
    fn of_word(key: &str, word: &str) -> Self {
        Self::of_toml(
            key,
            &match (word.parse::<i64>(), word.parse::<f64>()) {
                (Ok(whole), _) => toml::Value::Integer(whole),
                (_, Ok(number)) if number.is_finite() => toml::Value::Float(number),
                _ => toml::Value::String(word.to_owned()),
            },
        )
    }

    /// The same label, however a number was written. Counts are whole: 1e3 is 1000.
    fn of_toml(key: &str, value: &toml::Value) -> Self {
        let whole = value.as_float().filter(|x| is_count(key) && is_whole(*x));
        let whole = whole.map(|x| toml::Value::Integer(x as i64));
        let value = whole.as_ref().unwrap_or(value);
        let label = match value {
            toml::Value::String(text) => text.trim().to_owned(),
            toml::Value::Float(number) => plain(*number),
            toml::Value::Array(_) => value.to_string().replace(['[', ']', ' '], ""),
            other => other.to_string(),
        };
        Self {
            literal: value.to_string(),
            label,
        }
    }
}

impl Axis {
    /// Reads an axis from its name (`bias`, or `B` as in the thesis) and its values as text: a list
    /// (`5r,10r,20r`; separated by `;` where values have commas), of which a part may be a range:
    /// `LOW..HIGH/N` is N evenly spaced values with both ends, `LOW..HIGH/Nlog` N values of equal
    /// ratio. Values of ranges are rounded to a thousandth of the smallest step next to them.
    ///
    /// # Errors
    /// When there is no such setting, it cannot vary, or a value is none of its values, is there
    /// twice, or is missing between two separators.
    pub fn parse(name: &str, text: &str) -> Result<Self, AxisError> {
        let key = key_of(name)?;
        let separator = if text.contains(';') { ';' } else { ',' };
        let text = text.trim();
        let listed = text.strip_suffix(separator).unwrap_or(text);
        if listed.is_empty() {
            return Err(AxisError::Empty { axis: key });
        }
        let mut values = Vec::new();
        for word in listed.split(separator).map(str::trim) {
            match (word.is_empty(), word.contains("..")) {
                (true, _) => return Err(AxisError::Gap { axis: key }),
                (_, true) => values.extend(range(key, word)?),
                (_, false) => values.push(AxisValue::of_word(key, word)),
            }
        }
        Self::new(key, values)
    }

    /// Reads an axis as a grid file has it: text as for [`Axis::parse`], or an array of values.
    pub(super) fn from_toml(name: &str, value: &toml::Value) -> Result<Self, AxisError> {
        match value {
            toml::Value::String(text) => Self::parse(name, text),
            toml::Value::Array(values) => {
                let key = key_of(name)?;
                let value = |value| AxisValue::of_toml(key, value);
                Self::new(key, values.iter().map(value).collect())
            }
            other => Self::parse(name, &other.to_string()),
        }
    }

    fn new(key: &'static str, values: Vec<AxisValue>) -> Result<Self, AxisError> {
        let axis = Self { key, values };
        if axis.values.is_empty() {
            return Err(AxisError::Empty { axis: key });
        }
        let mut settings = Vec::new();
        for (i, value) in axis.values.iter().enumerate() {
            let said = axis.settings(i).map_err(|problem| AxisError::Value {
                axis: key,
                value: value.label.clone(),
                problem,
                advice: separator_advice(key),
            })?;
            if settings.contains(&said) {
                let value = value.label.clone();
                return Err(AxisError::Twice { axis: key, value });
            }
            settings.push(said);
        }
        Ok(axis)
    }

    /// The setting's key in a recipe.
    pub fn key(&self) -> &'static str {
        self.key
    }

    /// The key of what settings say and this axis says in every cell: its own, or one that it excludes, as
    /// reach does elements.
    pub fn overrules(&self, settings: &Settings) -> Option<&'static str> {
        let left = settings.clone().without(&self.said()).said();
        let keys = settings.said().into_iter().map(|(key, _)| key);
        keys.into_iter()
            .find(|key| left.iter().all(|(kept, _)| kept != key))
    }

    /// The settings of its first value.
    pub(super) fn said(&self) -> Settings {
        Settings::from_toml(&self.line(0)).unwrap_or_default()
    }

    /// What it is called in a figure: its letter in the thesis, or its key.
    pub fn symbol(&self) -> &'static str {
        let symbol = SYMBOLS.iter().find(|(_, key)| *key == self.key);
        symbol.map_or(self.key, |(letter, _)| letter)
    }

    /// A value with the axis's name: `L = 5r`.
    ///
    /// # Panics
    /// When there is no such value.
    pub fn title(&self, i: usize) -> String {
        format!("{} = {}", self.symbol(), self.values[i].label)
    }

    /// The values, in order.
    pub fn values(&self) -> &[AxisValue] {
        &self.values
    }

    /// How many values there are.
    pub fn len(&self) -> usize {
        self.values.len()
    }

    /// Never: an axis has a value.
    pub fn is_empty(&self) -> bool {
        self.values.is_empty()
    }

    /// Whether another has the same values under the same names, however they are written.
    pub(super) fn is_same(&self, other: &Self) -> bool {
        let labels = |axis: &Self| {
            axis.values
                .iter()
                .map(|v| v.label.clone())
                .collect::<Vec<_>>()
        };
        let settings = |axis: &Self| {
            (0..axis.len())
                .map(|i| axis.settings(i))
                .collect::<Vec<_>>()
        };
        self.key == other.key && labels(self) == labels(other) && settings(self) == settings(other)
    }

    /// A value as a line of a recipe.
    pub(super) fn line(&self, i: usize) -> String {
        format!("{} = {}\n", self.key, self.values[i].literal)
    }

    /// The whole axis as a line of a grid file.
    pub(super) fn to_toml(&self) -> String {
        let literals: Vec<_> = self.values.iter().map(|v| v.literal.as_str()).collect();
        format!("{} = [{}]\n", self.key, literals.join(", "))
    }

    /// The setting with one of the values, or why that is none.
    fn settings(&self, i: usize) -> Result<Settings, String> {
        Settings::from_toml(&self.line(i)).map_err(|e| {
            let text = e.to_string();
            let reason = text.lines().rfind(|line| !line.trim().is_empty());
            let reason = reason.unwrap_or_default();
            let place = format!("line 1: {}: ", self.key);
            reason.strip_prefix(&place).unwrap_or(reason).to_owned()
        })
    }
}

/// The key that a name of an axis stands for.
fn key_of(name: &str) -> Result<&'static str, AxisError> {
    let name = name.trim();
    let symbol = SYMBOLS.iter().find(|(letter, _)| *letter == name);
    let key = Settings::key(symbol.map_or(name, |(_, key)| key))
        .map_err(|unknown| unknown.but(&FIXED.map(|(fixed, _)| fixed)))?;
    match FIXED.iter().find(|(fixed, _)| *fixed == key) {
        Some((_, instead)) => Err(AxisError::Fixed { axis: key, instead }),
        None => Ok(key),
    }
}

fn separator_advice(key: &str) -> &'static str {
    match key {
        "at" | "at-triangle" => "; separate places by ';', as in 0,1,0; 0,0,1",
        "slope" => "; separate slopes by ';', as in 0,45; 45,90",
        _ => "",
    }
}

/// A number and the unit after it, empty for none.
fn split_unit(text: &str) -> Option<(f64, &str)> {
    let text = text.trim();
    let digits = text.trim_end_matches(['r', '%']);
    let number: f64 = digits.trim_end().parse().ok()?;
    (number.is_finite() && text.len() - digits.len() <= 1)
        .then_some((number, &text[digits.len()..]))
}

/// `LOW..HIGH/N` or `LOW..HIGH/Nlog`.
fn range(key: &'static str, text: &str) -> Result<Vec<AxisValue>, AxisError> {
    let fail = |problem| AxisError::Range {
        axis: key,
        text: text.to_owned(),
        problem,
    };
    const FORM: &str = "write LOW..HIGH/N, as 0.2..1.0/5, or LOW..HIGH/Nlog, as 1r..100r/5log";
    let (low, rest) = text.split_once("..").ok_or_else(|| fail(FORM))?;
    let (high, count) = rest.split_once('/').ok_or_else(|| fail(FORM))?;
    let (count, is_log) = match count.trim().strip_suffix("log") {
        Some(count) => (count, true),
        None => (count, false),
    };
    let count: usize = count.trim().parse().map_err(|_| fail(FORM))?;
    let ends = (split_unit(low), split_unit(high));
    let (Some((low, unit)), Some((high, other))) = ends else {
        return Err(fail(FORM));
    };
    match () {
        () if unit != other => Err(fail("both ends must have the same unit")),
        () if !(2..=MOST).contains(&count) => Err(fail("a range has 2 to 10000 values")),
        () if is_log && low.min(high) <= 0.0 => Err(fail("a log range is above 0")),
        () => {
            let numbers = spread(low, high, count, is_log).into_iter();
            let word = |x: f64| {
                let word = format!("{}{unit}", plain(whole_if(key, x)));
                AxisValue::of_word(key, &word)
            };
            Ok(numbers.map(word).collect())
        }
    }
}

/// Whether a number is one that floats count to.
fn is_whole(x: f64) -> bool {
    const MOST: f64 = (1u64 << f64::MANTISSA_DIGITS) as f64;
    x.fract() == 0.0 && x.abs() <= MOST
}

/// A number as people write it, and no longer than the name of a folder may be.
fn plain(x: f64) -> String {
    match x.abs() {
        0.0 | 1e-7..1e16 => x.to_string(),
        _ => format!("{x:e}"),
    }
}

fn is_count(key: &str) -> bool {
    [ELEMENTS.name, COLONIES.name].contains(&key)
}

/// Counts are whole.
fn whole_if(key: &str, x: f64) -> f64 {
    if is_count(key) { x.round() } else { x }
}

/// Numbers from end to end, at equal distances or ratios; the ends are exact.
fn spread(low: f64, high: f64, count: usize, is_log: bool) -> Vec<f64> {
    let at = |i: usize| {
        let share = i as f64 / (count - 1) as f64;
        match is_log {
            true => low * libm::pow(high / low, share),
            false => low + (high - low) * share,
        }
    };
    let rounded = |i: usize| match i {
        0 => low,
        i if i == count - 1 => high,
        i => {
            let step = (at(i) - at(i - 1)).abs().min((at(i + 1) - at(i)).abs());
            rounded_to(at(i), step)
        }
    };
    (0..count).map(rounded).collect()
}

/// To the power of ten that is a thousandth of the step or less.
fn rounded_to(x: f64, step: f64) -> f64 {
    if !(step > 0.0 && step.is_finite()) {
        return x;
    }
    let decimals = 3 - libm::floor(libm::log10(step)) as i32;
    match usize::try_from(decimals) {
        Ok(decimals) => format!("{x:.decimals$}").parse().unwrap_or(x),
        Err(_) => {
            let unit = libm::pow(10.0, f64::from(-decimals));
            (x / unit).round() * unit
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn labels(name: &str, text: &str) -> Vec<String> {
        let axis = Axis::parse(name, text).unwrap();
        axis.values().iter().map(|v| v.label.clone()).collect()
    }

    fn message(name: &str, text: &str) -> String {
        Axis::parse(name, text).unwrap_err().to_string()
    }

    #[test]
    fn lists_and_ranges_are_read() {
        assert_eq!(labels("L", "5r, 10r,20r"), ["5r", "10r", "20r"]);
        assert_eq!(
            labels("bias", "0.2..1.0/5"),
            ["0.2", "0.4", "0.6", "0.8", "1"]
        );
        assert_eq!(labels("bias", "1..0/3"), ["1", "0.5", "0"]);
        assert_eq!(labels("bias", "0..1/4"), ["0", "0.3333", "0.6667", "1"]);
        assert_eq!(
            labels("curvature_radius", "2r..200r/5log"),
            ["2r", "6.325r", "20r", "63.25r", "200r"]
        );
        assert_eq!(
            labels("radius", "0.1%..0.4%/3log"),
            ["0.1%", "0.2%", "0.4%"]
        );
        assert_eq!(labels("bias", "-1,0..0.5/2,2"), ["-1", "0", "0.5", "2"]);
        assert_eq!(
            labels("elements", "100..10000/4log"),
            ["100", "464", "2154", "10000"]
        );
        assert_eq!(labels("elements", "1e3,1.5e3"), ["1000", "1500"]);
        assert_eq!(
            labels("colonies", "1e0,2..30/4log"),
            ["1", "2", "5", "12", "30"]
        );
        assert_eq!(
            labels("reach", "1e300,1e299..2e299/2,2.5e-9"),
            ["1e300", "1e299", "2e299", "2.5e-9"]
        );
        assert_eq!(labels("at", "0,1,0; -1,0,0"), ["0,1,0", "-1,0,0"]);
        assert_eq!(labels("preset", "foliose,dla"), ["foliose", "dla"]);
        assert_eq!(labels("at", "0,1,0;"), ["0,1,0"]);
    }

    #[test]
    fn a_gap_in_a_list_is_told_of() {
        for text in ["0.3,,0.5", ",0.3", "0.3,0.5,,", "0.3;;0.5"] {
            assert!(message("B", text).contains("a value is missing"), "{text}");
        }
        for text in ["", " ", ","] {
            assert!(message("B", text).contains("has no values"), "{text:?}");
        }
    }

    #[test]
    fn both_notations_of_a_grid_file_are_the_same() {
        let table: toml::Table = "a = [0.2, 0.5, 1]\nb = \"0.2,0.5,1\"".parse().unwrap();
        let [a, b] = ["a", "b"].map(|k| Axis::from_toml("B", &table[k]).unwrap());
        assert_eq!(a, b);
        let again: toml::Table = a.to_toml().parse().unwrap();
        assert_eq!(Axis::from_toml("bias", &again["bias"]).unwrap(), a);
    }

    #[test]
    fn what_is_wrong_is_named() {
        for (name, text, parts) in [
            ("biass", "1", &["did you mean 'bias'"] as &[_]),
            ("seed", "1,2", &["--seeds"]),
            ("mesh", "a,b", &["one mesh"]),
            ("B", "", &["axis bias has no values", "bias=A,B,C"]),
            (
                "B",
                "0.2,high",
                &["axis bias: high is not a valid value: invalid type"],
            ),
            ("B", "0.2,0.20", &["axis bias", "0.2", "twice"]),
            ("L", "5r..20/3", &["curvature-radius", "same unit"]),
            ("L", "5r..20r", &["LOW..HIGH/N"]),
            ("L", "0r..20r/3log", &["above 0"]),
            ("B", "0..1/1", &["2 to 10000"]),
            ("B", "0..1/99999999999", &["2 to 10000"]),
            ("at", "0,1,0", &["axis at", "separate places by ';'"]),
            ("join", "pack,glue", &["axis join", "glue"]),
        ] {
            let message = message(name, text);
            for part in parts {
                assert!(
                    message.contains(part),
                    "{name}={text}: '{part}' not in {message}"
                );
            }
        }
    }

    proptest! {
        #[test]
        fn no_text_panics(name in "(L|B|at|elements|\\PC{0,5})", text in "[-0-9.,;/rlog% e]{0,20}") {
            let _ = Axis::parse(&name, &text);
        }

        #[test]
        fn ranges_are_even_to_a_thousandth(low in -1e3..1e3f64, width in 1e-3..1e3f64, n in 2..50usize) {
            let values = spread(low, low + width, n, false);
            let step = width / (n - 1) as f64;
            prop_assert_eq!((values[0], values[n - 1]), (low, low + width));
            for pair in values.windows(2) {
                prop_assert!((pair[1] - pair[0] - step).abs() < 2e-3 * step);
            }
        }

        #[test]
        fn log_ranges_have_one_ratio(low in 1e-3..1e3f64, ratio in 1.1..50.0f64, n in 2..9usize) {
            let values = spread(low, low * ratio, n, true);
            let each = ratio.powf(1.0 / (n - 1) as f64);
            for pair in values.windows(2) {
                let step = pair[1] - pair[0];
                prop_assert!((pair[1] - pair[0] * each).abs() < 4e-3 * step * each);
            }
        }
    }
}

//! Numbers as people read them.

/// A measured number with four digits that count.
pub(crate) fn short(value: f64) -> String {
    let size = value.abs();
    if value == 0.0 || !value.is_finite() {
        return format!("{value}");
    }
    if !(1e-4..1e9).contains(&size) {
        return format!("{value:.3e}");
    }
    let decimals = (3 - size.log10().floor() as i32).max(0) as usize;
    let digits = format!("{value:.decimals$}");
    match digits.contains('.') {
        true => digits
            .trim_end_matches('0')
            .trim_end_matches('.')
            .to_owned(),
        false => digits,
    }
}

/// A count in groups of three: 12,345.
pub(crate) fn count(value: u64) -> String {
    let digits = value.to_string();
    let groups = digits.as_bytes().rchunks(3).rev();
    let groups: Vec<_> = groups.map(String::from_utf8_lossy).collect();
    groups.join(",")
}

/// A share in percent.
pub(crate) fn percent(share: f64) -> String {
    format!("{} %", short(100.0 * share))
}

/// A place, with more digits than [`short`] where it is far from the origin.
pub(crate) fn place(p: [f64; 3]) -> String {
    let coordinate = |x: f64| match x.abs() >= 1000.0 {
        true => format!("{x:.2}"),
        false => short(x),
    };
    format!("({})", p.map(coordinate).join(", "))
}

/// `1 edge`, `2 edges`.
pub(crate) fn plural(n: usize, one: &str, many: &str) -> String {
    let number = count(n as u64);
    match n {
        1 => format!("{number} {one}"),
        _ => format!("{number} {many}"),
    }
}

/// `1 element`, `20,000 elements`.
pub(crate) fn elements(n: usize) -> String {
    plural(n, "element", "elements")
}

/// A time to come or gone by: `42 s`, `3 min 20 s`, `2 h 5 min`, `12 days`.
pub(crate) fn duration(seconds: f64) -> String {
    let whole = seconds.min(1e12) as u64;
    match whole {
        0..10 => format!("{seconds:.1} s"),
        10..60 => format!("{whole} s"),
        60..3600 => format!("{} min {} s", whole / 60, whole % 60),
        3600..172_800 => format!("{} h {} min", whole / 3600, whole % 3600 / 60),
        _ => format!("{} days", count((whole + 43_200) / 86_400)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn four_digits_count() {
        let cases = [
            (0.0, "0"),
            (1.0, "1"),
            (0.123_456, "0.1235"),
            (-12.345_678, "-12.35"),
            (123_456.7, "123457"),
            (0.001, "0.001"),
            (1.5e-7, "1.500e-7"),
            (3e12, "3.000e12"),
            (100.0, "100"),
        ];
        for (value, text) in cases {
            assert_eq!(short(value), text);
        }
    }

    #[test]
    fn counts_are_grouped() {
        assert_eq!(count(7), "7");
        assert_eq!(count(999), "999");
        assert_eq!(count(1000), "1,000");
        assert_eq!(count(1_234_567), "1,234,567");
    }

    #[test]
    fn durations_are_spoken() {
        assert_eq!(duration(0.5), "0.5 s");
        assert_eq!(duration(59.9), "59 s");
        assert_eq!(duration(200.0), "3 min 20 s");
        assert_eq!(duration(7500.0), "2 h 5 min");
        assert_eq!(duration(172_799.0), "47 h 59 min");
        assert_eq!(duration(1e6), "12 days");
        assert_eq!(duration(f64::INFINITY), "11,574,074 days");
    }
}

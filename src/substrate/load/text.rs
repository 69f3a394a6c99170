//! What the text formats share: tokens, numbers, and line numbers for messages.

use super::Format;
use super::error::{LoadFault, Parsed};
use super::{Soup, counted};
use crate::substrate::soup::is_representable;

/// A line without its comment, which a `#` begins that stands first or after white space: names may hold others.
pub(super) fn uncommented(line: &[u8]) -> &[u8] {
    let begins = |&at: &usize| line[at] == b'#' && (at == 0 || line[at - 1].is_ascii_whitespace());
    &line[..(0..line.len()).find(begins).unwrap_or(line.len())]
}

/// The 1-based number of the line that holds byte `offset`. A line ends with LF, CRLF, or CR alone.
pub(super) fn line_of(bytes: &[u8], offset: usize) -> usize {
    let end = offset.min(bytes.len());
    let ends_line = |&i: &usize| match bytes[i] {
        b'\n' => true,
        b'\r' => bytes.get(i + 1) != Some(&b'\n'),
        _ => false,
    };
    1 + (0..end).filter(ends_line).count()
}

/// Reads a decimal number; `None` when it is not one. `nan` and `inf` are numbers here.
pub(super) fn number(token: &[u8]) -> Option<f64> {
    let read = std::str::from_utf8(token).ok()?.parse().ok();
    read.or_else(|| is_no_number(token).then_some(f64::NAN))
}

/// Whether this is what Microsoft's C library wrote until 2015 for what is not finite, as `1.#INF`, `-1.#IND00`,
/// `1.#QNAN` and, with few digits, `1.#J`.
fn is_no_number(token: &[u8]) -> bool {
    let digits = token.strip_prefix(b"-").unwrap_or(token);
    matches!(digits, [b'1', b'.', b'#', letter, ..] if letter.is_ascii_alphabetic())
}

/// Reads a decimal number as the nearest `f32`, widened: what its writer had.
pub(super) fn single(token: &[u8]) -> Option<f64> {
    let read = std::str::from_utf8(token).ok()?.parse::<f32>().ok();
    let read = read.map(f64::from);
    read.or_else(|| is_no_number(token).then_some(f64::NAN))
}

/// What white is where colours are numbers without a type: 255 where one is beyond [`ABOUT_ONE`], else 1.
pub(super) fn white(mut colors: impl Iterator<Item = f64>) -> f64 {
    match colors.any(|x| x.is_finite() && x > ABOUT_ONE) {
        true => 255.0,
        false => 1.0,
    }
}

/// The greatest number that a colour has by round-off or exposure where 1 is white.
const ABOUT_ONE: f64 = 2.0;

/// Reads an optionally signed decimal integer.
pub(super) fn integer(token: &[u8]) -> Option<i64> {
    let (negative, digits) = match token {
        [b'-', rest @ ..] => (true, rest),
        [b'+', rest @ ..] => (false, rest),
        _ => (false, token),
    };
    if digits.is_empty() || digits.len() > 18 {
        return None;
    }
    let mut value = 0_i64;
    for &digit in digits {
        if !digit.is_ascii_digit() {
            return None;
        }
        value = value * 10 + i64::from(digit - b'0');
    }
    Some(if negative { -value } else { value })
}

/// Refuses positions that are no places in space where triangles use them.
///
/// The others come from scans that keep a vertex for every direction they looked in: they become the
/// origin, and a note says how many.
pub(super) fn used_are_finite(
    soup: &mut Soup,
    format: Format,
    place: impl Fn(usize) -> String,
) -> Parsed<()> {
    if soup.positions.iter().all(|p| is_representable(*p)) {
        return Ok(());
    }
    for &corner in soup.triangles.as_flattened() {
        let corner = corner as usize;
        finite(soup.positions[corner], format, || place(corner))?;
    }
    let mut passed_over = 0;
    for position in soup.positions.iter_mut().filter(|p| !is_representable(**p)) {
        *position = [0.0; 3];
        passed_over += 1;
    }
    let (one, many) = (
        "unused vertex without a finite position ignored",
        "unused vertices without a finite position ignored",
    );
    soup.notes.push(counted(passed_over, one, many));
    Ok(())
}

/// Refuses a position that is not a place in space.
pub(super) fn finite(
    position: [f64; 3],
    format: Format,
    place: impl FnOnce() -> String,
) -> Parsed<[f64; 3]> {
    if is_representable(position) {
        return Ok(position);
    }
    let shown = |x: f64| match x.is_finite() && x.abs() > 1e15 {
        true => format!("{x:e}"),
        false => x.to_string(),
    };
    let [x, y, z] = position.map(shown);
    let is = match position.iter().all(|x| x.is_finite()) {
        true => "beyond single precision",
        false => "not finite",
    };
    Err(LoadFault::malformed(
        format,
        place(),
        format!("the position ({x}, {y}, {z}) is {is}"),
        "remove or repair that vertex in the program that made the file",
    ))
}

//! What the program says.

/// The same words on every system: with slashes and single quotes, where Windows has others.
pub(crate) fn as_elsewhere(said: &[u8]) -> String {
    let said = String::from_utf8_lossy(said);
    match cfg!(windows) {
        true => said.replace('\\', "/").replace('"', "'"),
        false => said.into_owned(),
    }
}

/// Whether such words have these among them.
pub(crate) fn says(said: &str, words: &str) -> bool {
    said.contains(&as_elsewhere(words.as_bytes()))
}

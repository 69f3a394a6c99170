//! The nearest name to a misspelt one.

/// The known name that a misspelt one was probably meant to be.
pub(super) fn nearest_name<'a>(
    wrong: &str,
    known: impl IntoIterator<Item = &'a str>,
) -> Option<&'a str> {
    const SHORTEST_PART: usize = 3;
    let close = |name: &str| {
        wrong.len().min(name.len()) >= SHORTEST_PART
            && (name.contains(wrong) || wrong.contains(name))
    };
    let ranked = known.into_iter().map(|name| {
        let edits = edits(wrong, name);
        let distance = if close(name) { edits.min(1) } else { edits };
        (distance, edits, name)
    });
    let (distance, _, name) = ranked.min()?;
    (distance <= 1 + wrong.len() / 4).then_some(name)
}

/// Letters to insert, delete or replace to turn one word into the other.
fn edits(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, letter) in a.chars().enumerate() {
        let mut diagonal = i;
        row[0] = i + 1;
        for j in 0..b.len() {
            let replaced = diagonal + usize::from(letter != b[j]);
            diagonal = row[j + 1];
            row[j + 1] = replaced.min(row[j] + 1).min(diagonal + 1);
        }
    }
    row[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_are_levenshtein() {
        assert_eq!(edits("kitten", "sitting"), 3);
        assert_eq!(edits("", "abc"), 3);
        assert_eq!(edits("abc", ""), 3);
        assert_eq!(edits("bias", "bias"), 0);
    }

    #[test]
    fn only_near_names_are_suggested() {
        let known = ["bias", "gain", "min-stick", "curvature-radius"];
        assert_eq!(nearest_name("biass", known), Some("bias"));
        assert_eq!(nearest_name("min-stik", known), Some("min-stick"));
        assert_eq!(nearest_name("curvature", known), Some("curvature-radius"));
        assert_eq!(nearest_name("colour", known), None);
        assert_eq!(nearest_name("", known), None);
        assert_eq!(nearest_name("format", ["at", "up"]), None);
    }
}

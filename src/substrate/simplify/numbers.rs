//! Numbers without gaps for some of many.

/// Bits of a word.
const WORD: u32 = u64::BITS;

/// Some of the numbers from 0 on, each with its place in their order.
pub(super) struct Numbers {
    /// The multiple of 64 at or below the least.
    first: u32,
    /// From there on, a bit for each number that is one of them.
    words: Vec<u64>,
    /// How many are before each word.
    before: Vec<u32>,
}

impl Numbers {
    /// Those that are listed, each perhaps several times.
    pub(super) fn of(listed: &[u32]) -> Self {
        let least = listed.iter().min().map_or(0, |least| least / WORD);
        let most = listed.iter().max().map_or(0, |most| most / WORD + 1);
        let mut words = vec![0u64; (most - least.min(most)) as usize];
        for number in listed {
            words[(number / WORD - least) as usize] |= 1 << (number % WORD);
        }
        let before = words.iter().scan(0, |sum, word| {
            let before = *sum;
            *sum += word.count_ones();
            Some(before)
        });
        Self {
            first: least * WORD,
            before: before.collect(),
            words,
        }
    }

    /// How many of them are less than this one of them.
    #[inline]
    pub(super) fn place(&self, number: u32) -> u32 {
        let number = number - self.first;
        let word = (number / WORD) as usize;
        let lower = self.words[word] & ((1 << (number % WORD)) - 1);
        self.before[word] + lower.count_ones()
    }

    /// All of them, ascending.
    pub(super) fn iter(&self) -> impl Iterator<Item = u32> + '_ {
        (self.first..)
            .step_by(WORD as usize)
            .zip(&self.words)
            .flat_map(|(first, &word)| {
                (0..WORD)
                    .filter(move |bit| word >> bit & 1 == 1)
                    .map(move |bit| first + bit)
            })
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn places_are_those_in_a_sorted_list() {
        let wild = |i: u32| i.wrapping_mul(0x9e37_79b9) >> 20;
        for (first, count) in [(0, 0), (0, 1), (63, 2), (64, 64), (100_000, 3000)] {
            let listed: Vec<u32> = (0..count).map(|i| first + wild(i)).collect();
            let sorted: BTreeSet<u32> = listed.iter().copied().collect();
            let numbers = Numbers::of(&listed);
            assert!(numbers.iter().eq(sorted.iter().copied()));
            for (place, number) in (0..).zip(sorted) {
                assert_eq!(numbers.place(number), place);
            }
        }
    }
}

//! The tree of parents: depth, branch order, streams.

use std::cmp::Ordering;

/// Who stuck to whom: a tree for each seed, parents before their children.
#[derive(Clone, Debug)]
pub struct Tree<'a> {
    parents: &'a [i32],
}

/// Share of the element's radius that a branch has at its tips.
const TIP: f64 = 0.25;

impl<'a> Tree<'a> {
    /// The tree of these parents, −1 for a seed.
    ///
    /// # Panics
    /// When an element is not born after its parent.
    pub fn new(parents: &'a [i32]) -> Self {
        let sound = |(i, &parent): (usize, &i32)| i64::from(parent) < i as i64;
        let sound = parents.iter().enumerate().all(sound);
        assert!(sound, "parents are born before their children");
        Self { parents }
    }

    fn parent(&self, i: usize) -> Option<usize> {
        usize::try_from(self.parents[i]).ok()
    }

    /// Steps from the seed, which has 0.
    pub fn depth(&self) -> Vec<u32> {
        let mut depth = Vec::with_capacity(self.parents.len());
        for i in 0..self.parents.len() {
            depth.push(self.parent(i).map_or(0, |parent| depth[parent] + 1));
        }
        depth
    }

    /// Steps to the farthest tip that descends from an element; a tip has 0.
    pub fn height(&self) -> Vec<u32> {
        let mut height = vec![0; self.parents.len()];
        for i in (0..height.len()).rev() {
            if let Some(parent) = self.parent(i) {
                height[parent] = height[parent].max(height[i] + 1);
            }
        }
        height
    }

    /// Branch order after Strahler (1957), who simplified Horton's (1945): 1 for a tip; elsewhere
    /// the highest order k among the children, or k + 1 where two or more of them have it.
    ///
    /// This is the usual order for rivers, and for aggregates (P. Ossadnik, *Branch order and
    /// ramification analysis of large diffusion-limited-aggregation clusters*, 1992). A stray
    /// element on a branch's side is a branch of order 1.
    pub fn strahler(&self) -> Vec<u32> {
        let mut order = vec![1u32; self.parents.len()];
        // Highest order among the children, and whether two have it.
        let mut children = vec![(0u32, false); order.len()];
        for i in (0..order.len()).rev() {
            order[i] = match children[i] {
                (0, _) => 1,
                (k, two) => k + u32::from(two),
            };
            if let Some(parent) = self.parent(i) {
                let (highest, two) = &mut children[parent];
                match order[i].cmp(highest) {
                    Ordering::Greater => (*highest, *two) = (order[i], false),
                    Ordering::Equal => *two = true,
                    Ordering::Less => {}
                }
            }
        }
        order
    }

    /// Each element's main child, along which its branch goes on: that of the highest order, of
    /// those the one with the greatest height, of those the first born.
    fn main_children(&self) -> Vec<Option<u32>> {
        let (order, height) = (self.strahler(), self.height());
        let rank = |i: usize| (order[i], height[i]);
        let mut main: Vec<Option<u32>> = vec![None; order.len()];
        for i in 0..order.len() {
            if let Some(parent) = self.parent(i)
                && main[parent].is_none_or(|other| rank(i) > rank(other as usize))
            {
                main[parent] = Some(i as u32);
            }
        }
        main
    }

    /// The tree cut into paths: each runs from the element that it branches off, or from a seed,
    /// along main children to a tip. Every pair of child and parent is in one of them, side by
    /// side; they come in the order in which their first own elements were born. A seed without
    /// children has none.
    ///
    /// The main child is that of the highest Strahler order, as in Horton's streams, then the one
    /// with the longest way to a tip, then the eldest.
    pub fn streams(&self) -> Vec<Vec<u32>> {
        let main = self.main_children();
        let mut streams = Vec::new();
        for i in 0..main.len() {
            let parent = self.parent(i);
            if parent.is_some_and(|parent| main[parent] == Some(i as u32)) {
                continue;
            }
            let mut stream: Vec<u32> = parent.map(|parent| parent as u32).into_iter().collect();
            let own = std::iter::successors(Some(i as u32), |&at| main[at as usize]);
            stream.extend(own);
            if stream.len() > 1 {
                streams.push(stream);
            }
        }
        streams
    }

    /// Half the width of the branch at each element, in element radii: 1 at a seed, 1/4 at a tip,
    /// and in between 1/4 + 3/4·h/(h + d) for depth d and height h. So it falls along every way
    /// from the seed, and linearly along one that never branches.
    pub fn taper(&self) -> Vec<f64> {
        let width = |(depth, height): (u32, u32)| match depth {
            0 => 1.0,
            _ => TIP + (1.0 - TIP) * f64::from(height) / (f64::from(height) + f64::from(depth)),
        };
        self.depth()
            .into_iter()
            .zip(self.height())
            .map(width)
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::morphometry::test_lichen::blob;

    /// By the definitions, from the root down.
    fn slow_order(parents: &[i32], i: usize) -> u32 {
        let children = (0..parents.len()).filter(|&c| parents[c] == i as i32);
        let mut orders: Vec<u32> = children.map(|c| slow_order(parents, c)).collect();
        orders.sort_unstable();
        match orders[..] {
            [] => 1,
            [.., a, b] if a == b => a + 1,
            [.., highest] => highest,
        }
    }

    fn slow_height(parents: &[i32], i: usize) -> u32 {
        let children = (0..parents.len()).filter(|&c| parents[c] == i as i32);
        children
            .map(|c| slow_height(parents, c) + 1)
            .max()
            .unwrap_or(0)
    }

    #[test]
    fn orders_heights_and_depths_are_those_of_the_definitions() {
        for seed in 0..20 {
            let parents = blob(60, seed).parents;
            let tree = Tree::new(&parents);
            let (order, height) = (tree.strahler(), tree.height());
            for i in 0..parents.len() {
                assert_eq!(order[i], slow_order(&parents, i), "{parents:?}");
                assert_eq!(height[i], slow_height(&parents, i));
                let ancestors = std::iter::successors(Some(i), |&a| tree.parent(a));
                assert_eq!(tree.depth()[i] as usize, ancestors.count() - 1);
            }
        }
    }

    /// A complete binary tree of n levels has order n (Strahler 1957).
    #[test]
    fn a_complete_binary_tree_has_the_order_of_its_levels() {
        let parents: Vec<i32> = (0..127)
            .map(|i| if i == 0 { -1 } else { (i - 1) / 2 })
            .collect();
        let tree = Tree::new(&parents);
        assert_eq!(tree.strahler()[0], 7);
        assert_eq!(tree.streams().len(), 64);
        let chain: Vec<i32> = (-1..9).collect();
        let chain = Tree::new(&chain);
        assert_eq!(chain.strahler(), [1; 10]);
        assert_eq!(chain.streams(), [(0..10).collect::<Vec<u32>>()]);
        for (i, width) in chain.taper().into_iter().enumerate() {
            assert!((width - (1.0 - 0.75 * i as f64 / 9.0)).abs() < 1e-12);
        }
    }

    #[test]
    fn streams_hold_every_link_once_and_end_at_tips() {
        for seed in 0..20 {
            let mut parents = blob(300, seed).parents;
            parents[200] = -1;
            let tree = Tree::new(&parents);
            let (height, streams) = (tree.height(), tree.streams());
            let mut links = vec![0; parents.len()];
            for stream in &streams {
                for pair in stream.windows(2) {
                    assert_eq!(parents[pair[1] as usize], pair[0] as i32);
                    links[pair[1] as usize] += 1;
                }
                assert_eq!(height[*stream.last().unwrap() as usize], 0);
            }
            for (i, &links) in links.iter().enumerate() {
                assert_eq!(links, i32::from(parents[i] >= 0));
            }
            let mut seeds = vec![200, 0];
            let first_own = |s: &Vec<u32>| match seeds.last() == Some(&s[0]) {
                true => seeds.pop().unwrap(),
                false => s[1],
            };
            let born: Vec<_> = streams.iter().map(first_own).collect();
            assert!(born.is_sorted(), "{born:?}");
        }
    }

    #[test]
    fn branches_thin_out_from_parent_to_child() {
        let parents = blob(300, 4).parents;
        let taper = Tree::new(&parents).taper();
        for (i, &parent) in parents.iter().enumerate().skip(1) {
            assert!(taper[i] < taper[parent as usize] && taper[i] >= TIP);
        }
    }

    #[test]
    fn nothing_and_a_lone_seed_have_no_streams() {
        assert!(Tree::new(&[]).streams().is_empty());
        let alone = Tree::new(&[-1]);
        assert!(alone.streams().is_empty());
        assert_eq!((alone.taper(), alone.strahler()), (vec![1.0], vec![1]));
    }
}

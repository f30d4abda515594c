//! The order in which parts of a sum are added, which must not depend on who computed them.

/// The number of samples that are fed to a statistic one after the other before anything is merged.
pub const LEAF: u64 = 32;

/// Parts that come in their order and are merged as the digits of a binary counter are carried: two neighbours of the
/// same size become one if together they are a node of the one tree over all parts from number 0 on. That tree
/// depends on the number of parts and on nothing else; whoever begins elsewhere than at 0 has pieces of it, which
/// [`Tree::append`] puts together. There are about as many nodes at a time as the number of parts has binary digits,
/// or twice as many.
#[derive(Clone, Debug, PartialEq)]
pub struct Tree<T> {
    /// Height, number among those of its height, and content.
    pub nodes: Vec<(u32, u64, T)>,
}

impl<T> Tree<T> {
    /// A tree without parts.
    pub const EMPTY: Self = Tree { nodes: vec![] };

    /// Appends part number `index`.
    pub fn push(&mut self, index: u64, part: T, merge: impl Fn(&mut T, T)) {
        self.append(Tree { nodes: vec![(0, index, part)] }, merge);
    }

    /// Appends the pieces of the parts that come next.
    pub fn append(&mut self, next: Self, merge: impl Fn(&mut T, T)) {
        for (mut height, mut index, mut later) in next.nodes {
            while let Some((_, _, mut earlier)) = self
                .nodes
                .pop_if(|(other, before, _)| *other == height && index % 2 == 1 && *before + 1 == index)
            {
                merge(&mut earlier, later);
                (height, index, later) = (height + 1, index / 2, earlier);
            }
            self.nodes.push((height, index, later));
        }
    }

    /// All parts merged, the last nodes first; `None` if there are none.
    pub fn merged(mut self, merge: impl Fn(&mut T, T)) -> Option<T> {
        let (_, _, mut later) = self.nodes.pop()?;
        while let Some((_, _, mut earlier)) = self.nodes.pop() {
            merge(&mut earlier, later);
            later = earlier;
        }
        Some(later)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn merge(a: &mut String, b: String) {
        *a = format!("({a}{b})");
    }

    fn of(parts: core::ops::Range<u64>) -> Tree<String> {
        let mut tree = Tree::EMPTY;
        for part in parts {
            tree.push(part, char::from(b'a' + part as u8).to_string(), merge);
        }
        tree
    }

    #[test]
    fn parts_stay_in_order_and_trees_are_shallow() {
        assert_eq!(of(0..7).nodes.len(), 3);
        assert_eq!(of(0..7).merged(merge).as_deref(), Some("(((ab)(cd))((ef)g))"));
        assert_eq!(of(0..0).merged(merge), None);
    }

    /// However the parts are divided, their pieces make the same tree.
    #[test]
    fn pieces_make_the_same_tree() {
        for n in 0..26 {
            for i in 0..=n {
                for j in i..=n {
                    let mut tree = of(0..i);
                    tree.append(of(i..j), merge);
                    tree.append(of(j..n), merge);
                    assert_eq!(tree, of(0..n), "{i} {j} {n}");
                }
            }
        }
    }
}

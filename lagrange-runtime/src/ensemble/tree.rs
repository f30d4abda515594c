//! The order in which parts of a sum are added, which must not depend on who computed them.

/// Parts that come in their order and are merged as the digits of a binary counter are carried: two neighbours that
/// hold the same number of parts become one. The tree depends on the number of parts and on nothing else. There are as many
/// nodes at a time as the number of parts has binary digits.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tree<T> {
    /// Height and content, the highest first.
    pub nodes: Vec<(u32, T)>,
}

impl<T> Tree<T> {
    /// Appends a part.
    pub fn push(&mut self, part: T, merge: impl Fn(&mut T, T)) {
        let (mut height, mut later) = (0, part);
        while let Some((_, mut earlier)) = self.nodes.pop_if(|(other, _)| *other == height) {
            merge(&mut earlier, later);
            (height, later) = (height + 1, earlier);
        }
        self.nodes.push((height, later));
    }

    /// All parts merged, the smallest nodes first; `None` if there are none.
    pub fn merged(mut self, merge: impl Fn(&mut T, T)) -> Option<T> {
        let (_, mut later) = self.nodes.pop()?;
        while let Some((_, mut earlier)) = self.nodes.pop() {
            merge(&mut earlier, later);
            later = earlier;
        }
        Some(later)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_stay_in_order_and_trees_are_shallow() {
        let merge = |a: &mut String, b: String| *a = format!("({a}{b})");
        let mut tree = Tree { nodes: vec![] };
        for part in ["a", "b", "c", "d", "e", "f", "g"] {
            tree.push(part.to_string(), merge);
        }
        assert_eq!(tree.nodes.len(), 3);
        assert_eq!(tree.merged(merge).as_deref(), Some("(((ab)(cd))((ef)g))"));
        assert_eq!(Tree::<String> { nodes: vec![] }.merged(merge), None);
    }
}

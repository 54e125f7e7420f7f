//! Classes of indices, joined pair by pair.

/// The lowest member of the class of `c`. Paths are halved on the way.
pub(crate) fn find(link: &mut [u32], mut c: u32) -> u32 {
    while link[c as usize] != c {
        let up = link[link[c as usize] as usize];
        link[c as usize] = up;
        c = up;
    }
    c
}

/// Joins the classes of two members of a union-find forest; the lowest member is the root, so that
/// the result does not depend on the order of the joins.
pub(crate) fn unite(link: &mut [u32], c: u32, d: u32) {
    let (c, d) = (find(link, c), find(link, d));
    link[c.max(d) as usize] = c.min(d);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_lowest_member_stands_for_its_class() {
        let mut link: Vec<u32> = (0..6).collect();
        for (a, b) in [(5, 3), (3, 1), (4, 2)] {
            unite(&mut link, a, b);
        }
        let roots: Vec<u32> = (0..6).map(|c| find(&mut link, c)).collect();
        assert_eq!(roots, [0, 1, 2, 1, 2, 1]);
    }
}

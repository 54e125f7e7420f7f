//! Rectangles side by side in an image.

/// Places rectangles of these sizes in rows, the highest first. Returns the size of the image and the
/// upper left corner of each rectangle.
pub fn packed(sizes: &[[usize; 2]]) -> ([usize; 2], Vec<[usize; 2]>) {
    let area: usize = sizes.iter().map(|[w, h]| w * h).sum();
    let widest = sizes.iter().map(|size| size[0]).max().unwrap_or(1);
    // rows leave some room empty
    let width = widest.max((1.1 * area as f64).sqrt().ceil() as usize);
    let mut order: Vec<usize> = (0..sizes.len()).collect();
    order.sort_by_key(|&i| (std::cmp::Reverse(sizes[i][1]), i));
    let mut corners = vec![[0; 2]; sizes.len()];
    let ([mut x, mut y], mut row) = ([0; 2], 0);
    for i in order {
        let [w, h] = sizes[i];
        if x + w > width {
            (x, y, row) = (0, y + row, 0);
        }
        corners[i] = [x, y];
        x += w;
        row = row.max(h);
    }
    ([width, (y + row).max(1)], corners)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rectangles_are_apart_and_inside() {
        let sizes: Vec<[usize; 2]> = (0..40).map(|i| [3 + i * 7 % 23, 2 + i * 5 % 17]).collect();
        let ([width, height], corners) = packed(&sizes);
        let mut taken = vec![false; width * height];
        for ([w, h], [left, top]) in sizes.iter().zip(&corners) {
            for y in *top..top + h {
                for x in *left..left + w {
                    assert!(x < width);
                    assert!(!std::mem::replace(&mut taken[y * width + x], true));
                }
            }
        }
        let used = taken.iter().filter(|t| **t).count();
        assert!(used as f64 > 0.75 * taken.len() as f64);
    }
}

//! Polygons cut into triangles, for shapes of Rapier.

use bevy::math::Vec3;
use smallvec::SmallVec;

/// Cuts a simple polygon into triangles by clipping its ears; quadratic, at worst cubic, in its
/// corners.
///
/// A polygon that crosses itself is cut into triangles all the same, which then do not match its
/// inside.
pub fn triangulate(
    vertices: &[Vec3],
    corners: &[u32],
    normal: Vec3,
    mut emit: impl FnMut([u32; 3]),
) {
    let at = |vertex: u32| vertices[vertex as usize];
    let turn = |a: u32, b: u32, c: u32| (at(b) - at(a)).cross(at(c) - at(b)).dot(normal);
    let mut left = SmallVec::<[u32; 16]>::from_slice(corners);
    while left.len() > 3 {
        let count = left.len();
        let ear = |&i: &usize| {
            let (a, b, c) = (
                left[(i + count - 1) % count],
                left[i],
                left[(i + 1) % count],
            );
            let others = left.iter().filter(|v| ![a, b, c].contains(v));
            // On the border counts as outside for none but the corners of the ear.
            let mut inside = others
                .filter(|&&v| turn(a, b, v) >= 0.0 && turn(b, c, v) >= 0.0 && turn(c, a, v) >= 0.0);
            turn(a, b, c) > 0.0 && inside.next().is_none()
        };
        // Without an ear the rest is a line, or crosses itself.
        let i = (0..count).find(ear).unwrap_or(0);
        emit([
            left[(i + count - 1) % count],
            left[i],
            left[(i + 1) % count],
        ]);
        left.remove(i);
    }
    if let &[a, b, c] = left.as_slice() {
        emit([a, b, c]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area_of_triangles(corners: &[[f32; 2]]) -> (usize, f32) {
        let vertices: Vec<_> = corners.iter().map(|&[x, y]| Vec3::new(x, y, 0.0)).collect();
        let indices: Vec<_> = (0..vertices.len() as u32).collect();
        let (mut count, mut area) = (0, 0.0);
        triangulate(&vertices, &indices, Vec3::Z, |triangle| {
            let [a, b, c] = triangle.map(|v| vertices[v as usize]);
            count += 1;
            area += (b - a).cross(c - a).z * 0.5;
        });
        (count, area)
    }

    #[test]
    fn areas_add_up() {
        let l = [[0., 0.], [2., 0.], [2., 1.], [1., 1.], [1., 2.], [0., 2.]];
        assert_eq!(area_of_triangles(&l), (4, 3.0));
        let arrow = [[0., 0.], [2., -1.], [1., 0.], [2., 1.]];
        assert_eq!(area_of_triangles(&arrow), (2, 1.0));
        let with_a_corner_on_a_side = [[0., 0.], [1., 0.], [2., 0.], [2., 2.], [0., 2.]];
        assert_eq!(area_of_triangles(&with_a_corner_on_a_side).1, 4.0);
    }
}

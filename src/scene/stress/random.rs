//! Random numbers and roots that have the same bits on every machine.

use bevy::math::Vec3A;
use fastrand::Rng;

/// A point of the cube between two corners.
pub(super) fn point_in(rng: &mut Rng, low: Vec3A, high: Vec3A) -> Vec3A {
    low + (high - low) * Vec3A::from_array(std::array::from_fn(|_| rng.f32()))
}

/// A number from 1 to `ratio` whose logarithm is uniform.
pub(super) fn log_uniform(rng: &mut Rng, ratio: f32) -> f32 {
    // ratioᵘ for a random u in [0, 1), bit by bit: ½, ¼, …
    let mut bits = rng.u32(..);
    let (mut power, mut root) = (1.0, ratio);
    for _ in 0..24 {
        root = root.sqrt();
        if bits & 1 == 1 {
            power *= root;
        }
        bits >>= 1;
    }
    power
}

/// Puts a list in random order. (That of `fastrand` depends on the width of `usize`.)
pub(super) fn shuffle<T>(rng: &mut Rng, list: &mut [T]) {
    for last in (1..list.len()).rev() {
        list.swap(last, rng.u64(0..=last as u64) as usize);
    }
}

/// The cube root of a number that is not negative, to a few units in the last place. (That of the
/// standard library depends on the platform.)
pub(super) fn cube_root(number: f64) -> f64 {
    // Newton's method from above, where it falls without overshooting.
    let step = |root: f64| (2.0 * root + number / (root * root)) / 3.0;
    let mut root = number.max(1.0);
    let mut next = step(root);
    while next < root {
        root = next;
        next = step(root);
    }
    root
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cube_roots_are_right() {
        for number in [0.001, 0.5, 1.0, 2.0, 27.0, 1e6, 1.6e14] {
            let root = cube_root(number);
            assert!(
                (root * root * root / number - 1.0).abs() < 1e-14,
                "{number}: {root}"
            );
        }
        assert!(cube_root(0.0) < 1e-100);
    }

    #[test]
    fn each_decade_gets_its_third_of_the_sizes() {
        let mut rng = Rng::with_seed(1);
        let mut decades = [0; 3];
        for _ in 0..30_000 {
            let size = log_uniform(&mut rng, 1000.0);
            assert!((1.0..=1000.0).contains(&size));
            decades[(size >= 10.0) as usize + (size >= 100.0) as usize] += 1;
        }
        assert!(
            decades.iter().all(|count| (9_500..10_500).contains(count)),
            "{decades:?}"
        );
    }

    #[test]
    fn a_shuffle_keeps_everything_and_moves_most() {
        let mut list: Vec<_> = (0..1000).collect();
        shuffle(&mut Rng::with_seed(2), &mut list);
        assert!(
            list.iter()
                .enumerate()
                .filter(|(place, value)| place == *value)
                .count()
                < 10
        );
        list.sort_unstable();
        assert!(list.into_iter().eq(0..1000));
    }
}

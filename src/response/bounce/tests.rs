use super::*;
use proptest::prelude::*;

fn bounces() -> impl Strategy<Value = Option<Bounce>> {
    let reflect = (0f32..=1.0).prop_map(|restitution| Some(Bounce::Reflect { restitution }));
    prop_oneof![
        Just(Some(Bounce::Reverse)),
        Just(Some(Bounce::Reflect { restitution: 1.0 })),
        reflect,
        Just(None)
    ]
}

fn parties() -> impl Strategy<Value = Party> {
    let velocity = prop::array::uniform3(-9f32..9.0).prop_map(Vec3::from);
    (velocity, bounces(), any::<bool>()).prop_map(|(velocity, bounce, reversed)| Party {
        // Who has no answer is a wall at rest.
        velocity: if bounce.is_some() {
            velocity
        } else {
            Vec3::ZERO
        },
        drift: Vec3::ZERO,
        bounce,
        reversed,
    })
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, cases: 4096, ..ProptestConfig::default() })]

    #[test]
    fn no_contact_makes_energy(a in parties(), b in parties(), normal in prop::array::uniform3(-1f32..1.0)) {
        let Some(normal) = Vec3::from(normal).try_normalize() else { return Ok(()) };
        let energy = |velocities: [Vec3; 2]| velocities.iter().map(|v| v.as_dvec3().length_squared()).sum::<f64>();
        let before = [a.velocity, b.velocity];
        let answers = respond([a, b], normal);
        let after = [0, 1].map(|which| answers[which].unwrap_or(before[which]));
        prop_assert!(energy(after) <= energy(before) * (1.0 + 1e-6), "{before:?} {after:?}");
        let is_elastic = |party: Party| party.bounce == Some(Bounce::Reflect { restitution: 1.0 });
        if is_elastic(a) && is_elastic(b) {
            prop_assert!(energy(after) >= energy(before) * (1.0 - 1e-6), "{before:?} {after:?}");
            prop_assert!((after[0] + after[1]).distance(before[0] + before[1]) < 1e-5);
        }
    }
}

#[test]
fn what_is_too_fast_for_numbers_keeps_its_velocity() {
    let elastic = Some(Bounce::Reflect { restitution: 1.0 });
    let party = |x: f32, bounce| Party {
        velocity: Vec3::X * x,
        bounce,
        ..default()
    };
    assert_eq!(
        respond([party(3e38, elastic), party(-3e38, elastic)], Vec3::X),
        [Some(Vec3::X * -3e38), Some(Vec3::X * 3e38)]
    );
    assert_eq!(
        respond([party(3e38, elastic), party(-3e38, None)], Vec3::X),
        [None; 2]
    );
}

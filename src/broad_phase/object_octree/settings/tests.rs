use super::*;

#[test]
fn each_setting_out_of_range_is_named_and_can_be_clamped() {
    let good = ObjectOctreeSettings::default();
    assert_eq!(good.check(), Ok(()));
    assert_eq!(good.clamped(), good);
    let cube = |half_size| RootPolicy::Cube {
        center: Vec3::ZERO,
        half_size,
    };
    let bad = [
        (
            ObjectOctreeSettings {
                max_objects: 0,
                ..good
            },
            "max_objects is 0",
        ),
        (
            ObjectOctreeSettings {
                max_depth: 0,
                ..good
            },
            "max_depth is 0",
        ),
        (
            ObjectOctreeSettings {
                max_depth: 25,
                ..good
            },
            "max_depth is 25",
        ),
        (
            ObjectOctreeSettings {
                merge_slack: 256,
                ..good
            },
            "merge_slack is 256",
        ),
        (
            ObjectOctreeSettings {
                root: RootPolicy::Fit { scale: 0.5 },
                ..good
            },
            "scale is 0.5",
        ),
        (
            ObjectOctreeSettings {
                root: RootPolicy::Fit { scale: f32::NAN },
                ..good
            },
            "scale is NaN",
        ),
        (
            ObjectOctreeSettings {
                root: cube(0.0),
                ..good
            },
            "half size 0",
        ),
        (
            ObjectOctreeSettings {
                root: cube(f32::INFINITY),
                ..good
            },
            "half size inf",
        ),
    ];
    for (settings, expected) in bad {
        let error = settings.check().unwrap_err().to_string();
        assert!(error.contains(expected), "{error}");
        assert_eq!(settings.clamped().check(), Ok(()));
        let same = settings;
        assert_eq!(
            settings, same,
            "settings that stay as they are have not changed"
        );
    }
}

//! The panel: what the scene is, what happens in it, and what can be chosen; of Bevy's own widgets.

mod figures;
mod graph;
mod layout;
mod widgets;

use bevy::{
    camera::{CameraUpdateSystems, SubCameraView},
    picking::hover::Hovered,
    prelude::*,
};

/// What is to be seen of the panel.
#[derive(Resource, Clone, Copy, Debug, Default)]
pub struct Panel {
    /// Whether it is out of the way.
    pub is_hidden: bool,
}

/// The node that has all others in it.
#[derive(Component, Clone, Copy, Debug, Default)]
#[require(Hovered)]
pub struct Root;

/// Adds the panel.
pub fn plugin(app: &mut App) {
    app.init_resource::<Panel>()
        .add_plugins((figures::plugin, graph::plugin, widgets::plugin))
        .add_systems(Startup, layout::spawn)
        .add_systems(Update, hide.run_if(resource_changed::<Panel>))
        .add_systems(PostUpdate, make_room.before(CameraUpdateSystems));
}

fn hide(panel: Res<Panel>, mut root: Single<&mut Node, With<Root>>) {
    root.display = if panel.is_hidden {
        Display::None
    } else {
        Display::Flex
    };
}

/// The middle of what is looked at is in the middle of what the panel leaves.
fn make_room(panel: Res<Panel>, mut camera: Single<&mut Camera, With<Camera3d>>) {
    let Some(size) = camera.logical_target_size() else {
        return;
    };
    // As if the picture went on beyond its right side.
    let size = size.as_uvec2();
    let view = SubCameraView {
        full_size: size + UVec2::new(layout::WIDTH as u32, 0),
        offset: Vec2::ZERO,
        size,
    };
    let view = (!panel.is_hidden).then_some(view);
    if camera.sub_camera_view != view {
        camera.sub_camera_view = view;
    }
}

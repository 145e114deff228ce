//! The panel: what the scene is, what happens in it, and what can be chosen; of Bevy's own widgets.

mod figures;
mod graph;
mod layout;
mod widgets;

use bevy::{picking::hover::Hovered, prelude::*};

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
        .add_systems(Update, hide.run_if(resource_changed::<Panel>));
}

fn hide(panel: Res<Panel>, mut root: Single<&mut Node, With<Root>>) {
    root.display = if panel.is_hidden {
        Display::None
    } else {
        Display::Flex
    };
}

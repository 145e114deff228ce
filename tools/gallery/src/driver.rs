//! Is there anything to draw with?

use bevy::{render::settings::WgpuSettings, tasks::block_on};
use wgpu::{Instance, InstanceDescriptor, RequestAdapterOptions};

/// What is told where nothing is found.
pub const MISSING: &str = "\
no driver to draw with was found: neither of a graphics card nor one that draws by software.
On Debian and Ubuntu: apt-get install mesa-vulkan-drivers libvulkan1
On Fedora: dnf install mesa-vulkan-drivers vulkan-loader
On Arch: pacman -S vulkan-swrast vulkan-icd-loader";

/// Returns `true` if Bevy's renderer will find an adapter; it would panic otherwise.
pub fn is_there() -> bool {
    let settings = WgpuSettings::default();
    let Some(backends) = settings.backends else {
        return false;
    };
    let instance = Instance::new(InstanceDescriptor {
        backends,
        ..InstanceDescriptor::new_without_display_handle()
    });
    let wish = RequestAdapterOptions {
        power_preference: settings.power_preference,
        ..RequestAdapterOptions::default()
    };
    block_on(instance.request_adapter(&wish)).is_ok()
}

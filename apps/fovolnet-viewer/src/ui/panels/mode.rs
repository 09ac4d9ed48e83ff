use super::fields::{choice, set};
use eframe::egui::{Slider, Ui};
use fovolnet::core::Projection;
use fovolnet::{Mode, RenderOverrides};

/// Panel for what pixels show of the values along their rays; `range` are the values shown.
pub fn mode(ui: &mut Ui, settings: &mut RenderOverrides, range: [f64; 2]) {
    let mut mode = settings.mode();
    choice(ui, "Mode", &mut mode, &Mode::ALL, |mode| match mode {
        Mode::Composite => "composite",
        Mode::Mip => "greatest value (MIP)",
        Mode::Minip => "least value (MinIP)",
        Mode::Average => "average",
        Mode::Isosurface => "isosurface",
    });
    if mode != settings.mode() {
        settings.mode = (mode != Mode::Composite).then_some(mode);
        if mode != Mode::Isosurface {
            settings.iso = None;
        }
    }
    let [lo, hi] = range;
    if mode == Mode::Isosurface && lo < hi {
        let mut value = settings.iso.unwrap_or(0.5 * (lo + hi)).clamp(lo, hi);
        let name = if settings.iso.is_some() { "Value" } else { "Value (chosen by the program)" };
        if ui.add(Slider::new(&mut value, lo..=hi).text(name)).changed() {
            settings.iso = Some(value);
        }
    }
}

/// Choice between perspective and parallel rays.
pub fn projection(ui: &mut Ui, settings: &mut RenderOverrides) {
    let usual = Projection::default();
    let mut projection = settings.projection.unwrap_or(usual);
    ui.horizontal(|ui| {
        ui.label("Projection");
        ui.selectable_value(&mut projection, Projection::Perspective, "perspective");
        let parallel = ui.selectable_value(&mut projection, Projection::Orthographic, "orthographic");
        parallel.on_hover_text("Parallel rays: lengths look the same at every depth");
    });
    set(&mut settings.projection, projection, usual);
}

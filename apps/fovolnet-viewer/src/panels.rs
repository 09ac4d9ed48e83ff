//! Panels for settings and statistics.

use crate::colour_button::colour_button;
use crate::display_mode::DisplayMode;
use crate::frame_producer::{Presented, Progress};
use crate::gaze::GazeKind;
use crate::marks::short;
use crate::outline::outline;
use crate::places::Preferences;
use crate::range_slider::range_slider;
use crate::text_field::TextField;
use eframe::egui::{
    Align, Color32, ComboBox, DragValue, Label, Layout, Mesh, Rect, RichText, Sense, Shape, Slider, Stroke,
    Ui, pos2, vec2,
};
use fovolnet::core::{Integration, ShadowMode, SurfaceShading};
use fovolnet::{
    Choice, CropBox, NamedView, Orientation, Reconstruction, RenderOverrides, RenderSettings, Sampling,
    Timings,
};
use glam::{DVec3, Vec3};
use std::collections::VecDeque;
use std::f32::consts::{FRAC_PI_2, TAU};

/// Panel for light, shadows and background.
pub fn scene(ui: &mut Ui, settings: &mut RenderOverrides) {
    let usual = RenderSettings::default();
    ui.horizontal(|ui| {
        light_ball(ui, settings);
        ui.vertical(|ui| {
            let mut shadows = settings.shadows.unwrap_or(usual.shadows);
            ui.horizontal(|ui| {
                ui.label("Shadows");
                for (mode, name) in
                    [(ShadowMode::On, "on"), (ShadowMode::Cached, "cached"), (ShadowMode::Off, "off")]
                {
                    ui.selectable_value(&mut shadows, mode, name);
                }
            });
            set(&mut settings.shadows, shadows, usual.shadows);
            let mut surface = settings.shading.unwrap_or(usual.shading);
            ui.horizontal(|ui| {
                ui.label("Shading");
                ui.selectable_value(&mut surface, SurfaceShading::Flat, "flat");
                ui.selectable_value(&mut surface, SurfaceShading::Gradient, "gradient");
            });
            set(&mut settings.shading, surface, usual.shading);
        });
    });
    number(ui, "Ambient", &mut settings.ambient, usual.ambient, 0.0..=1.0, false);
    number(ui, "Step (voxels)", &mut settings.step, usual.step, 0.1..=4.0, true);
    ui.horizontal(|ui| {
        ui.label("Background");
        let mut colour = settings.background.unwrap_or(usual.background);
        if colour_button(ui, &mut colour) {
            settings.background = Some(colour);
        }
    });
    let mut integration = settings.integration.unwrap_or(usual.integration);
    ui.horizontal(|ui| {
        ui.label("Integration");
        ui.selectable_value(&mut integration, Integration::Fine, "fine");
        ui.selectable_value(&mut integration, Integration::Plain, "plain");
    });
    set(&mut settings.integration, integration, usual.integration);
}

/// Panel for the volume's orientation and the named views. `has_placement` tells whether the file has a patient
/// position.
pub fn standing(ui: &mut Ui, settings: &mut RenderOverrides, has_placement: bool) {
    ui.horizontal(|ui| {
        ui.label("Orientation");
        ui.add_enabled_ui(has_placement, |ui| {
            for (choice, name) in
                [(None, "auto"), (Some(Orientation::Grid), "grid"), (Some(Orientation::Patient), "patient")]
            {
                ui.selectable_value(&mut settings.orientation, choice, name);
            }
        });
    });
    ui.horizontal_wrapped(|ui| {
        ui.label("View");
        for view in NamedView::ALL {
            let is_shown = settings.view == Some(view) && settings.camera.is_none();
            if ui.selectable_label(is_shown, view.name()).clicked() {
                (settings.view, settings.camera, settings.path) = (Some(view), None, None);
                settings.first_frame = None;
            }
        }
    });
}

/// Panel for the crop box, in voxels of a volume of `dims`.
pub fn clipping(ui: &mut Ui, settings: &mut RenderOverrides, dims: [usize; 3]) {
    let before = settings.clip.unwrap_or(CropBox::WHOLE);
    let mut now = before;
    for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
        let voxels = dims[axis] as f64;
        let range = &mut now.sides[axis];
        ui.horizontal(|ui| {
            ui.label(name);
            let [from, to] = range.map(|side| (side * voxels * 10.0).round() / 10.0);
            let numbers = format!("{from}–{to}");
            let width = ui.available_width() - 70.0;
            ui.allocate_ui(vec2(width, 18.0), |ui| range_slider(ui, range, 1.0 / voxels));
            ui.weak(numbers);
        });
    }
    ui.horizontal(|ui| {
        ui.label("Slice");
        for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
            let hint = "A slab of two voxels in the middle; drag it through the volume with its slider";
            if ui.button(name).on_hover_text(hint).clicked() {
                let half = 1.0 / dims[axis] as f64;
                now = CropBox::WHOLE;
                now.sides[axis] = [(0.5 - half).max(0.0), (0.5 + half).min(1.0)];
            }
        }
        if ui.button("Whole").clicked() {
            now = CropBox::WHOLE;
        }
    });
    if now != before {
        settings.clip = (now != CropBox::WHOLE).then_some(now);
    }
}

/// Shaded ball that shows the light; dragging turns the light.
fn light_ball(ui: &mut Ui, settings: &mut RenderOverrides) {
    let (rect, response) = ui.allocate_exact_size(vec2(64.0, 64.0), Sense::click_and_drag());
    let response = response.on_hover_text("Drag to turn the light; over the picture with L held down");
    let light = settings.light.unwrap_or(RenderSettings::default().light.into());
    let mut direction = DVec3::from_array(light).normalize_or(DVec3::Y);
    if response.dragged()
        && let Some(at) = response.interact_pointer_pos()
    {
        let part = (at - rect.center()) / (0.5 * rect.width());
        let [x, y] = [f64::from(part.x), -f64::from(part.y)];
        let across = x.hypot(y);
        // Dragged beyond the edge, the light moves behind.
        let z = if across <= 1.0 { (1.0 - across * across).sqrt() } else { (1.0 - across).max(-1.0) };
        direction = DVec3::new(x, y, z).normalize_or(direction);
        settings.light = Some(direction.to_array());
    }
    ui.painter().add(Shape::mesh(ball(rect, direction.as_vec3())));
    let edge = Stroke::new(1.0, ui.visuals().weak_text_color());
    ui.painter().circle_stroke(rect.center(), 0.5 * rect.width(), edge);
}

/// Mesh of a ball that fills `rect`, lit from the view-space direction `light`.
fn ball(rect: Rect, light: Vec3) -> Mesh {
    const RINGS: u32 = 14;
    const SECTORS: u32 = 40;
    let mut mesh = Mesh::default();
    for ring in 0..=RINGS {
        for sector in 0..SECTORS {
            let across = (ring as f32 / RINGS as f32 * FRAC_PI_2).sin();
            let (sin, cos) = (sector as f32 / SECTORS as f32 * TAU).sin_cos();
            let normal = Vec3::new(across * cos, across * sin, (1.0 - across * across).max(0.0).sqrt());
            let shade = 0.15 + 0.85 * normal.dot(light).max(0.0);
            let at = rect.center() + vec2(normal.x, -normal.y) * (0.5 * rect.width());
            mesh.colored_vertex(at, Color32::from_gray((shade * 255.0) as u8));
        }
    }
    for ring in 0..RINGS {
        for sector in 0..SECTORS {
            let next = (sector + 1) % SECTORS;
            let [a, b] = [sector, next].map(|sector| ring * SECTORS + sector);
            mesh.add_triangle(a, b, a + SECTORS);
            mesh.add_triangle(b, b + SECTORS, a + SECTORS);
        }
    }
    mesh
}

/// Panel for sampling and reconstruction.
pub fn sampling(ui: &mut Ui, settings: &mut RenderOverrides, gaze: &mut GazeKind) {
    let usual = RenderSettings::default();
    number(ui, "Density P_b", &mut settings.pb, usual.pb, 0.005..=1.0, true);
    number(ui, "Fovea σ", &mut settings.sigma, usual.sigma, 0.0..=0.5, false);
    ui.horizontal(|ui| {
        ui.label("Gaze");
        ui.selectable_value(gaze, GazeKind::Pointer, "pointer");
        ui.selectable_value(gaze, GazeKind::Session, "session");
        if *gaze == GazeKind::Session {
            let given = settings.gaze.clone().unwrap_or_default();
            let hint = "X,Y as fractions from the top left, wander, or a TOML file of stops";
            let field = TextField { name: "gaze", width: 90.0, hint, usual: "" };
            let (text, response) = field.ui(ui, &given.to_string());
            if response.changed() {
                settings.gaze = Some(text.into());
            }
        }
    });
    let mut how = settings.sampling.unwrap_or(Choice::Auto);
    let ways: Vec<Choice<Sampling>> =
        std::iter::once(Choice::Auto).chain(Sampling::ALL.map(Choice::Fixed)).collect();
    choice(ui, "Sampling", &mut how, &ways, |way| way.to_string());
    settings.sampling = (how != Choice::Auto).then_some(how);
    let mut reconstruct = settings.reconstruction();
    let ways: Vec<Reconstruction> = ["none", "pull-push", "linear", "wnet", "deepfovea"]
        .iter()
        .filter_map(|name| name.parse().ok())
        .collect();
    choice(ui, "Reconstruction", &mut reconstruct, &ways, |way| way.to_string());
    settings.reconstruct = Some(reconstruct);
    if let Some(network) = reconstruct.default_network() {
        ui.horizontal(|ui| {
            ui.label("Weights");
            let given = settings.weights.clone().unwrap_or_default();
            let hint = "wnet-fast, wnet-paper, deepfovea-fvn, or a file of weights (.safetensors, .pt)";
            let field = TextField { name: "weights", width: 150.0, hint, usual: network.name() };
            let (text, response) = field.ui(ui, &given);
            if response.lost_focus() {
                settings.weights = (!text.is_empty()).then_some(text);
            }
        });
    }
}

/// Panel for the frame rate in motion.
pub fn budget(ui: &mut Ui, preferences: &mut Preferences, shown: Option<&Presented>) {
    ui.horizontal(|ui| {
        let mut keeps = preferences.rate > 0.0;
        if ui.checkbox(&mut keeps, "Keep").changed() {
            preferences.rate = if keeps { Preferences::default().rate } else { 0.0 };
        }
        ui.add_enabled_ui(keeps, |ui| {
            let rate = DragValue::new(&mut preferences.rate).range(1.0..=240.0).speed(0.2).max_decimals(0);
            let rate = ui.add(rate);
            let label = ui.label("frames a second in motion").id;
            rate.labelled_by(label);
        });
    });
    ui.checkbox(&mut preferences.converges, "Still views become the full frame");
    let Some(shown) = shown else { return };
    if let Some(rung) = shown.rung.filter(|_| shown.progress == Progress::Moving) {
        let settings = &shown.settings;
        ui.weak(format!(
            "Now {} ({:.0} %), P_b {:.3}, σ {:.3}, step {:.2}, {}",
            shown.size,
            rung.scale * 100.0,
            settings.pb,
            settings.sigma,
            settings.step,
            settings.reconstruction,
        ));
    }
}

/// Panel for the display mode.
pub fn looks(ui: &mut Ui, look: &mut DisplayMode) {
    ui.horizontal_wrapped(|ui| {
        for each in DisplayMode::ALL {
            ui.selectable_value(look, each, each.name()).on_hover_text(each.explanation());
        }
    });
}

/// Number of frames in the plot of times.
pub const HISTORY: usize = 120;

/// Width of the names of facts, in points.
const NAMES: f32 = 64.0;

/// Shows a fact and its name at fixed widths. A grid would adapt its columns to the content, and redraw the window
/// whenever a number gets wider.
fn fact(ui: &mut Ui, name: &str, value: String) {
    ui.horizontal(|ui| {
        let size = vec2(NAMES, ui.spacing().interact_size.y);
        ui.allocate_ui_with_layout(size, Layout::left_to_right(Align::Center), |ui| {
            ui.set_min_width(NAMES);
            ui.weak(name);
        });
        ui.add(Label::new(value).truncate());
    });
}

/// Panel of facts about the picture.
pub fn statistics(ui: &mut Ui, shown: &Presented, rate: f64, history: &VecDeque<Timings>) {
    ui.scope(|ui| {
        ui.spacing_mut().item_spacing.y = 2.0;
        let mut row = |name: &str, value: String| fact(ui, name, value);
        let state = match shown.progress {
            Progress::Moving => "in motion".into(),
            Progress::Converging(share) => format!("{:.0} % measured", share * 100.0),
            Progress::Complete => "all of it measured".into(),
        };
        row("Picture", format!("{}, {state}", shown.size));
        // Still views are refined to full density; this shows the density that they began with.
        let density = if shown.progress == Progress::Moving { "Density" } else { "In motion" };
        row(density, format!("{:.1} % of the pixels", shown.density * 100.0));
        let is_complete = shown.progress == Progress::Complete;
        row("Pictures", if is_complete { "at rest".into() } else { format!("{rate:.1} a second") });
        row("Frame", format!("{:.1} ms", shown.timings.total));
        for pair in shown.timings.finer().chunks(2) {
            let part = |(stage, ms): &(&str, f64)| format!("{stage} {ms:.1}");
            row("", pair.iter().map(part).collect::<Vec<_>>().join(", "));
        }
        if let Some(quality) = shown.quality {
            let jod = quality.jod.map_or_else(|| "too small for JOD".into(), |jod| format!("{jod:.2} JOD"));
            row("Quality", format!("{:.1} dB, {jod}", quality.psnr));
        }
        let machine = &shown.machine;
        row("Made by", machine.gpu.clone().unwrap_or_else(|| machine.cpu.clone()));
    });
    plot(ui, history);
}

/// Stacked plot of the last frames' stage times.
fn plot(ui: &mut Ui, history: &VecDeque<Timings>) {
    let (rect, response) = ui.allocate_exact_size(vec2(ui.available_width(), 54.0), Sense::hover());
    let painter = ui.painter_at(rect);
    outline(&painter, rect, ui.visuals());
    let most = history.iter().map(|t| t.total).fold(1.0, f64::max);
    let width = rect.width() / HISTORY as f32;
    for (i, times) in history.iter().enumerate() {
        let left = rect.right() - (history.len() - i) as f32 * width;
        let mut bottom = rect.bottom();
        for (ms, colour) in [times.mask, times.march, times.reconstruct].into_iter().zip(STAGES) {
            let height = (ms / most) as f32 * (rect.height() - 12.0);
            let bar = Rect::from_min_max(pos2(left, bottom - height), pos2(left + width, bottom));
            painter.rect_filled(bar, 0.0, colour);
            bottom -= height;
        }
    }
    let text = RichText::new(format!("{} ms", short(most))).small();
    painter.text(
        rect.left_top() + vec2(3.0, 1.0),
        eframe::egui::Align2::LEFT_TOP,
        text.text(),
        eframe::egui::FontId::proportional(10.0),
        ui.visuals().weak_text_color(),
    );
    response.on_hover_ui(|ui| {
        for (name, colour) in ["mask", "march", "fill"].into_iter().zip(STAGES) {
            ui.colored_label(colour, name);
        }
    });
}

/// Colours of the stages mask, march and reconstruction.
const STAGES: [Color32; 3] =
    [Color32::from_rgb(120, 120, 200), Color32::from_rgb(230, 150, 60), Color32::from_rgb(80, 170, 140)];

/// Slider for an optional number.
fn number(
    ui: &mut Ui,
    name: &str,
    value: &mut Option<f64>,
    default: f64,
    range: std::ops::RangeInclusive<f64>,
    logarithmic: bool,
) {
    let mut now = value.unwrap_or(default);
    let slider = Slider::new(&mut now, range).logarithmic(logarithmic).max_decimals(3).text(name);
    let response = ui.add(slider).on_hover_text("Double click: as usual");
    if response.changed() {
        *value = Some(now);
    }
    if response.double_clicked() {
        *value = None;
    }
}

/// List to choose from.
fn choice<T: Copy + PartialEq, N: Into<String>>(
    ui: &mut Ui,
    name: &str,
    value: &mut T,
    all: &[T],
    name_of: impl Fn(T) -> N,
) {
    ui.horizontal(|ui| {
        let label = ui.label(name).id;
        let list = ComboBox::from_id_salt(name).selected_text(name_of(*value).into()).show_ui(ui, |ui| {
            for &each in all {
                ui.selectable_value(value, each, name_of(each).into());
            }
        });
        list.response.labelled_by(label);
    });
}

/// Stores `value` in a setting, unless the setting is empty and the value is the `usual` one.
fn set<T: Copy + PartialEq>(given: &mut Option<T>, value: T, usual: T) {
    if given.is_some() || value != usual {
        *given = Some(value);
    }
}

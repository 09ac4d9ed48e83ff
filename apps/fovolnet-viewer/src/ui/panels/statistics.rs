use crate::frames::presented::{Presented, Progress};
use crate::ui::picture::marks::short;
use crate::ui::widgets::outline::outline;
use eframe::egui::{Align, Color32, Label, Layout, Rect, RichText, Sense, Ui, pos2, vec2};
use fovolnet::Timings;
use std::collections::VecDeque;

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
        let plan = shown.plan.as_ref().filter(|_| shown.progress == Progress::Moving);
        if let Some((psnr, [least, most])) = plan.and_then(|plan| plan.psnr.zip(plan.psnr_range)) {
            row("Quality", format!("{psnr:.1} dB at probes, {least:.1} to {most:.1}"));
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

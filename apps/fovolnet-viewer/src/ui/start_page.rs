//! Start page, shown while nothing is open.

use crate::ui::thumbnails::Thumbnails;
use eframe::egui::{
    Align, Align2, Color32, FontId, Layout, Rect, RichText, Role, ScrollArea, Sense, Ui, Vec2, WidgetInfo,
    pos2, vec2,
};
use fovolnet::io::procedural::Procedural;

/// Choice on the start page.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Choice {
    /// Ask for a file.
    Browse,
    /// Open this source.
    Open(String),
}

/// Shows the built-in volumes and the recent files.
pub fn show(ui: &mut Ui, recent: &[String], thumbnails: &Thumbnails) -> Option<Choice> {
    let mut choice = None;
    ScrollArea::vertical().show(ui, |ui| {
        ui.with_layout(Layout::top_down(Align::Center), |ui| {
            ui.add_space(0.08 * ui.available_height().min(800.0) + 12.0);
            ui.label(RichText::new("FoVolNet").size(34.0).strong());
            ui.label("Drop a volume or a session here, or");
            ui.add_space(6.0);
            if ui.button(RichText::new("Open a file…").size(18.0)).clicked() {
                choice = Some(Choice::Browse);
            }
            ui.weak("DICOM, raw, NRRD, NIfTI, MetaImage, VTK, TIFF stacks");
            ui.add_space(24.0);
            ui.strong("Volumes that come with the program");
            ui.add_space(4.0);
            for row in Procedural::ALL.chunks(4) {
                ui.horizontal(|ui| {
                    let width = (CARD.x + ui.spacing().item_spacing.x) * row.len() as f32;
                    ui.add_space((0.5 * (ui.available_width() - width)).max(0.0));
                    for &kind in row {
                        if card(ui, kind, thumbnails) {
                            choice = Some(Choice::Open(kind.name().into()));
                        }
                    }
                });
            }
            if !recent.is_empty() {
                ui.add_space(24.0);
                ui.strong("Opened last");
                for source in recent {
                    let link = eframe::egui::Button::new(middle_cut(source, 70)).frame(false);
                    if ui.add(link).on_hover_text(source).clicked() {
                        choice = Some(Choice::Open(source.clone()));
                    }
                }
            }
        });
    });
    choice
}

/// Size of a card in points, including its name.
const CARD: Vec2 = vec2(150.0, 128.0);

/// Clickable card of a volume.
fn card(ui: &mut Ui, kind: Procedural, thumbnails: &Thumbnails) -> bool {
    let (rect, response) = ui.allocate_exact_size(CARD, Sense::click());
    let name = kind.name();
    response.widget_info(|| WidgetInfo::labeled(Role::Button, true, name));
    let style = ui.style().interact(&response);
    let painter = ui.painter();
    painter.rect_filled(rect, 4.0, style.weak_bg_fill);
    let picture = Rect::from_min_max(rect.min, rect.max - vec2(0.0, 22.0)).shrink(2.0);
    painter.rect_filled(picture, 2.0, Color32::BLACK);
    if let Some(texture) = thumbnails.of(kind) {
        let uv = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
        painter.image(texture.id(), picture, uv, Color32::WHITE);
    }
    let below = pos2(rect.center().x, rect.bottom() - 11.0);
    painter.text(below, Align2::CENTER_CENTER, name, FontId::proportional(13.0), style.text_color());
    response.clicked()
}

/// Shortens `text` to at most `most` characters by cutting out its middle.
pub fn middle_cut(text: &str, most: usize) -> String {
    let characters: Vec<char> = text.chars().collect();
    if characters.len() <= most {
        return text.to_owned();
    }
    let head = most / 3;
    let tail = characters.len() - (most - head - 1);
    characters[..head].iter().chain(['…'].iter()).chain(&characters[tail..]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_names_keep_their_ends() {
        assert_eq!(middle_cut("short", 9), "short");
        let cut = middle_cut("/a/very/long/path/to/some/volume.nrrd", 20);
        assert_eq!(cut.chars().count(), 20);
        assert!(cut.starts_with("/a/ver") && cut.ends_with("/volume.nrrd"));
    }
}

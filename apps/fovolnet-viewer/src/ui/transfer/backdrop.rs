//! Backdrop of the transfer-function editor: a histogram of values, or of material boundaries.

use crate::job::Job;
use crate::ui::transfer::boundaries::{Boundaries, ENOUGH, MAGNITUDES, VALUES};
use crate::ui::transfer::histogram::Histogram;
use eframe::egui::{
    Color32, ColorImage, Context, Painter, Pos2, Rect, TextureHandle, TextureOptions, Ui, Visuals, pos2,
};
use fovolnet::OpenVolume;
use std::fmt;
use std::sync::Arc;

/// Backdrop of the transfer-function editor.
#[derive(Debug)]
pub struct Backdrop {
    histogram: Histogram,
    boundaries: Option<Counted>,
    shows_boundaries: bool,
}

/// State of the boundary histogram.
enum Counted {
    Counting(Job<Boundaries>),
    Known(TextureHandle),
    Failed(String),
}

impl Backdrop {
    /// Backdrop for `volume`.
    pub fn new(volume: &OpenVolume) -> Self {
        Self { histogram: Histogram::new(volume), boundaries: None, shows_boundaries: false }
    }

    /// Histogram of the values.
    pub fn histogram(&self) -> &Histogram {
        &self.histogram
    }

    /// Whether a background job is counting.
    pub fn is_counting(&self) -> bool {
        matches!(self.boundaries, Some(Counted::Counting(_)))
    }

    /// Shows the switch between histogram and boundaries.
    pub(crate) fn ui(&mut self, ui: &mut Ui, volume: &OpenVolume) {
        ui.horizontal(|ui| {
            ui.label("Behind");
            ui.selectable_value(&mut self.shows_boundaries, false, "values")
                .on_hover_text("How often each value comes (logarithm)");
            ui.selectable_value(&mut self.shows_boundaries, true, "boundaries").on_hover_text(
                "How often values (to the right) and gradients (up) come together: where two materials meet there is an arch \
                 between their values. Opacity half way under an arch shows that boundary alone.",
            );
            match &self.boundaries {
                Some(Counted::Counting(_)) if self.shows_boundaries => {
                    ui.spinner();
                }
                Some(Counted::Failed(why)) if self.shows_boundaries => {
                    ui.weak(why);
                }
                _ => {}
            }
        });
        if self.shows_boundaries {
            self.count(ui.ctx(), volume);
        }
    }

    /// Starts counting boundaries, or takes the result.
    fn count(&mut self, context: &Context, volume: &OpenVolume) {
        match &self.boundaries {
            None => {
                let (volume, wake) = (Arc::clone(&volume.volume), context.clone());
                let work = move |_: &crate::job::Handle| Ok(Boundaries::new(&volume, ENOUGH));
                self.boundaries = Some(match Job::start("counting", move || wake.request_repaint(), work) {
                    Ok(job) => Counted::Counting(job),
                    Err(error) => Counted::Failed(format!("cannot start a thread: {error}")),
                });
            }
            Some(Counted::Counting(job)) => match job.take() {
                Some(Ok(found)) => self.boundaries = Some(Counted::Known(texture(context, &found))),
                Some(Err(error)) => self.boundaries = Some(Counted::Failed(error.to_string())),
                None => {}
            },
            Some(Counted::Known(_) | Counted::Failed(_)) => {}
        }
    }

    /// Opacity of the transfer function's colours over the backdrop, 0 to 1.
    pub(crate) fn cover(&self) -> f32 {
        if self.shows_boundaries { 0.35 } else { 0.75 }
    }

    /// Draws the backdrop.
    pub(crate) fn paint(&self, painter: &Painter, plot: Rect, visuals: &Visuals) {
        match &self.boundaries {
            Some(Counted::Known(texture)) if self.shows_boundaries => {
                let uv = Rect::from_min_max(Pos2::ZERO, pos2(1.0, 1.0));
                painter.image(texture.id(), plot, uv, visuals.strong_text_color());
            }
            _ => self.histogram.paint(painter, plot, visuals.weak_text_color().gamma_multiply(0.5)),
        }
    }
}

/// White texture whose opacity is the frequency; large gradient magnitudes are on top.
fn texture(context: &Context, boundaries: &Boundaries) -> TextureHandle {
    let brightness: Vec<f32> = boundaries.brightness().collect();
    let rows = brightness.chunks_exact(VALUES).rev().flatten();
    let pixels = rows.map(|&share| Color32::from_white_alpha((share * 255.0).round() as u8)).collect();
    let image = ColorImage::new([VALUES, MAGNITUDES], pixels);
    context.load_texture("boundaries", image, TextureOptions::LINEAR)
}

impl fmt::Debug for Counted {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Counting(_) => "Counting",
            Self::Known(_) => "Known",
            Self::Failed(_) => "Failed",
        })
    }
}

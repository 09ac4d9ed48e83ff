use super::fields::{choice, number};
use crate::frames::gaze::GazeKind;
use crate::ui::widgets::text_field::TextField;
use eframe::egui::Ui;
use fovolnet::{Choice, Density, Guide, Reconstruction, RenderOverrides, RenderSettings, Sampling};

/// Panel for sampling and reconstruction.
pub fn sampling(ui: &mut Ui, settings: &mut RenderOverrides, gaze: &mut GazeKind) {
    let usual = RenderSettings::default();
    number(ui, "Density P_b", &mut settings.pb, usual.pb, 0.005..=1.0, true);
    number(ui, "Fovea σ", &mut settings.sigma, usual.sigma, 0.0..=0.5, false);
    ui.horizontal(|ui| {
        let label = ui.label("Gaze").id;
        ui.selectable_value(gaze, GazeKind::Pointer, "pointer");
        ui.selectable_value(gaze, GazeKind::Session, "session");
        if *gaze == GazeKind::Session {
            let given = settings.gaze.clone().unwrap_or_default();
            let hint = "X,Y as fractions from the top left, wander, or a TOML file of stops";
            let field = TextField { name: "gaze", width: 90.0, hint, usual: "" };
            let (text, response) = field.ui(ui, &given.to_string());
            if response.labelled_by(label).changed() {
                settings.gaze = Some(text.into());
            }
        }
    });
    let mut how = settings.sampling.unwrap_or(Choice::Auto);
    let ways: Vec<Choice<Sampling>> =
        std::iter::once(Choice::Auto).chain(Sampling::ALL.map(Choice::Fixed)).collect();
    choice(ui, "Sampling", &mut how, &ways, |way| way.to_string());
    settings.sampling = (how != Choice::Auto).then_some(how);
    let mut density = settings.density.unwrap_or(Choice::Auto);
    let ways: Vec<Choice<Density>> =
        std::iter::once(Choice::Auto).chain(Density::ALL.map(Choice::Fixed)).collect();
    choice(ui, "Density away from the gaze", &mut density, &ways, |way| way.to_string());
    settings.density = (density != Choice::Auto).then_some(density);
    let ways: Vec<Option<Reconstruction>> = std::iter::once(None)
        .chain(["none", "pull-push", "linear", "wnet", "deepfovea"].iter().map(|name| name.parse().ok()))
        .collect();
    choice(ui, "Reconstruction", &mut settings.reconstruct, &ways, |way| match way {
        None => "auto".to_owned(),
        Some(way) => way.to_string(),
    });
    let mut guide = settings.guide.unwrap_or(Choice::Auto);
    let ways: Vec<Choice<Guide>> =
        std::iter::once(Choice::Auto).chain(Guide::ALL.map(Choice::Fixed)).collect();
    choice(ui, "Guide", &mut guide, &ways, |way| way.to_string());
    settings.guide = (guide != Choice::Auto).then_some(guide);
    if let Some(network) = settings.reconstruction().default_network() {
        ui.horizontal(|ui| {
            let label = ui.label("Weights").id;
            let given = settings.weights.clone().unwrap_or_default();
            let hint = "wnet-fast, wnet-paper, deepfovea-fvn, or a file of weights (.safetensors, .pt)";
            let field = TextField { name: "weights", width: 150.0, hint, usual: network.name() };
            let (text, response) = field.ui(ui, &given);
            if response.labelled_by(label).lost_focus() {
                settings.weights = (!text.is_empty()).then_some(text);
            }
        });
    }
}

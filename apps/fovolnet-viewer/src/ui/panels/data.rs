use super::fields::choice;
use eframe::egui::{Button, DragValue, Response, Slider, Ui};
use fovolnet::core::Volume;
use fovolnet::{OpenVolume, VolumeSettings};

/// Panel for the part of the file that is shown, and the range of its values. Returns changed settings, with which the file
/// must be read again. `series` are the names of the series of a DICOM folder.
pub fn data(
    ui: &mut Ui,
    read: &VolumeSettings,
    volume: &OpenVolume,
    series: &[String],
) -> Option<VolumeSettings> {
    let mut changed = read.clone();
    series_choice(ui, &mut changed, series);
    parts(ui, &mut changed, &volume.volume);
    shown_range(ui, &mut changed, &volume.volume);
    (changed != *read).then_some(changed)
}

/// Whether there is anything to choose of `volume` besides its range.
pub fn has_parts(volume: &Volume, series: &[String]) -> bool {
    let contents = volume.contents();
    let counts = [contents.arrays.len(), contents.channels.len(), contents.times, contents.components];
    series.len() > 1 || counts.iter().any(|count| *count > 1)
}

fn series_choice(ui: &mut Ui, read: &mut VolumeSettings, series: &[String]) {
    if series.len() < 2 {
        return;
    }
    let number = read.series.as_ref().and_then(|series| series.parse::<usize>().ok());
    let all: Vec<Option<usize>> = std::iter::once(None).chain((1..=series.len()).map(Some)).collect();
    let mut chosen = number.filter(|number| *number <= series.len());
    choice(ui, "Series", &mut chosen, &all, |number| match number {
        None => "the one with most slices".to_owned(),
        Some(number) => series[number - 1].clone(),
    });
    if chosen != number {
        read.series = chosen.map(|number| number.to_string());
    }
}

/// Arrays, channels, time points and components, as far as there are several.
fn parts(ui: &mut Ui, read: &mut VolumeSettings, volume: &Volume) {
    let contents = volume.contents();
    if contents.arrays.len() > 1 {
        let mut array = contents.array;
        let all: Vec<usize> = (0..contents.arrays.len()).collect();
        choice(ui, "Array", &mut array, &all, |array| contents.arrays[array].clone());
        if array != contents.array {
            read.array = Some(contents.arrays[array].clone());
        }
    }
    if contents.channels.len() > 1 {
        let mut channel = contents.channel;
        let all: Vec<usize> = (0..contents.channels.len()).collect();
        choice(ui, "Channel", &mut channel, &all, |channel| match contents.channels[channel].as_str() {
            "" => channel.to_string(),
            name => format!("{channel}: {name}"),
        });
        if channel != contents.channel {
            read.channel = Some(channel);
        }
    }
    let numbers = [
        ("Time point", contents.time, contents.times, &mut read.time),
        ("Component", contents.component, contents.components, &mut read.component),
    ];
    for (name, shown, count, setting) in numbers {
        if count > 1 {
            let slider = |ui: &mut Ui, number: &mut f64| {
                ui.add(Slider::new(number, 0.0..=(count - 1) as f64).integer().text(name))
            };
            if let Some(number) = settled(ui, name, shown as f64, slider) {
                *setting = Some(number as usize);
            }
        }
    }
}

/// The shown range, as centre and width.
fn shown_range(ui: &mut Ui, read: &mut VolumeSettings, volume: &Volume) {
    let [lo, hi] = volume.range();
    let (centre, width) = (0.5 * (lo + hi), hi - lo);
    let field = |ui: &mut Ui, name: &str, shown: f64| {
        let label = ui.label(name).id;
        settled(ui, name, shown, |ui, number| {
            let field = DragValue::new(number).speed(0.002 * width).max_decimals(3);
            ui.add(field.update_while_editing(false)).labelled_by(label)
        })
    };
    ui.horizontal(|ui| {
        let moved = field(ui, "Window centre", centre);
        let widened = field(ui, "width", width).filter(|width| *width > 0.0);
        if moved.is_some() || widened.is_some() {
            read.range = None;
            read.window = Some([moved.unwrap_or(centre), widened.unwrap_or(width)]);
        }
        let is_chosen = read.shown_range().is_some();
        if ui.add_enabled(is_chosen, Button::new("As usual")).clicked() {
            (read.range, read.window) = (None, None);
        }
    });
}

/// Adds a control of a number that is `shown`. Returns another number once the user is done with it: reading a file takes
/// longer than a frame.
fn settled(
    ui: &mut Ui,
    name: &str,
    shown: f64,
    add: impl FnOnce(&mut Ui, &mut f64) -> Response,
) -> Option<f64> {
    let id = ui.scope_id().with(name);
    let mut number = ui.data(|data| data.get_temp(id)).unwrap_or(shown);
    let response = add(ui, &mut number);
    if response.dragged() {
        ui.data_mut(|data| data.insert_temp(id, number));
        return None;
    }
    ui.data_mut(|data| data.remove_temp::<f64>(id));
    (number != shown).then_some(number)
}

use super::fields::choice;
use eframe::egui::{Button, Checkbox, DragValue, Response, Slider, Ui};
use fovolnet::core::{MOST_VOLUMES, Volume};
use fovolnet::{ChannelChoice, ComponentChoice, OpenVolume, Rgb, VolumeSettings};

/// Panel for the part of the file that is shown, and the range of its values. Returns changed settings, with which the file
/// must be read again. `series` are the names of the series of a DICOM folder; `plays` says whether time points are played.
pub fn data(
    ui: &mut Ui,
    read: &VolumeSettings,
    (volume, series): (&OpenVolume, &[String]),
    plays: &mut bool,
) -> Option<VolumeSettings> {
    let mut changed = read.clone();
    series_choice(ui, &mut changed, series);
    parts(ui, &mut changed, volume, plays);
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
fn parts(ui: &mut Ui, read: &mut VolumeSettings, opened: &OpenVolume, plays: &mut bool) {
    let contents = opened.volume.contents();
    if contents.arrays.len() > 1 {
        let mut array = contents.array;
        let all: Vec<usize> = (0..contents.arrays.len()).collect();
        choice(ui, "Array", &mut array, &all, |array| contents.arrays[array].clone());
        if array != contents.array {
            read.array = Some(contents.arrays[array].clone());
        }
    }
    channels(ui, read, opened);
    ui.horizontal(|ui| {
        if let Some(time) = part(ui, "Time point", contents.time, contents.times) {
            read.time = Some(time.into());
        }
        if contents.times > 1 {
            ui.toggle_value(plays, "Play time points");
        }
    });
    components(ui, read, opened);
}

/// A slider for part `shown` of `count`, if there are several. Returns another part once it is chosen.
fn part(ui: &mut Ui, name: &str, shown: usize, count: usize) -> Option<usize> {
    if count < 2 {
        return None;
    }
    let slider = |ui: &mut Ui, number: &mut f64| {
        ui.add(Slider::new(number, 0.0..=(count - 1) as f64).integer().text(name))
    };
    settled(ui, name, shown as f64, slider).map(|number| number as usize)
}

/// A box for each channel, if there are several; those that are checked are blended.
fn channels(ui: &mut Ui, read: &mut VolumeSettings, opened: &OpenVolume) {
    let contents = opened.volume.contents();
    if contents.channels.len() < 2 {
        return;
    }
    let before = opened.channels();
    let mut shown = before.clone();
    ui.label("Channels");
    ui.horizontal_wrapped(|ui| {
        for (channel, name) in contents.channels.iter().enumerate() {
            let name = if name.is_empty() { channel.to_string() } else { format!("{channel}: {name}") };
            let mut is_shown = shown.contains(&channel);
            let may_change = if is_shown { shown.len() > 1 } else { shown.len() < MOST_VOLUMES };
            if ui.add_enabled(may_change, Checkbox::new(&mut is_shown, name)).changed() {
                shown.retain(|other| *other != channel);
                shown.extend(is_shown.then_some(channel));
            }
        }
    });
    if shown != before {
        shown.sort_unstable();
        read.channel = Some(match shown[..] {
            [one] => ChannelChoice::One(one),
            _ => ChannelChoice::Several(shown),
        });
    }
}

/// The component that is shown, or all as colours.
fn components(ui: &mut Ui, read: &mut VolumeSettings, opened: &OpenVolume) {
    let contents = opened.volume.contents();
    if contents.components < 2 {
        return;
    }
    let numbers = (0..contents.components).map(ComponentChoice::Number);
    let colours = ComponentChoice::Colours(Rgb::Rgb);
    let all: Vec<ComponentChoice> =
        numbers.chain(matches!(contents.components, 3 | 4).then_some(colours)).collect();
    let shown = if opened.colours.is_some() { colours } else { ComponentChoice::Number(contents.component) };
    let mut chosen = shown;
    choice(ui, "Component", &mut chosen, &all, |component| match component.number() {
        Some(number) => number.to_string(),
        None => "all, as colours".to_owned(),
    });
    if chosen != shown {
        read.component = Some(chosen);
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

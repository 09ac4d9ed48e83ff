use super::chosen::{load, placed};
use crate::{NanColour, OpenVolume, RenderOverrides, ValueScale};
use fovol_core::TransferFunction;

/// Notes on assumptions about the transfer function of `settings`, one line each; none if it cannot be read.
pub fn notes(settings: &RenderOverrides, volume: &OpenVolume) -> Vec<String> {
    let what = settings.tf.clone().unwrap_or_default();
    let Ok(imported) = load(&what, volume) else { return Vec::new() };
    let [from, to] = volume.volume.range();
    let mut notes = imported.notes.clone();
    if let Some([lo, hi]) = imported.transfer.range() {
        let stays =
            placed(&what, &imported, settings.tf_range).is_ok_and(|transfer| transfer.range().is_some());
        if !stays && settings.tf_range.is_none() && [lo, hi] != [from, to] {
            notes.push(format!(
                "its values {lo} to {hi} are stretched over those that are shown, {from} to {to}; --tf-range data keeps them"
            ));
        }
        if stays && (hi < from || lo > to) {
            notes.push(format!(
                "its values {lo} to {hi} lie outside those that are shown, {from} to {to}; --range LO,HI shows others, --tf-range stretch moves it"
            ));
        }
        if stays && settings.scale == Some(ValueScale::Log) {
            notes.push("it is in data values and stays there: --scale log changes nothing".into());
        }
    }
    notes.extend(note_of_nan(settings, volume, &imported.transfer));
    notes.into_iter().map(|note| format!("{what}: {note}")).collect()
}

/// Note on the colour of NaN in `transfer`, if `volume` has NaN.
fn note_of_nan(
    settings: &RenderOverrides,
    volume: &OpenVolume,
    transfer: &TransferFunction,
) -> Option<String> {
    let of_file = transfer.chosen_nan();
    let note = match (settings.nan, of_file) {
        (None, Some([r, g, b, a])) => {
            format!("its colour for NaN ({r},{g},{b},{a}) is left out; --nan file uses it")
        }
        (Some(NanColour::File), None) => {
            "it has no colour for NaN, which is transparent; --nan R,G,B,A gives one".into()
        }
        _ => return None,
    };
    (volume.volume.statistics().nan > 0).then_some(note)
}

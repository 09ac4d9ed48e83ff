//! `omero`: names, colours and windows of channels.

use crate::volume::zarr::json::Object;
use fovol_core::ChannelDisplay;
use serde_json::Value;

/// Names of channels and how they are shown.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Channels {
    /// Names; empty ones where there are none.
    pub names: Vec<String>,
    /// Colours and windows.
    pub displays: Vec<ChannelDisplay>,
}

/// The `count` channels in the metadata `ome`, as far as it describes them.
pub fn channels(ome: &Object, count: usize) -> Channels {
    let said = ome.get("omero").and_then(|omero| omero.get("channels")).and_then(Value::as_array);
    let said: Vec<&Value> = said.into_iter().flatten().take(count).collect();
    if said.is_empty() && count < 2 {
        return Channels::default();
    }
    let name = |channel: &&Value| channel.get("label").and_then(Value::as_str).unwrap_or_default().to_owned();
    let mut names: Vec<String> = said.iter().map(name).collect();
    names.resize(count, String::new());
    let mut displays: Vec<ChannelDisplay> = said.iter().map(|channel| display(channel)).collect();
    if displays.iter().any(|display| *display != ChannelDisplay::default()) {
        displays.resize(count, ChannelDisplay::default());
    } else {
        displays.clear();
    }
    Channels { names, displays }
}

fn display(channel: &Value) -> ChannelDisplay {
    let window = channel.get("window");
    let end = |key: &str| window?.get(key)?.as_f64().filter(|value| value.is_finite());
    let window = end("start").zip(end("end")).map(|(low, high)| [low, high]).filter(|[low, high]| low < high);
    ChannelDisplay {
        colour: channel.get("color").and_then(Value::as_str).and_then(colour),
        window,
        is_hidden: channel.get("active").and_then(Value::as_bool) == Some(false),
    }
}

/// The colour in hexadecimal digits, perhaps behind a number sign.
fn colour(text: &str) -> Option<[u8; 3]> {
    let digits = text.trim_start_matches('#').get(..6)?;
    let number = u32::from_str_radix(digits, 16).ok()?;
    let [_, red, green, blue] = number.to_be_bytes();
    Some([red, green, blue])
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn channels_have_names_colours_and_windows() {
        let ome = json!({"omero": {"channels": [
            {"label": "DAPI", "color": "0000FF", "active": false, "window": {"min": 0, "max": 9, "start": 1, "end": 8}},
            {"color": "#ff8000", "window": {"start": 3, "end": 3}}, {"color": "zz"}]}});
        let found = channels(ome.as_object().unwrap(), 4);
        assert_eq!(found.names, ["DAPI", "", "", ""]);
        let display = |colour, window, is_hidden| ChannelDisplay { colour, window, is_hidden };
        assert_eq!(
            found.displays,
            [
                display(Some([0, 0, 255]), Some([1.0, 8.0]), true),
                display(Some([255, 128, 0]), None, false),
                ChannelDisplay::default(),
                ChannelDisplay::default()
            ]
        );
        assert_eq!(channels(&Object::new(), 1), Channels::default());
        assert_eq!(channels(&Object::new(), 2).names, ["", ""]);
    }
}

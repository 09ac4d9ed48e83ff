//! Settings by the names of the command line's flags.

use crate::status::Failure;
use clap::{Arg, ArgAction, Args, Command};
use fovolnet::core::did_you_mean;
use fovolnet::{RenderOverrides, VolumeSettings, usage_line};
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::{Map, Value};

/// Group of settings that may be missing. JSON and flags share their names.
pub trait Overlay: Args + Serialize + DeserializeOwned + Default {
    /// Combines them with `over`, which takes precedence.
    #[must_use]
    fn under(self, over: Self) -> Self;
}

impl Overlay for RenderOverrides {
    fn under(self, over: Self) -> Self {
        self.overridden_by(over)
    }
}

impl Overlay for VolumeSettings {
    fn under(self, over: Self) -> Self {
        self.overridden_by(over)
    }
}

/// Sets the flag `name` of `settings` to `value`, as the command line reads it.
pub fn set<T: Overlay>(settings: &mut T, name: &str, value: &str) -> Result<(), Failure> {
    let over = parsed::<T>(name, value)?;
    *settings = std::mem::take(settings).under(over);
    Ok(())
}

/// Group `T` with nothing but the flag `name`, read from `value` as the command line does.
pub fn parsed<T: Args>(name: &str, value: &str) -> Result<T, Failure> {
    let command = command::<T>();
    let action = known(&command, name)?.get_action().clone();
    let argument = match (action, value) {
        (ArgAction::SetTrue, "true") => Some(format!("--{name}")),
        (ArgAction::SetTrue, "false") => None,
        (ArgAction::SetTrue, other) => {
            return Err(Failure::invalid(format!("{name}: `{other}` is neither true nor false")));
        }
        _ => Some(format!("--{name}={value}")),
    };
    let matches = command.try_get_matches_from(argument).and_then(|found| T::from_arg_matches(&found));
    matches.map_err(|error| Failure::invalid(usage_line(&error)))
}

/// Whether the group `T` has the flag `name`.
pub fn has<T: Args>(name: &str) -> bool {
    known(&command::<T>(), name).is_ok()
}

/// Sets everything in the JSON object `json`; null takes a setting back. Texts are read as the command line reads them. Nothing
/// is changed after an error.
pub fn set_json<T: Overlay + Clone>(settings: &mut T, json: &str) -> Result<(), Failure> {
    let mut changed = settings.clone();
    for (name, value) in &object(json)? {
        set_value(&mut changed, name, value)?;
    }
    *settings = changed;
    Ok(())
}

/// Sets the flag `name` of `settings` to a value of JSON.
pub fn set_value<T: Overlay + Clone>(settings: &mut T, name: &str, value: &Value) -> Result<(), Failure> {
    match value {
        Value::Null => unset(settings, name),
        Value::String(text) => set(settings, name, text),
        // Transfer functions.
        Value::Object(_) => set(settings, name, &value.to_string()),
        _ => {
            known(&command::<T>(), name)?;
            let over = of_json(name, Map::from_iter([(name.to_owned(), value.clone())]))?;
            *settings = std::mem::take(settings).under(over);
            Ok(())
        }
    }
}

/// Takes the flag `name` of `settings` back, so that its default holds.
pub fn unset<T: Overlay>(settings: &mut T, name: &str) -> Result<(), Failure> {
    known(&command::<T>(), name)?;
    let mut given = given(settings)?;
    given.remove(name);
    *settings = of_json(name, given)?;
    Ok(())
}

/// Settings that are given, by name.
pub fn given<T: Overlay>(settings: &T) -> Result<Map<String, Value>, Failure> {
    match serde_json::to_value(settings) {
        Ok(Value::Object(all)) => Ok(all.into_iter().filter(|(_, value)| !value.is_null()).collect()),
        Ok(_) => unreachable!("groups of settings are objects"),
        Err(error) => Err(Failure::invalid(format!("the settings cannot be written as JSON: {error}"))),
    }
}

/// The object in the text `json`.
pub fn object(json: &str) -> Result<Map<String, Value>, Failure> {
    serde_json::from_str(json).map_err(|error| {
        Failure::invalid(format!(
            "the settings are no JSON object ({error}); write them as {{\"shadows\": \"off\", \"step\": 0.5}}"
        ))
    })
}

fn of_json<T: DeserializeOwned>(name: &str, settings: Map<String, Value>) -> Result<T, Failure> {
    serde_json::from_value(Value::Object(settings))
        .map_err(|error| Failure::invalid(fovolnet::printable_line(&format!("{name}: {error}"))))
}

fn command<T: Args>() -> Command {
    let command = Command::new("settings").no_binary_name(true);
    T::augment_args(command).disable_help_flag(true).disable_version_flag(true)
}

/// The flag `name` of `command`.
fn known<'a>(command: &'a Command, name: &str) -> Result<&'a Arg, Failure> {
    let arguments = || command.get_arguments();
    arguments().find(|argument| argument.get_long() == Some(name)).ok_or_else(|| {
        let names: Vec<&str> = arguments().filter_map(Arg::get_long).collect();
        let (name, guess) = (fovolnet::printable_line(name), did_you_mean(name, &names));
        Failure::invalid(format!("`{name}` is no setting here{guess}; the settings are {}", names.join(", ")))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use fovolnet::ShadowRays;

    fn failure(result: Result<(), Failure>) -> String {
        result.unwrap_err().text
    }

    #[test]
    fn values_read_as_on_the_command_line() {
        let mut settings = RenderOverrides::default();
        set(&mut settings, "shadow-rays", "16").unwrap();
        set(&mut settings, "light", "-1,0.5,0").unwrap();
        assert_eq!(settings.shadow_rays, Some("16".parse::<ShadowRays>().unwrap()));
        assert_eq!(settings.light, Some([-1.0, 0.5, 0.0]));
        let text = failure(set(&mut settings, "shadow-ray", "16"));
        assert!(text.contains("did you mean shadow-rays?"), "{text}");
        let text = failure(set(&mut settings, "ambient", "much"));
        assert!(text.contains("ambient") && text.contains("no finite number"), "{text}");
        assert_eq!(settings.ambient, None);
    }

    #[test]
    fn json_takes_numbers_texts_and_null() {
        let mut settings = RenderOverrides::default();
        set_json(
            &mut settings,
            r#"{"size": [64, 48], "step": 1, "shadows": "off", "tf": {"points": [[0,0,0,0,0]]}}"#,
        )
        .unwrap();
        assert_eq!(settings.size.map(|size| size.width), Some(64));
        set_json(&mut settings, r#"{"size": "32x16", "step": null}"#).unwrap();
        let names: Vec<String> = given(&settings).unwrap().keys().cloned().collect();
        assert_eq!(names, ["shadows", "size", "tf"]);
        let text = failure(set_json(&mut settings, r#"{"shadows": "on", "step": []}"#));
        assert!(text.starts_with("step: "), "{text}");
        // Nothing of a wrong object is taken.
        assert_eq!(given(&settings).unwrap()["shadows"], "off");
        assert!(failure(set_json(&mut settings, "[]")).contains("no JSON object"));
    }
}

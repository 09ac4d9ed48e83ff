use crate::flags;
use crate::status::Failure;
use fovolnet::{RenderOverrides, SpeedSettings};
use serde_json::{Map, Value};

/// Settings of a renderer: those of pictures, and those of speed.
#[derive(Debug, Clone, Default)]
pub struct RenderFlags {
    pub pictures: RenderOverrides,
    pub speed: SpeedSettings,
}

impl RenderFlags {
    /// Sets the flag `name` to `value`, as the command line reads it.
    pub fn set(&mut self, name: &str, value: &str) -> Result<(), Failure> {
        if flags::has::<SpeedSettings>(name) {
            return self.take_speed(name, flags::parsed(name, value)?);
        }
        flags::set(&mut self.pictures, name, value)
    }

    /// Takes the flag `name` back.
    pub fn unset(&mut self, name: &str) -> Result<(), Failure> {
        if flags::has::<SpeedSettings>(name) {
            return self.take_speed(name, SpeedSettings::default());
        }
        flags::unset(&mut self.pictures, name)
    }

    /// Sets everything in the JSON object `json`.
    pub fn set_json(&mut self, json: &str) -> Result<(), Failure> {
        let mut changed = self.clone();
        for (name, value) in &flags::object(json)? {
            match value {
                Value::Null => changed.unset(name)?,
                Value::String(text) => changed.set(name, text)?,
                other if flags::has::<SpeedSettings>(name) => changed.set(name, &other.to_string())?,
                other => flags::set_value(&mut changed.pictures, name, other)?,
            }
        }
        *self = changed;
        Ok(())
    }

    /// Settings that are given, as JSON.
    pub fn json(&self) -> Result<String, Failure> {
        let mut all: Map<String, Value> = flags::given(&self.pictures)?;
        let SpeedSettings { threads, device, filtering, no_skip, .. } = &self.speed;
        let speed = [
            ("device", device.as_ref().map(|device| device.to_string().into())),
            ("filtering", filtering.as_ref().map(|filtering| filtering.to_string().into())),
            ("no-skip", no_skip.then_some(Value::Bool(true))),
            ("threads", threads.map(Value::from)),
        ];
        all.extend(speed.into_iter().filter_map(|(name, value)| Some((name.to_owned(), value?))));
        Ok(Value::Object(all).to_string())
    }

    /// Takes the flag `name` of `speed`.
    fn take_speed(&mut self, name: &str, speed: SpeedSettings) -> Result<(), Failure> {
        match name {
            "device" => self.speed.device = speed.device,
            "filtering" => self.speed.filtering = speed.filtering,
            "no-skip" => self.speed.no_skip = speed.no_skip,
            "threads" => self.speed.threads = speed.threads,
            other => return Err(Failure::invalid(format!("`{other}` cannot be set here"))),
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn speed_and_pictures_share_one_place() {
        let mut flags = RenderFlags::default();
        flags.set("device", "cpu").unwrap();
        flags.set_json(r#"{"threads": 2, "no-skip": true, "pb": 0.1}"#).unwrap();
        assert_eq!(flags.json().unwrap(), r#"{"device":"cpu","no-skip":true,"pb":0.1,"threads":2}"#);
        flags.set("no-skip", "false").unwrap();
        flags.unset("threads").unwrap();
        flags.unset("pb").unwrap();
        assert_eq!(flags.json().unwrap(), r#"{"device":"cpu"}"#);
        assert!(flags.set("no-skip", "perhaps").is_err() && flags.set("device", "cuda").is_err());
    }

    #[test]
    fn every_flag_of_speed_is_known() {
        use clap::Args;
        let command = SpeedSettings::augment_args(clap::Command::new("speed"));
        for name in command.get_arguments().filter_map(|argument| argument.get_long()) {
            RenderFlags::default().unset(name).unwrap();
        }
    }
}

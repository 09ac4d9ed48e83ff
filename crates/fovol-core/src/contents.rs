/// What the file of a volume holds, and which part of it the volume is.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Contents {
    /// The names of the arrays of values; empty where the format does not name any.
    pub arrays: Vec<String>,
    /// Which of the arrays this is.
    pub array: usize,
    /// The names of the channels; empty where the format has none.
    pub channels: Vec<String>,
    /// Which of the channels this is.
    pub channel: usize,
    /// The number of time points, 1 or more.
    pub times: usize,
    /// Which of the time points this is.
    pub time: usize,
    /// The number of values of each voxel, 1 or more.
    pub components: usize,
    /// Which of these values is shown.
    pub component: usize,
    /// Whether the file says that the components are colours.
    pub are_colours: bool,
    /// Whether the file says that the values are labels.
    pub are_labels: bool,
}

impl Default for Contents {
    fn default() -> Self {
        Self {
            arrays: Vec::new(),
            array: 0,
            channels: Vec::new(),
            channel: 0,
            times: 1,
            time: 0,
            components: 1,
            component: 0,
            are_colours: false,
            are_labels: false,
        }
    }
}

/// More names than this are not listed in a note.
const LISTED: usize = 12;

impl Contents {
    /// The name of the shown array, where it has one.
    pub fn array_name(&self) -> Option<&str> {
        self.arrays.get(self.array).map(String::as_str).filter(|name| !name.is_empty())
    }

    /// What is shown of several arrays, channels, time points and components: one line each, to follow the name of the file.
    pub fn notes(&self) -> Vec<String> {
        let mut notes = Vec::new();
        if self.arrays.len() > 1 {
            let (names, shown) = (listed(&self.arrays), &self.arrays[self.array]);
            notes.push(format!(
                "has {} arrays ({names}), `{shown}` is shown; --array NAME chooses another",
                self.arrays.len()
            ));
        }
        let channel = self.channels.get(self.channel).filter(|name| !name.is_empty());
        let channel = channel.map_or(String::new(), |name| format!(" ({name})"));
        let colours = if self.are_colours { " that are colours" } else { "" };
        for (count, what, shown, flag) in [
            (self.channels.len(), "channels", format!("{}{channel}", self.channel), "--channel"),
            (self.times, "time points", self.time.to_string(), "--time"),
            (self.components, &format!("components{colours}"), self.component.to_string(), "--component"),
        ] {
            if count > 1 {
                notes.push(format!("has {count} {what}, number {shown} is shown; {flag} N chooses another"));
            }
        }
        notes
    }
}

/// `names` in one line, the rest of a long list left out.
fn listed(names: &[String]) -> String {
    let mut shown = names.iter().take(LISTED).cloned().collect::<Vec<_>>().join(", ");
    if names.len() > LISTED {
        shown += ", …";
    }
    shown
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_of_everything_needs_no_note() {
        assert!(Contents::default().notes().is_empty());
    }

    #[test]
    fn notes_name_the_shown_part_and_its_flag() {
        let contents = Contents {
            arrays: vec!["t".into(), "v".into()],
            array: 1,
            channels: vec!["DAPI".into(), String::new()],
            times: 3,
            time: 2,
            components: 3,
            are_colours: true,
            ..Contents::default()
        };
        assert_eq!(
            contents.notes(),
            [
                "has 2 arrays (t, v), `v` is shown; --array NAME chooses another",
                "has 2 channels, number 0 (DAPI) is shown; --channel N chooses another",
                "has 3 time points, number 2 is shown; --time N chooses another",
                "has 3 components that are colours, number 0 is shown; --component N chooses another",
            ]
        );
    }
}

/// A label of a label map.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Label {
    /// Value of the voxels that have it.
    pub value: i64,
    /// Name.
    pub name: String,
    /// Red, green and blue of sRGB, if the file declares a colour.
    pub colour: Option<[u8; 3]>,
}

/// How a file asks to show one of its channels.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct ChannelDisplay {
    /// Red, green and blue of sRGB.
    pub colour: Option<[u8; 3]>,
    /// The values shown as darkest and brightest, rising.
    pub window: Option<[f64; 2]>,
    /// Whether the channel is shown at first; false only if the file says so.
    pub is_hidden: bool,
}

/// Content of a volume's file, and the part of it that the volume holds.
#[derive(Debug, Clone, PartialEq)]
pub struct Contents {
    /// Names of the arrays; empty where the format does not name any.
    pub arrays: Vec<String>,
    /// Index of the array that the volume holds.
    pub array: usize,
    /// Names of the channels; empty where the format has none.
    pub channels: Vec<String>,
    /// How the file asks to show each channel; empty where it says nothing.
    pub displays: Vec<ChannelDisplay>,
    /// Index of the channel that the volume holds.
    pub channel: usize,
    /// Number of time points, 1 or more.
    pub times: usize,
    /// Index of the time point that the volume holds.
    pub time: usize,
    /// Number of levels of resolution, 1 or more.
    pub levels: usize,
    /// Index of the level that the volume holds; 0 is the finest.
    pub level: usize,
    /// Number of values per voxel, 1 or more.
    pub components: usize,
    /// Index of the component that is shown.
    pub component: usize,
    /// Whether the file declares the components as colours.
    pub are_colours: bool,
    /// Whether the file declares the values as labels.
    pub are_labels: bool,
    /// Names and colours of labels; empty where the file declares none.
    pub labels: Vec<Label>,
}

impl Default for Contents {
    fn default() -> Self {
        Self {
            arrays: Vec::new(),
            array: 0,
            channels: Vec::new(),
            displays: Vec::new(),
            channel: 0,
            times: 1,
            time: 0,
            levels: 1,
            level: 0,
            components: 1,
            component: 0,
            are_colours: false,
            are_labels: false,
            labels: Vec::new(),
        }
    }
}

/// Longest list of names in a note.
const LISTED: usize = 12;

impl Contents {
    /// Name of the shown array, if it has one.
    pub fn array_name(&self) -> Option<&str> {
        self.arrays.get(self.array).map(String::as_str).filter(|name| !name.is_empty())
    }

    /// Notes on files with several arrays, channels, time points, levels or components: what is shown and how to
    /// choose. One line each, to follow the file's name.
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
            (self.levels, "levels of resolution", self.level.to_string(), "--level"),
            (self.components, &format!("components{colours}"), self.component.to_string(), "--component"),
        ] {
            if count > 1 {
                notes.push(format!("has {count} {what}, number {shown} is shown; {flag} N chooses another"));
            }
        }
        notes
    }
}

/// Joins `names` in one line, shortened after [`LISTED`] names.
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
            levels: 2,
            level: 1,
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
                "has 2 levels of resolution, number 1 is shown; --level N chooses another",
                "has 3 components that are colours, number 0 is shown; --component N chooses another",
            ]
        );
    }
}

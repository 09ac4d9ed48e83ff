//! Attributes of frames in enhanced files (PS3.3 C.7.6.16): shared by all, or of one frame.

use super::data_set::DataSet;
use super::plane::{Keys, Plane};
use super::plane_attributes;
use super::tags::{self, Tag};

/// The attributes that all frames share, and those of each.
pub struct Groups<'a> {
    shared: Option<DataSet<'a>>,
    frames: Vec<DataSet<'a>>,
}

impl<'a> Groups<'a> {
    /// The groups of a file; empty if it has none.
    pub fn of(set: &DataSet<'a>) -> Self {
        Self { shared: set.item(tags::SHARED_GROUPS), frames: set.items(tags::FRAME_GROUPS) }
    }

    /// Whether the file has none.
    pub fn is_empty(&self) -> bool {
        self.shared.is_none() && self.frames.is_empty()
    }

    /// The group of `frame` with the name `tag`, else the one that all share.
    fn of_frame(&self, frame: usize, tag: Tag) -> Option<DataSet<'a>> {
        let own = self.frames.get(frame).and_then(|frame| frame.item(tag));
        own.or_else(|| self.shared.as_ref()?.item(tag))
    }

    /// The group that all frames share, or that of the first.
    pub fn shared(&self, tag: Tag) -> Option<DataSet<'a>> {
        self.of_frame(0, tag)
    }
}

/// The picture of `frame`; what no group says, the file `set` says for all.
pub fn plane(set: &DataSet<'_>, groups: &Groups<'_>, frame: usize) -> Plane {
    let base = plane_attributes::plane(set);
    let position = groups.of_frame(frame, tags::PLANE_POSITION);
    let position = position.and_then(|group| group.vector(tags::POSITION));
    let orientation = groups.of_frame(frame, tags::PLANE_ORIENTATION);
    let orientation = orientation.and_then(|group| group.vector(tags::ORIENTATION));
    let content = groups.of_frame(frame, tags::FRAME_CONTENT);
    let measures = groups.of_frame(frame, tags::PIXEL_MEASURES);
    let values = groups.of_frame(frame, tags::VALUE_TRANSFORMATION);
    Plane {
        frame,
        instance: Some(frame as f64),
        place: plane_attributes::place(position, orientation)
            .or(base.place.filter(|_| groups.frames.len() < 2)),
        spacing: measures.map_or(base.spacing, |group| plane_attributes::spacing(&group).0),
        scale: values.map_or(base.scale, |group| plane_attributes::scale(&group)),
        keys: keys(groups, frame, content.as_ref(), base.keys),
        ..base
    }
}

fn keys(groups: &Groups<'_>, frame: usize, content: Option<&DataSet<'_>>, base: Keys) -> Keys {
    let segment = groups.of_frame(frame, tags::SEGMENT_IDENTIFICATION);
    let segment = segment.and_then(|group| group.whole::<u16>(tags::REFERENCED_SEGMENT));
    let number = |group: Tag, tag: Tag| groups.of_frame(frame, group).and_then(|group| group.number(tag));
    let text = |number: Option<f64>| number.map_or(String::new(), |number| number.to_string());
    Keys {
        image_type: frame_type(groups, frame).unwrap_or(base.image_type),
        echo: text(number(tags::MR_ECHO, tags::EFFECTIVE_ECHO_TIME)),
        stack: content.and_then(|content| content.text(tags::STACK_ID)).unwrap_or_default(),
        diffusion: text(number(tags::MR_DIFFUSION, tags::DIFFUSION_B_VALUE)),
        segment: segment.map_or(String::new(), |segment| segment.to_string()),
        temporal: content.and_then(|content| content.number(tags::TEMPORAL_POSITION_INDEX)),
        trigger: number(tags::CARDIAC_TRIGGER, tags::NOMINAL_TRIGGER_DELAY),
        acquisition: content.and_then(|content| content.number(tags::FRAME_ACQUISITION_NUMBER)),
    }
}

/// The kind of a frame, from the group of whichever scanner made it.
fn frame_type(groups: &Groups<'_>, frame: usize) -> Option<String> {
    let groups = [tags::CT_FRAME_TYPE, tags::MR_FRAME_TYPE, tags::PET_FRAME_TYPE]
        .into_iter()
        .filter_map(|tag| groups.of_frame(frame, tag));
    groups.into_iter().find_map(|group| group.text(tags::FRAME_TYPE))
}

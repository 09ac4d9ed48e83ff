//! Open volume with cached data that follows from its session.

use crate::session::document::Document;
use crate::ui::slices::slice_colours::SliceColours;
use crate::ui::transfer::backdrop::Backdrop;
use crate::ui::transfer::transfer_editor::TransferEditor;
use anyhow::Result;
use fovolnet::core::{Camera, CameraPath, FrameSize, GazePath, Keyframe, TransferFunction, path_of_text};
use fovolnet::io::volume::dicom;
use fovolnet::presets::ShownLabel;
use fovolnet::{
    Choice, CropBox, GazeChoice, NamedView, OpenVolume, Orientation, PathChoice, RenderOverrides,
    RenderSettings, Sampling, TransferChoice, VolumeSettings, WorldBox, camera_path, open_volume, presets,
};
use std::path::Path;

/// Open volume, its session and its view.
#[derive(Debug)]
pub struct Opened {
    /// The session.
    pub document: Document,
    /// The volume.
    pub volume: OpenVolume,
    /// Histograms behind the transfer function.
    pub backdrop: Backdrop,
    /// Colours of the slices.
    pub slice_colours: SliceColours,
    /// State of the transfer-function editor.
    pub editor: TransferEditor,
    /// Transfer function, and the setting that it was made from.
    transfer: (Option<TransferChoice>, TransferFunction),
    path: CameraPath,
    /// Settings that the cached path was made from.
    path_words: Option<PathWords>,
    gaze: GazePath,
    /// Settings that the cached gaze was made from.
    gaze_words: Option<(Option<GazeChoice>, Option<u64>)>,
    world: WorldBox,
    /// Names of the series of a DICOM folder, in the order of `--series`.
    series: Vec<String>,
    /// Labels of a label map, in their usual colours.
    labels: Vec<ShownLabel>,
}

/// Settings that determine the path of a session.
#[derive(Debug, Clone, PartialEq)]
struct PathWords {
    path: Option<PathChoice>,
    turn: Option<f64>,
    view: Option<NamedView>,
    orientation: Option<Orientation>,
    clip: Option<CropBox>,
}

impl PathWords {
    fn of(settings: &RenderOverrides) -> Self {
        let RenderOverrides { path, turn, view, orientation, clip, .. } = settings.clone();
        Self { path, turn, view, orientation, clip }
    }
}

/// Frames of paths without an end, and of one turn of the turntable.
const ROUND: u32 = 500;

impl Opened {
    /// Opens `source`, a volume or a session (`.toml`); `read` and `render` override its settings. Also returns notes
    /// for the user.
    ///
    /// # Errors
    /// A file that cannot be read.
    pub fn open(source: &str, read: VolumeSettings, render: RenderOverrides) -> Result<(Self, Vec<String>)> {
        let path: &Path = &path_of_text(source);
        let document = if path.extension().is_some_and(|extension| extension == "toml") {
            Document::open(path, read, render)?
        } else {
            Document::new(source, read, render)?
        };
        Self::of_document(document)
    }

    /// Opens the volume of `document`; also returns notes for the user.
    ///
    /// # Errors
    /// A file that cannot be read.
    pub fn of_document(document: Document) -> Result<(Self, Vec<String>)> {
        let session = document.session();
        let volume = open_volume(&session.volume, &session.read)?;
        let mut notes = Vec::new();
        if !session.volume_is_unchanged()? {
            notes.push(format!(
                "{} has changed since the session was saved: pictures may not be the same",
                session.volume
            ));
        }
        if !session.weights_are_unchanged().unwrap_or(true) {
            notes.push("the weights are not those of the session: pictures will not be the same".into());
        }
        notes.extend(volume.remarks());
        notes.extend(volume.notes());
        let backdrop = Backdrop::new(&volume);
        let slice_colours = SliceColours::new(&volume);
        let transfer = match document.transfer_function(&volume) {
            Ok(transfer) => transfer,
            Err(error) => {
                notes.push(format!("{error}; the automatic transfer function is shown instead"));
                presets::find("auto", &volume)?
            }
        };
        let transfer = (document.settings().tf.clone(), transfer);
        let usual = RenderSettings { frames: ROUND, ..RenderSettings::default() };
        let world = WorldBox::new(&volume.volume, &usual)?;
        let mut opened = Self {
            document,
            volume,
            backdrop,
            slice_colours,
            editor: TransferEditor::default(),
            transfer,
            path: camera_path(&usual, &world)?,
            path_words: None,
            gaze: usual.gaze,
            gaze_words: None,
            world,
            series: Vec::new(),
            labels: Vec::new(),
        };
        opened.series = opened.listed_series();
        opened.labels = presets::labels(&opened.volume.volume);
        if let Err(error) = opened.refresh() {
            notes.push(format!("{error}; the usual turntable is shown instead"));
        }
        Ok((opened, notes))
    }

    /// Updates cached data from the session's current settings.
    ///
    /// # Errors
    /// An invalid transfer function or path; the previous one stays in use.
    pub fn refresh(&mut self) -> Result<()> {
        let settings = self.document.settings();
        if settings.tf != self.transfer.0 {
            let tf = settings.tf.clone();
            let found = self.document.transfer_function(&self.volume);
            // An invalid one is not read again until it changes.
            self.transfer.0 = tf;
            self.transfer.1 = found?;
        }
        let settings = self.document.settings();
        let words = (settings.gaze.clone(), settings.seed);
        if self.gaze_words.as_ref() != Some(&words) {
            let usual = RenderSettings::default();
            let seed = settings.seed.unwrap_or(usual.seed);
            let found = settings.gaze.as_ref().and_then(|gaze| gaze.path(seed).ok());
            // A gaze that cannot be read is the usual one.
            self.gaze = found.unwrap_or(usual.gaze);
            self.gaze_words = Some(words);
        }
        let words = PathWords::of(self.document.settings());
        if self.path_words.as_ref() != Some(&words) {
            self.path_words = Some(words.clone());
            let PathWords { path, turn, view, orientation, clip } = words;
            let (size, frames) = (self.document.settings().size, Some(ROUND));
            let given = RenderOverrides {
                size,
                frames,
                path,
                turn,
                view,
                orientation,
                clip,
                ..RenderOverrides::default()
            };
            let settings = given.resolve()?;
            let world = WorldBox::new(&self.volume.volume, &settings)?;
            (self.path, self.world) = (camera_path(&settings, &world)?, world);
        }
        Ok(())
    }

    /// Names of the series of a DICOM folder, in the order of `--series`; empty for other volumes.
    pub fn series(&self) -> &[String] {
        &self.series
    }

    /// Labels of a label map, in their usual colours; empty for other volumes.
    pub fn labels(&self) -> &[ShownLabel] {
        &self.labels
    }

    /// Labels of a label map as the transfer function shows them.
    pub fn shown_labels(&self) -> Vec<ShownLabel> {
        let [lo, hi] = self.volume.volume.range();
        let shown = |label: &ShownLabel| {
            let [r, g, b, opacity] = self.transfer().evaluate((label.value - lo) / (hi - lo));
            ShownLabel { colour: [r, g, b], opacity, ..label.clone() }
        };
        self.labels.iter().map(shown).collect()
    }

    fn listed_series(&self) -> Vec<String> {
        if !self.volume.volume.format().starts_with("DICOM") {
            return Vec::new();
        }
        let all = dicom::series(&path_of_text(&self.volume.source)).unwrap_or_default();
        let name = |(number, series): (usize, &dicom::Series)| {
            let [x, y, z] = series.dims;
            format!("{number}: {} {} ({x}×{y}×{z})", series.modality, series.description)
        };
        (1..).zip(&all).map(name).collect()
    }

    /// Box of the volume in the world.
    pub fn world(&self) -> &WorldBox {
        &self.world
    }

    /// Current transfer function.
    pub fn transfer(&self) -> &TransferFunction {
        &self.transfer.1
    }

    /// Sets another transfer function.
    pub fn set_transfer(&mut self, transfer: &TransferFunction) {
        let mut transfer = transfer.over(self.volume.volume.range());
        if let (None, Some(nan)) = (transfer.chosen_nan(), self.transfer().chosen_nan()) {
            transfer = transfer.with_nan(nan).expect("it is one already");
        }
        self.document.set_transfer_function(&transfer);
        self.transfer = (self.document.settings().tf.clone(), transfer);
    }

    /// Path of the session, independent of the current camera.
    pub fn path(&self) -> &CameraPath {
        &self.path
    }

    /// Gaze of the session.
    pub fn gaze(&self) -> &GazePath {
        &self.gaze
    }

    /// Frame number on the path.
    pub fn frame(&self) -> u32 {
        self.document.settings().first_frame.unwrap_or(0)
    }

    /// Shows frame `frame` of the path.
    pub fn go_to(&mut self, frame: u32) {
        let settings = self.document.settings_mut();
        settings.camera = None;
        settings.first_frame = (frame > 0).then_some(frame);
    }

    /// Number of frames of the path.
    pub fn path_length(&self) -> u32 {
        match self.path() {
            CameraPath::Keyframes(keys) => keys.last().map_or(1, |key| key.frame.ceil() as u32 + 1),
            _ => ROUND,
        }
    }

    /// Current camera.
    pub fn camera(&self) -> Camera {
        let free = self.document.settings().camera;
        let free = free.map(|camera| camera.camera()).filter(|camera| camera.check().is_ok());
        let camera = free.unwrap_or_else(|| self.path().camera(self.frame()));
        let projection = self.document.settings().projection.unwrap_or_default();
        Camera { projection, ..camera }
    }

    /// Sets a free camera.
    pub fn stand_at(&mut self, camera: &Camera) {
        self.document.settings_mut().camera = Some(camera.into());
    }

    /// Keyframes of the path; empty if it has none.
    pub fn keyframes(&self) -> &[Keyframe] {
        match self.path() {
            CameraPath::Keyframes(keys) => keys,
            _ => &[],
        }
    }

    /// Sets the path through `keyframes`, in any order; without keyframes, the default turntable.
    pub fn set_keyframes(&mut self, mut keyframes: Vec<Keyframe>) {
        keyframes.sort_by(|a, b| a.frame.total_cmp(&b.frame));
        keyframes.dedup_by(|later, earlier| later.frame == earlier.frame);
        self.document.settings_mut().path = (!keyframes.is_empty()).then(|| PathChoice::through(&keyframes));
        // Keyframes were valid in a path or as the current camera, so this cannot fail.
        let _ = self.refresh();
    }

    /// Adds the current view as a keyframe at `frame`; replaces one that is there.
    pub fn add_keyframe(&mut self, frame: u32) {
        let (frame, camera) = (f64::from(frame), self.camera());
        let others = self.keyframes().iter().copied().filter(|key| key.frame != frame);
        let keys = others.chain([Keyframe { frame, camera }]).collect();
        self.set_keyframes(keys);
        self.go_to(frame as u32);
    }

    /// Settings for the renderer at `size` on the screen.
    pub fn screen_settings(&self, size: FrameSize) -> RenderOverrides {
        let settings = self.document.settings();
        RenderOverrides {
            size: Some(size),
            tf: Some(self.transfer().clone().into()),
            // The function already covers the displayed range.
            tf_range: None,
            scale: None,
            // Frames in motion are sparse unless the session says otherwise.
            sampling: settings
                .sampling
                .and_then(Choice::fixed)
                .or(Some(Sampling::Compact))
                .map(Choice::Fixed),
            frames: None,
            first_frame: None,
            path: None,
            camera: None,
            gaze: None,
            transparent: None,
            ..settings.clone()
        }
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// Small open volume.
    pub(crate) fn opened() -> Opened {
        let read = VolumeSettings { dims: Some([16; 3]), ..VolumeSettings::default() };
        Opened::open("head", read, RenderOverrides::default()).unwrap().0
    }

    #[test]
    fn the_planner_may_decide_what_nobody_gave() {
        assert_eq!(opened().document.settings().freedom(), fovolnet::Freedom::ALL);
    }

    #[test]
    fn keyframes_make_a_path_through_the_views() {
        let mut opened = opened();
        let first = opened.camera();
        opened.add_keyframe(0);
        let second = Camera::on_sphere(90.0, 0.0, 2.0, 35.0);
        opened.stand_at(&second);
        assert_eq!(opened.camera(), second);
        opened.add_keyframe(40);
        assert_eq!(opened.path_length(), 41);
        assert_eq!((opened.frame(), opened.camera()), (40, second));
        opened.go_to(0);
        assert_eq!(opened.camera(), first);
        opened.go_to(20);
        assert_ne!(opened.camera(), first);
        opened.set_keyframes(Vec::new());
        assert!(matches!(opened.path(), CameraPath::Turntable { .. }));
    }

    #[test]
    fn transfer_functions_that_cannot_be_read_leave_the_last() {
        let mut opened = opened();
        let before = opened.transfer().clone();
        opened.document.settings_mut().tf = Some("no-such".into());
        assert!(opened.refresh().is_err());
        assert!(opened.refresh().is_ok(), "it is said once");
        assert_eq!(opened.transfer(), &before);
        opened.document.settings_mut().tf = Some("magma".into());
        opened.refresh().unwrap();
        assert_ne!(opened.transfer(), &before);
    }

    #[test]
    fn sessions_open_with_what_is_wrong_said() {
        let folder = tempfile::tempdir().unwrap();
        let session = folder.path().join("s.toml");
        let text = "volume = \"head\"\n[read]\ndims = [16, 16, 16]\n[render]\ntf = \"nothing\"\npath = \"gone.toml\"\n";
        std::fs::write(&session, text).unwrap();
        let source = session.to_str().unwrap();
        let (opened, notes) =
            Opened::open(source, VolumeSettings::default(), RenderOverrides::default()).unwrap();
        assert_eq!(notes.len(), 2, "{notes:?}");
        assert!(matches!(opened.path(), CameraPath::Turntable { .. }));
    }
}

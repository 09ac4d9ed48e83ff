//! Every field of a session is written and read back, and has an effect.

use fovolnet::core::{
    Dtype, Endian, Frame, Integration, Interpolation, Projection, ShadowMode, SurfaceShading,
};
use fovolnet::{
    ComponentChoice, CropBox, Density, Device, Guide, Mode, NamedView, NanColour, Orientation, Pipeline,
    PlannedFrames, PlannedPipeline, Quality, Reconstruction, RenderOverrides, Sampling, Session,
    SpeedSettings, TransferRange, ValueScale, VolumeSettings, Way, open_volume,
};
use std::collections::BTreeSet;
use std::path::Path;

/// Effect of a field.
#[derive(Debug, PartialEq)]
enum Shows {
    InThePictures,
    /// Warning: a saved hash no longer fits.
    AsAWarning,
    /// Change in the file alone, since the machine decides how to compute.
    InTheFile,
}

/// Change of one field, from one value to another.
struct Step {
    field: &'static str,
    shows: Shows,
    from: fn(&mut Session),
    to: fn(&mut Session),
}

/// Session of bare voxels at `volume` with every field set. It uses no `..`, so a new field fails to compile here.
fn everything(volume: &Path) -> Session {
    let read = VolumeSettings {
        dims: Some([16; 3]),
        dtype: Some(Dtype::U16),
        endian: Some(Endian::Little),
        spacing: Some([1.0; 3]),
        range: Some([0.0, 65535.0]),
        window: None,
        array: None,
        component: Some(ComponentChoice::Number(0)),
        channel: Some(0.into()),
        overlay: None,
        time: Some(0.into()),
        level: Some(0),
        series: None,
        downsample: Some(1),
    };
    let render = RenderOverrides {
        size: Some("48x36".parse().unwrap()),
        frames: Some(2),
        first_frame: Some(0),
        path: Some("orbit".into()),
        turn: Some(360.0),
        view: Some(NamedView::Anterior),
        orientation: Some(Orientation::Grid),
        camera: None,
        projection: Some(Projection::Perspective),
        mode: Some(Mode::Composite),
        iso: None,
        tf: Some("auto".into()),
        tf_range: Some(TransferRange::Stretch),
        scale: Some(ValueScale::Linear),
        nan: Some(NanColour::Transparent),
        clip: Some(CropBox::WHOLE),
        clip_plane: Some(vec![[0.0, 0.0, 1.0, -2.0]]),
        light: Some([0.5, 1.0, 0.3]),
        shadows: Some(ShadowMode::On),
        shading: Some(SurfaceShading::Flat),
        ambient: Some(0.3),
        background: Some([0.0; 3]),
        transparent: Some(false),
        step: Some(0.5),
        interpolation: Some(Interpolation::Linear.into()),
        integration: Some(Integration::Fine),
        sampling: Some(Sampling::Compact.into()),
        pb: Some(0.2),
        sigma: Some(0.05),
        gaze: Some("0.5,0.5".into()),
        density: Some(Density::Adaptive.into()),
        shadow_rays: Some("16".parse().unwrap()),
        noise: Some("stbn".parse().unwrap()),
        seed: Some(0),
        reconstruct: Some(Reconstruction::WNet),
        guide: Some(Guide::Quarter.into()),
        weights: Some("wnet-fast".into()),
        random_weights: None,
        precision: Some("f32".parse().unwrap()),
        quality: Some(Quality::Fixed),
        budget: None,
    };
    let session = Session::new(volume.to_str().unwrap(), read, render).unwrap();
    let session = Session { plan: vec![planned(1.0)], ..session };
    let Session {
        volume: _,
        volume_sha256: _,
        overlay_sha256: _,
        weights_sha256: _,
        read: _,
        render: _,
        plan: _,
    } = &session;
    session
}

/// Plan of all frames, at `scale`.
fn planned(scale: f64) -> PlannedFrames {
    PlannedFrames { first_frame: 0, frames: 9, way: Way::LightRatio, scale, step: 1.0, density: 1.0 }
}

fn nothing(_: &mut Session) {}

/// Makes `session` show the file `name` beside its volume, read as that file says.
fn another_file(session: &mut Session, name: &str) {
    session.volume = session.volume.replace("ball.raw", name);
    session.volume_sha256 = None;
    session.read = VolumeSettings { downsample: Some(1), ..VolumeSettings::default() };
    session.render.clip = None;
}

fn steps() -> Vec<Step> {
    let step = |field, to| Step { field, shows: Shows::InThePictures, from: nothing, to };
    vec![
        step("volume", |s| (s.volume, s.volume_sha256) = ("head".into(), None)),
        Step {
            shows: Shows::AsAWarning,
            ..step("volume-sha256", |s| s.volume_sha256 = Some("0".repeat(64)))
        },
        Step {
            shows: Shows::AsAWarning,
            from: |s| s.read.overlay = Some(vec!["head".parse().unwrap()]),
            ..step("overlay-sha256", |s| s.overlay_sha256 = vec!["0".repeat(64)])
        },
        Step {
            shows: Shows::AsAWarning,
            ..step("weights-sha256", |s| s.weights_sha256 = Some("0".repeat(64)))
        },
        step("read.overlay", |s| s.read.overlay = Some(vec!["marschner-lobb@viridis".parse().unwrap()])),
        step("read.dims", |s| s.read.dims = Some([32, 16, 8])),
        step("read.dtype", |s| s.read.dtype = Some(Dtype::I16)),
        step("read.endian", |s| s.read.endian = Some(Endian::Big)),
        step("read.spacing", |s| s.read.spacing = Some([1.0, 1.0, 2.0])),
        step("read.range", |s| s.read.range = Some([0.0, 40000.0])),
        Step {
            from: |s| s.read.range = None,
            ..step("read.window", |s| s.read.window = Some([20000.0, 30000.0]))
        },
        Step {
            from: |s| {
                another_file(s, "arrays.vtk");
                s.read.array = Some("a".into());
            },
            ..step("read.array", |s| s.read.array = Some("b".into()))
        },
        Step {
            from: |s| another_file(s, "components.mha"),
            ..step("read.component", |s| s.read.component = Some(ComponentChoice::Number(1)))
        },
        Step {
            from: |s| another_file(s, "channels.tif"),
            ..step("read.channel", |s| s.read.channel = Some(1.into()))
        },
        Step {
            from: |s| another_file(s, "channels.tif"),
            ..step("read.time", |s| s.read.time = Some(1.into()))
        },
        Step { from: |s| another_file(s, "levels.zarr"), ..step("read.level", |s| s.read.level = Some(1)) },
        Step {
            from: |s| another_file(s, "scans"),
            ..step("read.series", |s| s.read.series = Some("2".into()))
        },
        step("read.downsample", |s| s.read.downsample = Some(2)),
        step("render.size", |s| s.render.size = Some("40x50".parse().unwrap())),
        step("render.frames", |s| s.render.frames = Some(3)),
        step("render.first-frame", |s| s.render.first_frame = Some(7)),
        step("render.path", |s| s.render.path = Some("flythrough".into())),
        Step {
            from: |s| s.render.path = Some("turntable".into()),
            ..step("render.turn", |s| s.render.turn = Some(90.0))
        },
        Step {
            from: |s| s.render.path = Some("turntable".into()),
            ..step("render.view", |s| s.render.view = Some(NamedView::Left))
        },
        Step {
            from: |s| {
                let read = s.read.clone();
                another_file(s, "turned.mha");
                s.read = read;
            },
            ..step("render.orientation", |s| s.render.orientation = Some(Orientation::Patient))
        },
        Step {
            from: |s| s.render.path = None,
            ..step("render.camera", |s| s.render.camera = Some([0.0, 1.0, 2.0, 0.0, 0.0, 0.0, 30.0].into()))
        },
        step("render.projection", |s| s.render.projection = Some(Projection::Orthographic)),
        step("render.mode", |s| s.render.mode = Some(Mode::Mip)),
        Step {
            from: |s| s.render.mode = Some(Mode::Isosurface),
            ..step("render.iso", |s| s.render.iso = Some(50000.0))
        },
        step("render.tf", |s| s.render.tf = Some("viridis".into())),
        Step {
            from: |s| {
                let text = r#"{"range":[20000,60000],"points":[[0,1,0,0,0],[1,0,1,0,0.5]]}"#;
                s.render.tf = Some(text.into());
            },
            ..step("render.tf-range", |s| s.render.tf_range = Some(TransferRange::Data))
        },
        step("render.scale", |s| s.render.scale = Some(ValueScale::Log)),
        Step {
            from: |s| another_file(s, "gaps.mha"),
            ..step("render.nan", |s| s.render.nan = Some(NanColour::Colour([1.0, 0.0, 0.0, 0.5])))
        },
        step("render.clip", |s| s.render.clip = Some([0.0, 0.6, 0.1, 1.0, 0.0, 1.0].into())),
        step("render.clip-plane", |s| s.render.clip_plane = Some(vec![[1.0, 0.5, 0.2, 0.05]])),
        step("render.light", |s| s.render.light = Some([-1.0, 0.2, 0.1])),
        step("render.shadows", |s| s.render.shadows = Some(ShadowMode::Off)),
        step("render.shading", |s| s.render.shading = Some(SurfaceShading::Gradient)),
        step("render.ambient", |s| s.render.ambient = Some(0.6)),
        step("render.background", |s| s.render.background = Some([0.1, 0.2, 0.3])),
        Step {
            from: |s| s.render.sampling = Some(Sampling::Full.into()),
            ..step("render.transparent", |s| s.render.transparent = Some(true))
        },
        step("render.step", |s| s.render.step = Some(0.8)),
        step("render.interpolation", |s| s.render.interpolation = Some(Interpolation::Nearest.into())),
        step("render.integration", |s| s.render.integration = Some(Integration::Plain)),
        step("render.sampling", |s| s.render.sampling = Some(Sampling::Full.into())),
        step("render.pb", |s| s.render.pb = Some(0.4)),
        step("render.sigma", |s| s.render.sigma = Some(0.2)),
        step("render.gaze", |s| s.render.gaze = Some("0.3,0.4".into())),
        step("render.noise", |s| s.render.noise = Some("uniform".parse().unwrap())),
        // Blue noise follows the seed; the built-in noise does not.
        Step {
            from: |s| s.render.noise = Some("blue".parse().unwrap()),
            ..step("render.seed", |s| s.render.seed = Some(3))
        },
        step("render.reconstruct", |s| {
            (s.render.reconstruct, s.render.weights) = (Some("linear".parse().unwrap()), None);
        }),
        step("render.shadow-rays", |s| s.render.shadow_rays = Some("8".parse().unwrap())),
        step("render.density", |s| s.render.density = Some(Density::Fixed.into())),
        step("render.guide", |s| s.render.guide = Some(Guide::None.into())),
        step("render.weights", |s| (s.render.weights, s.weights_sha256) = (Some("wnet-paper".into()), None)),
        Step {
            from: |s| s.render.weights = None,
            ..step("render.random-weights", |s| {
                s.render.random_weights = Some("wnet-fast:3".parse().unwrap());
            })
        },
        Step {
            shows: Shows::InTheFile,
            ..step("render.precision", |s| s.render.precision = Some("int8".parse().unwrap()))
        },
        Step {
            from: |s| s.plan.clear(),
            shows: Shows::InTheFile,
            ..step("render.quality", |s| s.render.quality = Some(Quality::Auto))
        },
        Step {
            from: |s| (s.render.quality, s.render.budget) = (None, Some(1e6)),
            shows: Shows::InTheFile,
            ..step("render.budget", |s| s.render.budget = Some(2e6))
        },
        Step {
            from: |s| (s.render.quality, s.render.budget) = (None, Some(1e6)),
            ..step("plan", |s| s.plan = vec![planned(0.5)])
        },
    ]
}

/// Names of all fields that `session` sets, tables before their fields.
fn fields(session: &Session) -> BTreeSet<String> {
    let table = toml::Table::try_from(session).unwrap();
    let names = |(key, value): (&String, &toml::Value)| match value {
        toml::Value::Table(inner) => inner.keys().map(|field| format!("{key}.{field}")).collect(),
        _ => vec![key.clone()],
    };
    table.iter().flat_map(names).collect()
}

/// Session and picture after opening a session again.
#[derive(PartialEq)]
struct Opened {
    session: Session,
    frames: Vec<Frame>,
    unchanged: [bool; 2],
}

/// Writes `session` to `path` and opens it from there.
fn opened(session: &Session, path: &Path) -> Opened {
    let text = toml::to_string(session).unwrap();
    std::fs::write(path, text).unwrap();
    let session = Session::read(path).unwrap();
    let volume = open_volume(&session.volume, &session.read).unwrap();
    let speed = SpeedSettings { device: Some(Device::Cpu), ..Default::default() };
    let settings = session.render.resolve().unwrap();
    let numbers = settings.frame_numbers();
    let frames = match session.render.limit().unwrap() {
        None => {
            let mut pipeline = Pipeline::new(&volume, &settings, &speed).unwrap();
            numbers.map(|t| pipeline.render(t).unwrap().frame).collect()
        }
        Some(limit) => {
            let asked = (&settings, session.render.freedom());
            let mut pipeline = PlannedPipeline::new(&volume, asked, limit, &speed).unwrap();
            pipeline.follow(&session.plan).unwrap();
            numbers.map(|t| pipeline.render(t).unwrap().0.frame).collect()
        }
    };
    let unchanged = [session.volume_is_unchanged().unwrap(), session.weights_are_unchanged().unwrap()];
    Opened { session, frames, unchanged }
}

/// Bare voxels of a slightly distorted ball.
fn voxels() -> Vec<u8> {
    let value = |i: usize| {
        let p = [i % 16, i / 16 % 16, i / 256].map(|c| c as f32 - 7.5);
        let away = (p[0] * p[0] + 1.5 * p[1] * p[1] + 0.7 * p[2] * p[2]).sqrt();
        (65535.0 * (1.0 - away / 9.0).clamp(0.0, 1.0)) as u16
    };
    (0..4096).flat_map(|i| value(i).to_le_bytes()).collect()
}

/// Writes an OME-Zarr volume of two levels to `folder`: 8 by 8 by 8 voxels, and 4 by 4 by 4.
fn write_levels(folder: &Path) {
    let axes = r#"[{"name":"z","type":"space"},{"name":"y","type":"space"},{"name":"x","type":"space"}]"#;
    let level = |path: usize| {
        let scale = 1 << path;
        format!(
            r#"{{"path":"{path}","coordinateTransformations":[{{"type":"scale","scale":[{scale},{scale},{scale}]}}]}}"#
        )
    };
    let multiscales =
        format!(r#"[{{"version":"0.4","axes":{axes},"datasets":[{},{}]}}]"#, level(0), level(1));
    std::fs::create_dir(folder).unwrap();
    std::fs::write(folder.join(".zgroup"), r#"{"zarr_format":2}"#).unwrap();
    std::fs::write(folder.join(".zattrs"), format!(r#"{{"multiscales":{multiscales}}}"#)).unwrap();
    for (path, side) in [(0, 8), (1, 4)] {
        let array = folder.join(path.to_string());
        std::fs::create_dir(&array).unwrap();
        let described = format!(
            r#"{{"zarr_format":2,"shape":[{side},{side},{side}],"chunks":[{side},{side},{side}],"dtype":"|u1",
            "compressor":null,"fill_value":0,"order":"C","filters":null}}"#
        );
        std::fs::write(array.join(".zarray"), described).unwrap();
        let values: Vec<u8> = (0..side * side * side).map(|i| (i * (7 + path) % 251) as u8).collect();
        std::fs::write(array.join("0.0.0"), values).unwrap();
    }
}

/// Writes files with several arrays, components, channels and time points, and one with NaN, to `folder`.
fn write_parts(folder: &Path) {
    let plane = |seed: usize| (0..64).map(move |i| ((i * (seed + 3)) % 251) as u8);
    let bytes = |count: usize| (0..count).flat_map(plane).collect::<Vec<u8>>();
    let mha = b"NDims = 3\nDimSize = 4 4 4\nElementType = MET_UCHAR\nElementNumberOfChannels = 2\nElementDataFile = LOCAL\n";
    std::fs::write(folder.join("components.mha"), [&mha[..], &bytes(2)].concat()).unwrap();
    let value = |i: usize| if i.is_multiple_of(5) { f32::NAN } else { i as f32 };
    let floats: Vec<u8> = (0..64).flat_map(|i| value(i).to_le_bytes()).collect();
    let mha = b"NDims = 3\nDimSize = 4 4 4\nElementType = MET_FLOAT\nElementDataFile = LOCAL\n";
    std::fs::write(folder.join("gaps.mha"), [&mha[..], &floats].concat()).unwrap();
    let vtk = |name: &str, seed: usize| {
        let values: Vec<String> = plane(seed).map(|value| value.to_string()).collect();
        format!("SCALARS {name} unsigned_char 1\nLOOKUP_TABLE default\n{}\n", values.join(" "))
    };
    let head = "# vtk DataFile Version 3.0\nx\nASCII\nDATASET STRUCTURED_POINTS\nDIMENSIONS 4 4 4\nORIGIN 0 0 0\nSPACING 1 1 1\nPOINT_DATA 64\n";
    std::fs::write(folder.join("arrays.vtk"), [head, &vtk("a", 1), &vtk("b", 2)].concat()).unwrap();
    // ImageJ stack: two slices, channels and time points of 8x8 pixels behind a single page.
    let description = "ImageJ=1.53q\nimages=8\nchannels=2\nslices=2\nframes=2\nhyperstack=true\0";
    let data = 8 + 2 + 8 * 12 + 4;
    let text = data + 8 * 64;
    let entry = |tag: u16, kind: u16, count: usize, value: usize| {
        let count = u32::try_from(count).unwrap().to_le_bytes();
        let value = u32::try_from(value).unwrap().to_le_bytes();
        [&tag.to_le_bytes()[..], &kind.to_le_bytes(), &count, &value].concat()
    };
    let entries = [
        entry(256, 4, 1, 8),
        entry(257, 4, 1, 8),
        entry(258, 3, 1, 8),
        entry(262, 3, 1, 1),
        entry(270, 2, description.len(), text),
        entry(273, 4, 1, data),
        entry(278, 4, 1, 8),
        entry(279, 4, 1, 64),
    ];
    let tiff = [b"II*\0\x08\0\0\0\x08\0", &entries.concat()[..], &[0; 4], &bytes(8), description.as_bytes()];
    std::fs::write(folder.join("channels.tif"), tiff.concat()).unwrap();
    write_levels(&folder.join("levels.zarr"));
    // DICOM of several series.
    let scans = Path::new(env!("CARGO_MANIFEST_DIR")).join("../fovol-io/tests/dicom_files/several");
    std::fs::create_dir(folder.join("scans")).unwrap();
    for (number, series) in std::fs::read_dir(scans).unwrap().enumerate() {
        for file in std::fs::read_dir(series.unwrap().path()).unwrap() {
            let (file, to) = (file.unwrap(), folder.join("scans"));
            std::fs::copy(file.path(), to.join(format!("{number}_{}", file.file_name().display()))).unwrap();
        }
    }
}

#[test]
fn every_field_of_a_session_is_kept_and_shows() {
    let folder = tempfile::tempdir().unwrap();
    let (volume, path) = (folder.path().join("ball.raw"), folder.path().join("session.toml"));
    std::fs::write(&volume, voxels()).unwrap();
    let turned =
        b"NDims = 3\nDimSize = 16 16 16\nElementType = MET_USHORT\nTransformMatrix = 0 1 0 0 0 1 1 0 0\n\
        ElementDataFile = LOCAL\n";
    std::fs::write(folder.path().join("turned.mha"), [&turned[..], &voxels()].concat()).unwrap();
    write_parts(folder.path());
    let whole = everything(&volume).sealed();
    let mut known = fields(&whole);
    let mut either = whole.clone();
    either.read.array = Some("a".into());
    either.read.overlay = Some(vec!["head".parse().unwrap()]);
    either.overlay_sha256 = vec![String::new()];
    either.read.series = Some("1".into());
    either.read.window = Some([1.0; 2]);
    either.render.iso = Some(1.0);
    either.render.budget = Some(40.0);
    either.render.camera = Some([0.0; 7].into());
    either.render.random_weights = Some("wnet-fast".parse().unwrap());
    known.extend(fields(&either));
    let steps = steps();
    assert_eq!(steps.iter().map(|step| step.field.to_owned()).collect::<BTreeSet<_>>(), known);

    for Step { field, shows, from, to } in steps {
        let mut session = whole.clone();
        from(&mut session);
        let before = opened(&session, &path);
        assert!(before.session == session && before.unchanged == [true; 2], "{field}");
        to(&mut session);
        let after = opened(&session, &path);
        assert!(after.session == session && after.session != before.session, "{field} is not kept");
        let found = match () {
            () if after.unchanged != before.unchanged => Shows::AsAWarning,
            () if after.frames != before.frames => Shows::InThePictures,
            () => Shows::InTheFile,
        };
        let as_expected = found == shows || shows == Shows::InTheFile && found == Shows::InThePictures;
        assert!(as_expected, "{field}: {found:?} instead of {shows:?}");
    }
}

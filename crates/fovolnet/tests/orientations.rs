//! One scan with a letter on the patient's left, in every orientation that a file can have and in five formats. The
//! picture must always be the same, and never mirrored.

use fovolnet::core::Frame;
use fovolnet::{Device, Orientation, Pipeline, RenderSettings, SpeedSettings, VolumeSettings, open_volume};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// Voxels along left, posterior and superior.
const SIZES: [usize; 3] = [16, 10, 14];
/// Distances between these voxels.
const SPACING: [f64; 3] = [1.0, 1.5, 1.25];

/// Value of the scan at a position along left, posterior and superior: an F on the front of the left half. It is
/// upright and reads correctly for somebody who faces the patient.
fn scan([left, posterior, superior]: [usize; 3]) -> u8 {
    const F: [&[u8; 5]; 7] = [b"#####", b"#....", b"#....", b"####.", b"#....", b"#....", b"#...."];
    let (column, row) = (left.wrapping_sub(9), 10usize.wrapping_sub(superior));
    let is_letter = row < 7 && column < 5 && F[row][column] == b'#' && posterior < 4;
    if is_letter { 250 } else { 20 }
}

/// Axes of a grid: the patient axis that each voxel axis follows, and whether backwards.
#[derive(Debug, Clone, Copy)]
struct Axes {
    along: [usize; 3],
    backwards: [bool; 3],
    /// Whether the scan is turned in the patient, about all three axes.
    is_oblique: bool,
}

impl Axes {
    /// All 48 orientations.
    fn all() -> Vec<Self> {
        let orders = [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]];
        let signs = (0..8).map(|bits| [0, 1, 2].map(|axis| bits >> axis & 1 == 1));
        signs.flat_map(|backwards| orders.map(|along| Self { along, backwards, is_oblique: false })).collect()
    }

    fn sizes(self) -> [usize; 3] {
        self.along.map(|axis| SIZES[axis])
    }

    fn spacing(self) -> [f64; 3] {
        self.along.map(|axis| SPACING[axis])
    }

    /// Unit vector of voxel axis `axis` in LPS.
    fn direction(self, axis: usize) -> [f64; 3] {
        let mut direction = [0.0; 3];
        direction[self.along[axis]] = if self.backwards[axis] { -1.0 } else { 1.0 };
        self.turned(direction)
    }

    /// A vector of the scan in LPS.
    fn turned(self, vector: [f64; 3]) -> [f64; 3] {
        // Columns are of length 121 and at right angles.
        const ROTATION: [[f64; 3]; 3] = [[87.0, -4.0, 84.0], [36.0, 111.0, -32.0], [-76.0, 48.0, 81.0]];
        let [x, y, z] = vector;
        let is_oblique = self.is_oblique;
        if is_oblique { ROTATION.map(|[a, b, c]| (a * x + b * y + c * z) / 121.0) } else { vector }
    }

    /// Centre of the first voxel in LPS. The origin is the first position of the scan.
    fn origin(self) -> [f64; 3] {
        let mut origin = [0.0; 3];
        for axis in (0..3).filter(|&axis| self.backwards[axis]) {
            let patient = self.along[axis];
            origin[patient] = (SIZES[patient] - 1) as f64 * SPACING[patient];
        }
        self.turned(origin)
    }

    /// Voxels of the grid, x fastest.
    fn voxels(self) -> Vec<u8> {
        let [nx, ny, nz] = self.sizes();
        let value = |i: usize| {
            let voxel = [i % nx, i / nx % ny, i / nx / ny];
            let mut place = [0; 3];
            for axis in 0..3 {
                let last = self.sizes()[axis] - 1;
                place[self.along[axis]] = if self.backwards[axis] { last - voxel[axis] } else { voxel[axis] };
            }
            scan(place)
        };
        (0..nx * ny * nz).map(value).collect()
    }
}

fn text(numbers: impl IntoIterator<Item = f64>, separator: &str) -> String {
    numbers.into_iter().map(|number| number.to_string()).collect::<Vec<_>>().join(separator)
}

fn nrrd(axes: Axes) -> Vec<u8> {
    let step = |axis: usize| {
        let step = axes.direction(axis).map(|c| c * axes.spacing()[axis]);
        format!("({})", text(step, ","))
    };
    let [nx, ny, nz] = axes.sizes();
    let header = format!(
        "NRRD0004\ntype: uint8\ndimension: 3\nspace: left-posterior-superior\nsizes: {nx} {ny} {nz}\n\
         space directions: {} {} {}\nspace origin: ({})\nencoding: raw\n\n",
        step(0),
        step(1),
        step(2),
        text(axes.origin(), ",")
    );
    [header.into_bytes(), axes.voxels()].concat()
}

fn metaimage(axes: Axes) -> Vec<u8> {
    let [nx, ny, nz] = axes.sizes();
    let matrix = (0..3).flat_map(|axis| axes.direction(axis));
    let header = format!(
        "ObjectType = Image\nNDims = 3\nBinaryData = True\nTransformMatrix = {}\nOffset = {}\n\
         ElementSpacing = {}\nDimSize = {nx} {ny} {nz}\nElementType = MET_UCHAR\nElementDataFile = LOCAL\n",
        text(matrix, " "),
        text(axes.origin(), " "),
        text(axes.spacing(), " ")
    );
    [header.into_bytes(), axes.voxels()].concat()
}

fn vti(axes: Axes) -> Vec<u8> {
    let extent = axes.sizes().map(|size| format!("0 {}", size - 1)).join(" ");
    // The columns of the matrix are the directions.
    let matrix = (0..9).map(|i| axes.direction(i % 3)[i / 3]);
    let mut values = String::new();
    for voxel in axes.voxels() {
        write!(values, "{voxel} ").unwrap();
    }
    format!(
        r#"<VTKFile type="ImageData" version="1.0"><ImageData WholeExtent="{extent}" Origin="{}" Spacing="{}"
        Direction="{}"><Piece Extent="{extent}"><PointData Scalars="a"><DataArray type="UInt8" Name="a"
        format="ascii">{values}</DataArray></PointData></Piece></ImageData></VTKFile>"#,
        text(axes.origin(), " "),
        text(axes.spacing(), " "),
        text(matrix, " ")
    )
    .into_bytes()
}

/// NIfTI-1 file with an sform, whose coordinates are RAS.
fn nifti(axes: Axes) -> Vec<u8> {
    let mut bytes = vec![0u8; 352];
    let mut put = |at: usize, field: &[u8]| bytes[at..at + field.len()].copy_from_slice(field);
    put(0, &348i32.to_le_bytes());
    for (i, size) in
        [3, axes.sizes()[0], axes.sizes()[1], axes.sizes()[2], 1, 1, 1, 1].into_iter().enumerate()
    {
        put(40 + 2 * i, &(size as i16).to_le_bytes());
    }
    put(70, &2i16.to_le_bytes());
    put(72, &8i16.to_le_bytes());
    put(76, &1f32.to_le_bytes());
    for (axis, spacing) in axes.spacing().into_iter().enumerate() {
        put(80 + 4 * axis, &(spacing as f32).to_le_bytes());
    }
    put(108, &352f32.to_le_bytes());
    put(254, &1i16.to_le_bytes());
    for row in 0..3 {
        let sign = if row < 2 { -1.0 } else { 1.0 };
        for axis in 0..3 {
            let entry = sign * axes.direction(axis)[row] * axes.spacing()[axis];
            put(280 + 16 * row + 4 * axis, &(entry as f32).to_le_bytes());
        }
        put(292 + 16 * row, &((sign * axes.origin()[row]) as f32).to_le_bytes());
    }
    put(344, b"n+1\0");
    [bytes, axes.voxels()].concat()
}

/// One slice of a DICOM series: the images along the third axis of the grid.
fn dicom(axes: Axes, slice: usize) -> Vec<u8> {
    let element = |group: u16, number: u16, vr: &[u8; 2], value: &[u8]| {
        let mut value = value.to_vec();
        if value.len() % 2 == 1 {
            value.push(if vr == b"UI" { 0 } else { b' ' });
        }
        let length = if vr == b"OW" {
            [&[0, 0][..], &(value.len() as u32).to_le_bytes()].concat()
        } else {
            (value.len() as u16).to_le_bytes().to_vec()
        };
        [&group.to_le_bytes()[..], &number.to_le_bytes(), vr, &length, &value].concat()
    };
    let word = |number, value: u16| element(0x28, number, b"US", &value.to_le_bytes());
    let words = |number, vr, text: &str| element(0x20, number, vr, text.as_bytes());
    let [nx, ny, _] = axes.sizes();
    let [dx, dy, dz] = axes.spacing();
    let (origin, along) = (axes.origin(), axes.direction(2));
    let position = [0, 1, 2].map(|a| origin[a] + slice as f64 * dz * along[a]);
    let rows = axes.direction(0).into_iter().chain(axes.direction(1));
    let meta = element(2, 0x10, b"UI", b"1.2.840.10008.1.2.1");
    let length = element(2, 0, b"UL", &(meta.len() as u32).to_le_bytes());
    [
        [0; 128].to_vec(),
        b"DICM".to_vec(),
        length,
        meta,
        element(8, 0x16, b"UI", b"1.2.840.10008.5.1.4.1.1.2"),
        element(8, 0x18, b"UI", format!("1.2.3.{slice}").as_bytes()),
        element(8, 0x60, b"CS", b"CT"),
        words(0x0D, b"UI", "1.2.3"),
        words(0x0E, b"UI", "1.2.3.4"),
        words(0x13, b"IS", &slice.to_string()),
        words(0x32, b"DS", &text(position, "\\")),
        words(0x37, b"DS", &text(rows, "\\")),
        word(0x02, 1),
        element(0x28, 0x04, b"CS", b"MONOCHROME2"),
        word(0x10, ny as u16),
        word(0x11, nx as u16),
        element(0x28, 0x30, b"DS", text([dy, dx], "\\").as_bytes()),
        word(0x100, 8),
        word(0x101, 8),
        word(0x102, 7),
        word(0x103, 0),
        element(0x7FE0, 0x10, b"OW", &axes.voxels()[slice * nx * ny..(slice + 1) * nx * ny]),
    ]
    .concat()
}

/// Writes the scan with `axes` in each format; returns names and paths.
fn written(folder: &Path, axes: Axes) -> Vec<(&'static str, PathBuf)> {
    let formats: [(&str, Writer); 4] = [("nrrd", nrrd), ("mha", metaimage), ("vti", vti), ("nii", nifti)];
    let mut all = Vec::new();
    for (ending, bytes) in formats {
        let path = folder.join(format!("scan.{ending}"));
        std::fs::write(&path, bytes(axes)).unwrap();
        all.push((ending, path));
    }
    let slices = folder.join("dicom");
    let _ = std::fs::remove_dir_all(&slices);
    std::fs::create_dir(&slices).unwrap();
    for slice in 0..axes.sizes()[2] {
        std::fs::write(slices.join(format!("{slice}")), dicom(axes, slice)).unwrap();
    }
    all.push(("dicom", slices));
    all
}

fn picture(path: &Path) -> Frame {
    let volume = open_volume(path.to_str().unwrap(), &VolumeSettings::default()).unwrap();
    let settings = RenderSettings {
        size: "96x72".parse().unwrap(),
        transfer_function: r#"{"points":[[0,1,1,1,0],[0.5,1,1,1,0],[0.9,1,1,1,1],[1,1,1,1,1]]}"#.into(),
        orientation: Some(Orientation::Patient),
        ..RenderSettings::default()
    };
    let speed = SpeedSettings { device: Some(Device::Cpu), ..SpeedSettings::default() };
    Pipeline::new(&volume, &settings, &speed).unwrap().render(0).unwrap().frame
}

/// Largest difference of any channel.
fn difference(a: &Frame, b: &Frame) -> f32 {
    let pairs = a.pixels().iter().zip(b.pixels());
    pairs.flat_map(|(a, b)| (0..3).map(|c| (a[c] - b[c]).abs())).fold(0.0, f32::max)
}

/// Brightness of a part of the picture; columns and rows from and to, as fractions.
fn light(frame: &Frame, columns: [f32; 2], rows: [f32; 2]) -> f32 {
    let size = frame.size();
    let span = |[from, to]: [f32; 2], count: u32| (from * count as f32) as u32..(to * count as f32) as u32;
    let pixels = span(rows, size.height).flat_map(|y| span(columns, size.width).map(move |x| (x, y)));
    pixels.map(|(x, y)| frame.pixel(x, y)[0]).sum()
}

/// Function that writes the scan with these axes in one format.
type Writer = fn(Axes) -> Vec<u8>;

#[test]
fn a_letter_is_the_same_in_every_orientation_and_format() {
    let folder = tempfile::tempdir().unwrap();
    let mut first: Option<Frame> = None;
    for axes in Axes::all() {
        for (format, path) in written(folder.path(), axes) {
            let found = picture(&path);
            let expected = first.get_or_insert_with(|| found.clone());
            let apart = difference(expected, &found);
            assert!(apart <= 2.0 / 255.0, "{axes:?} as {format} differs by {apart}");
        }
    }
    let picture = first.unwrap();
    // The patient faces us, so the patient's left is on the right of the picture.
    assert!(
        light(&picture, [0.5, 1.0], [0.0, 1.0]) > 100.0 * light(&picture, [0.0, 0.45], [0.0, 1.0]).max(0.01)
    );
    // The letter is upright and not mirrored: its stem is on its left, its bars at the top.
    let (upper, lower) = (light(&picture, [0.0, 1.0], [0.0, 0.5]), light(&picture, [0.0, 1.0], [0.5, 1.0]));
    assert!(upper > lower, "{upper} {lower}");
    let stem = light(&picture, [0.5, 0.62], [0.55, 0.9]);
    let void = light(&picture, [0.64, 0.9], [0.6, 0.9]);
    assert!(stem > 4.0 * void, "{stem} {void}");
}

/// Scans that are oblique in the patient: axial, sagittal and coronal ones, and mirrored grids, turned by 49 degrees.
#[test]
fn oblique_scans_are_the_same_in_every_format() {
    let folder = tempfile::tempdir().unwrap();
    let mut first: Option<Frame> = None;
    for axes in Axes::all().into_iter().step_by(5) {
        let axes = Axes { is_oblique: true, ..axes };
        for (format, path) in written(folder.path(), axes) {
            let found = picture(&path);
            let expected = first.get_or_insert_with(|| found.clone());
            let apart = difference(expected, &found);
            assert!(apart <= 2.0 / 255.0, "{axes:?} as {format} differs by {apart}");
        }
    }
    let upright = Axes { along: [0, 1, 2], backwards: [false; 3], is_oblique: false };
    let path = written(folder.path(), upright).remove(0).1;
    assert!(difference(&first.unwrap(), &picture(&path)) > 0.5, "it is turned");
}

//! Slices beside the picture: crosshair, window, values under the pointer, rulers.

mod harness;

use eframe::egui::{
    Event, Key, Modifiers, MouseWheelSource, MouseWheelUnit, PointerButton, Pos2, Rect, TouchPhase, vec2,
};
use egui_kittest::kittest::Queryable;
use fovolnet::VolumeSettings;
use fovolnet_viewer::ui::slices::value_window::ValueWindow;

use harness::{Window, click, drag, keys, opened, settle, until, viewer, window, window_reading};
use std::path::Path;

/// A scan of 20×10×8 voxels of 1×2×3 mm whose x rises to the patient's right and y to the front. Voxel (x, y, z) has the value
/// 10 x + 100 y + 1000 z.
fn scan(folder: &Path) -> String {
    let header = "NRRD0005\ntype: uint16\ndimension: 3\nspace: left-posterior-superior\nsizes: 20 10 8\nspace directions: (-1,0,0) (0,-2,0) (0,0,3)\nkinds: domain domain domain\nendian: little\nencoding: raw\nspace origin: (5,7,-11)\nspace units: \"mm\" \"mm\" \"mm\"\n\n";
    let values = (0..1600u16).map(|i| 10 * (i % 20) + 100 * (i / 20 % 10) + 1000 * (i / 200));
    let path = folder.join("scan.nrrd");
    std::fs::write(&path, [header.as_bytes().to_vec(), values.flat_map(u16::to_le_bytes).collect()].concat())
        .unwrap();
    path.display().to_string()
}

/// Window of the scan with slices.
fn with_slices(folder: &Path) -> Window {
    let mut window = window_reading(Some(&scan(folder)), VolumeSettings::default(), folder);
    keys(&mut window, Modifiers::NONE, Key::F4);
    settle(&mut window);
    window
}

/// Rectangle of the picture in the room of slice `name`, whose sides measure `width` and `height`.
fn placed(window: &Window, name: &str, [width, height]: [f32; 2]) -> Rect {
    let room = window.get_by_label(name).rect().shrink(22.0);
    let scale = (room.width() / width).min(room.height() / height);
    Rect::from_center_size(room.center(), vec2(width, height) * scale)
}

/// The centre of pixel (`x`, `y`) of the axial slice, which has 20×10 pixels of 1×2 mm.
fn axial(window: &Window, x: f32, y: f32) -> Pos2 {
    let rect = placed(window, "Axial slice", [20.0, 20.0]);
    rect.min + rect.size() * vec2((x + 0.5) / 20.0, (y + 0.5) / 10.0)
}

fn hover(window: &mut Window, at: Pos2) {
    window.hover_at(at);
    for _ in 0..3 {
        window.step();
    }
}

/// Presses and releases `button` at `at`.
fn press(window: &mut Window, at: Pos2, button: PointerButton) {
    for pressed in [true, false] {
        window.event(Event::PointerButton { pos: at, button, pressed, modifiers: Modifiers::NONE });
        window.step();
    }
}

fn drag_right(window: &mut Window, from: Pos2, to: Pos2) {
    hover(window, from);
    let (button, modifiers) = (PointerButton::Secondary, Modifiers::NONE);
    window.event(Event::PointerButton { pos: from, button, pressed: true, modifiers });
    window.step();
    for i in 1..=4 {
        window.hover_at(from.lerp(to, i as f32 / 4.0));
        window.step();
    }
    window.event(Event::PointerButton { pos: to, button, pressed: false, modifiers });
    window.step();
}

#[test]
fn slices_come_and_go_by_key_and_menu() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = window(Some("head"), folder.path());
    assert!(window.query_by_label("z slice").is_none());
    let whole = viewer(&window).shown().unwrap().size;
    keys(&mut window, Modifiers::NONE, Key::F4);
    settle(&mut window);
    for name in ["x slice", "y slice", "z slice"] {
        assert!(window.query_by_label(name).is_some(), "{name}");
    }
    let quarter = viewer(&window).shown().unwrap().size;
    let [width, height] = [whole.width / 2, whole.height / 2];
    assert!(quarter.width.abs_diff(width) <= 2 && quarter.height.abs_diff(height) <= 2, "{quarter} {whole}");
    // The settings have headings of the same names; the menu comes first.
    for name in ["View", "Slices"] {
        window.get_all_by_label_contains(name).next().unwrap().click();
        window.step();
        window.step();
    }
    settle(&mut window);
    assert!(window.query_by_label("z slice").is_none());
    assert_eq!(viewer(&window).shown().unwrap().size, whole);
}

#[test]
fn the_patients_left_is_on_the_right_and_values_are_read_there() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = with_slices(folder.path());
    assert_eq!(viewer(&window).slices().crosshair, [10, 5, 4]);
    // The rightmost pixel of the second row: x rises to the left of the picture, y upwards.
    let at = axial(&window, 19.0, 1.0);
    hover(&mut window, at);
    let words = viewer(&window).pointed().unwrap().to_owned();
    assert_eq!(words, "value 4800   voxel 0, 8, 4   LPS 5.0, -9.0, 1.0 mm");
    assert!(window.query_by_label(&words).is_some(), "the status line says it");
    let at = axial(&window, 0.0, 9.0);
    hover(&mut window, at);
    assert_eq!(viewer(&window).pointed(), Some("value 4190   voxel 19, 0, 4   LPS -14.0, 7.0, 1.0 mm"));
    let outside = window.get_by_label("Axial slice").rect().min + vec2(3.0, 3.0);
    hover(&mut window, outside);
    assert_eq!(viewer(&window).pointed(), None);
}

#[test]
fn the_crosshair_is_shared_and_the_wheel_steps() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = with_slices(folder.path());
    let at = axial(&window, 4.0, 2.0);
    hover(&mut window, at);
    press(&mut window, at, PointerButton::Primary);
    assert_eq!(viewer(&window).slices().crosshair, [15, 7, 4]);
    let to = axial(&window, 6.0, 9.0);
    drag(&mut window, at, to);
    assert_eq!(viewer(&window).slices().crosshair, [13, 0, 4]);
    // The coronal slice has the head on top.
    let rect = placed(&window, "Coronal slice", [20.0, 24.0]);
    let top = rect.min + rect.size() * vec2(0.5 / 20.0, 0.5 / 8.0);
    hover(&mut window, top);
    press(&mut window, top, PointerButton::Primary);
    assert_eq!(viewer(&window).slices().crosshair, [19, 0, 7]);
    let turn = |window: &mut Window, lines: f32| {
        hover(window, at);
        window.event(Event::MouseWheel {
            unit: MouseWheelUnit::Line,
            delta: vec2(0.0, lines),
            phase: TouchPhase::Move,
            source: MouseWheelSource::Wheel,
            modifiers: Modifiers::NONE,
        });
        window.step();
    };
    turn(&mut window, -3.0);
    assert_eq!(viewer(&window).slices().crosshair, [19, 0, 4]);
    turn(&mut window, 9.0);
    assert_eq!(viewer(&window).slices().crosshair, [19, 0, 7]);
}

#[test]
fn window_and_level_are_dragged_and_used_for_the_picture() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = with_slices(folder.path());
    let usual = ValueWindow::over([0.0, 8090.0]);
    assert_eq!(viewer(&window).slices().shown_window(opened(&window)), usual);
    let from = axial(&window, 10.0, 5.0);
    drag_right(&mut window, from, from + vec2(-40.0, 20.0));
    let dragged = viewer(&window).slices().window.unwrap();
    let wanted = usual.dragged(-40.0, 20.0, usual);
    assert!((dragged.width - wanted.width).abs() < 0.5 && (dragged.centre - wanted.centre).abs() < 0.5);
    assert_eq!(opened(&window).volume.volume.range(), [0.0, 8090.0], "the picture keeps its own");
    window.get_by_label("Use for the picture").scroll_to_me();
    settle(&mut window);
    click(&mut window, "Use for the picture");
    until(&mut window, "the window in the picture", |viewer| {
        viewer.opened().is_some_and(|opened| opened.volume.volume.range() != [0.0, 8090.0])
    });
    settle(&mut window);
    let [centre, width] = opened(&window).document.session().read.window.unwrap();
    assert_eq!((centre, width), (dragged.centre, dragged.width));
    drag_right(&mut window, from, from + vec2(30.0, 0.0));
    assert_ne!(viewer(&window).slices().window, Some(dragged));
    for _ in 0..2 {
        press(&mut window, from, PointerButton::Primary);
    }
    assert_eq!(viewer(&window).slices().window, None, "a double click resets it");
}

#[test]
fn rulers_measure_and_stay_until_they_are_cleared() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = with_slices(folder.path());
    keys(&mut window, Modifiers::NONE, Key::M);
    let crosshair = viewer(&window).slices().crosshair;
    for (from, to) in [([2.0, 1.0], [5.0, 3.0]), ([10.0, 8.0], [18.0, 5.0])] {
        let [from, to] = [from, to].map(|[x, y]| axial(&window, x, y));
        drag(&mut window, from, to);
    }
    let volume = opened(&window).volume.volume.clone();
    let lengths: Vec<f64> =
        viewer(&window).slices().rulers.iter().map(|ruler| ruler.length(&volume)).collect();
    // 3 by 4 mm, and 8 by 6 mm.
    assert!(
        lengths.len() == 2 && (lengths[0] - 5.0).abs() < 0.05 && (lengths[1] - 10.0).abs() < 0.05,
        "{lengths:?}"
    );
    assert_eq!(viewer(&window).slices().crosshair, crosshair, "the ruler leaves it alone");
    window.get_by_label("Clear rulers").scroll_to_me();
    settle(&mut window);
    click(&mut window, "Clear rulers");
    assert_eq!(viewer(&window).slices().rulers.iter().count(), 0);
    keys(&mut window, Modifiers::NONE, Key::M);
    assert!(!viewer(&window).slices().measures);
}

#[test]
fn the_picture_says_what_it_shows_under_the_pointer() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = window(Some("head"), folder.path());
    window.hover_at(Pos2::new(285.0, 290.0));
    until(&mut window, "words on the picture", |viewer| viewer.pointed().is_some());
    let words = viewer(&window).pointed().unwrap();
    assert!(words.starts_with("value ") && words.contains("voxel "), "{words}");
    window.hover_at(Pos2::new(6.0, 60.0));
    until(&mut window, "no words beside the volume", |viewer| viewer.pointed().is_none());
}

#[test]
fn rulers_measure_between_points_of_the_picture() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = window(Some("head"), folder.path());
    keys(&mut window, Modifiers::NONE, Key::M);
    let camera = opened(&window).camera();
    let ends = [Pos2::new(265.0, 290.0), Pos2::new(305.0, 290.0)];
    let (button, modifiers) = (PointerButton::Primary, Modifiers::NONE);
    window.hover_at(ends[0]);
    until(&mut window, "the first point", |viewer| viewer.pointed().is_some());
    for (pos, pressed) in [(ends[0], true), (ends[1], false)] {
        window.hover_at(pos);
        window.step();
        settle(&mut window);
        window.event(Event::PointerButton { pos, button, pressed, modifiers });
        window.step();
        settle(&mut window);
    }
    let rulers: Vec<_> = viewer(&window).slices().rulers.iter().copied().collect();
    let volume = opened(&window).volume.volume.clone();
    assert!(rulers.len() == 1 && rulers[0].plane.is_none(), "{rulers:?}");
    let length = rulers[0].length(&volume);
    assert!((1.0..12.0).contains(&length), "{length}");
    assert!(!viewer(&window).slices().rulers.draws_in(None), "it is done");
    assert_eq!(opened(&window).camera(), camera, "the view stays");
}

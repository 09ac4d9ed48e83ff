//! Panels that choose what of a volume is shown: mode, projection, planes, the parts of a file, and the window of values.

mod harness;

use eframe::egui::{Event, Modifiers, PointerButton, accesskit::Role, vec2};
use egui_kittest::kittest::Queryable;
use fovolnet::core::Projection;
use fovolnet::{Mode, VolumeSettings};
use harness::{Window, click, drag, opened, settle, until, viewer, window, window_reading};

/// Clicks the control `label`, which may lie below the visible part of the panels.
fn press(window: &mut Window, label: &str) {
    window.get_by_label(label).scroll_to_me();
    for _ in 0..3 {
        window.step();
    }
    click(window, label);
}

/// Chooses `name` of the list `label`.
fn choose(window: &mut Window, label: &str, name: &str) {
    window.get_by_role_and_label(Role::ComboBox, label).scroll_to_me();
    settle(window);
    window.get_by_role_and_label(Role::ComboBox, label).click();
    for _ in 0..3 {
        window.step();
    }
    click(window, name);
    settle(window);
}

#[test]
fn modes_and_projections_are_chosen() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = window(Some("head"), folder.path());
    choose(&mut window, "Mode", "isosurface");
    assert_eq!(opened(&window).document.settings().mode(), Mode::Isosurface);
    assert_eq!(viewer(&window).shown().unwrap().settings.mode, Mode::Isosurface);
    choose(&mut window, "Mode", "greatest value (MIP)");
    assert_eq!(opened(&window).document.settings().mode(), Mode::Mip);
    choose(&mut window, "Mode", "composite");
    assert_eq!(opened(&window).document.settings().mode, None);
    press(&mut window, "orthographic");
    settle(&mut window);
    assert_eq!(opened(&window).camera().projection, Projection::Orthographic);
    assert_eq!(viewer(&window).shown().unwrap().camera.projection, Projection::Orthographic);
}

#[test]
fn planes_are_added_flipped_and_removed() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = window(Some("head"), folder.path());
    press(&mut window, "Clipping");
    press(&mut window, "Add a plane");
    settle(&mut window);
    let plane = opened(&window).document.settings().clip_plane.clone().unwrap()[0];
    let (forward, ..) = opened(&window).camera().axes();
    assert!((forward.x - plane[0]).abs() < 1e-9 && plane[3] == 0.0, "it faces the eye");
    assert_eq!(viewer(&window).shown().unwrap().settings.planes.as_slice().len(), 1);
    press(&mut window, "Flip");
    settle(&mut window);
    assert_eq!(opened(&window).document.settings().clip_plane.clone().unwrap()[0], plane.map(|x| -x));
    press(&mut window, "Remove");
    settle(&mut window);
    assert_eq!(opened(&window).document.settings().clip_plane, None);
}

#[test]
fn arrays_of_a_file_are_chosen() {
    let folder = tempfile::tempdir().unwrap();
    let head = "# vtk DataFile Version 3.0\nx\nASCII\nDATASET STRUCTURED_POINTS\nDIMENSIONS 4 4 4\nORIGIN 0 0 0\nSPACING 1 1 1\nPOINT_DATA 64\n";
    let array = |name: &str, times: usize| {
        let values: Vec<String> = (0..64).map(|i| (i * times % 251).to_string()).collect();
        format!("SCALARS {name} unsigned_char 1\nLOOKUP_TABLE default\n{}\n", values.join(" "))
    };
    let path = folder.path().join("two.vtk");
    std::fs::write(&path, [head, &array("density", 3), &array("speed", 7)].concat()).unwrap();
    let mut window = window_reading(path.to_str(), VolumeSettings::default(), folder.path());
    choose(&mut window, "Array", "speed");
    until(&mut window, "the other array", |viewer| {
        viewer.opened().is_some_and(|opened| opened.volume.volume.contents().array == 1)
    });
    settle(&mut window);
    assert_eq!(opened(&window).document.session().read.array.as_deref(), Some("speed"));
    assert_eq!(opened(&window).volume.volume.value([1, 0, 0]), 7.0);
}

/// A NRRD file of `times` time points, or components that are colours if `kinds` say so.
fn nrrd(folder: &std::path::Path, kinds: &str, sizes: &str, bytes: Vec<u8>) -> String {
    let header = format!("NRRD0004\ntype: uint8\ndimension: 4\nsizes: {sizes}\n{kinds}encoding: raw\n\n");
    let path = folder.join("four.nrrd");
    std::fs::write(&path, [header.into_bytes(), bytes].concat()).unwrap();
    path.display().to_string()
}

#[test]
fn time_points_are_played() {
    let folder = tempfile::tempdir().unwrap();
    let bytes = (0..3 * 512).map(|i| (i / 512 * 100 + 50) as u8).collect();
    let path = nrrd(folder.path(), "kinds: domain domain domain time\n", "8 8 8 3", bytes);
    let mut window = window_reading(Some(&path), VolumeSettings::default(), folder.path());
    press(&mut window, "Play time points");
    for time in [1, 2, 0] {
        until(&mut window, "the next time point", |viewer| {
            viewer.opened().is_some_and(|opened| opened.volume.volume.contents().time == time)
        });
    }
    press(&mut window, "Play time points");
    settle(&mut window);
    assert!(opened(&window).document.settings().tf.is_some(), "colours stay through time");
}

#[test]
fn components_are_colours_or_alone() {
    let folder = tempfile::tempdir().unwrap();
    let bytes = (0..3 * 512).map(|i| (i % 3 * 100 + i / 50) as u8).collect();
    let path = nrrd(folder.path(), "kinds: RGB-color domain domain domain\n", "3 8 8 8", bytes);
    let mut window = window_reading(Some(&path), VolumeSettings::default(), folder.path());
    assert!(opened(&window).volume.colours.is_some());
    choose(&mut window, "Component", "2");
    until(&mut window, "one component", |viewer| {
        viewer.opened().is_some_and(|opened| opened.volume.colours.is_none())
    });
    choose(&mut window, "Component", "all, as colours");
    until(&mut window, "all components", |viewer| {
        viewer.opened().is_some_and(|opened| opened.volume.colours.is_some())
    });
}

#[test]
fn labels_are_hidden_and_shown() {
    let folder = tempfile::tempdir().unwrap();
    let bytes = (0..512).map(|i| [0, 3, 1, 7][i / 8 % 4]).collect::<Vec<u8>>();
    let path = folder.path().join("organs_8x8x8_uint8.raw");
    std::fs::write(&path, bytes).unwrap();
    let mut window = window_reading(path.to_str(), VolumeSettings::default(), folder.path());
    let opacities = |window: &Window| {
        opened(window).shown_labels().iter().map(|label| label.opacity).collect::<Vec<f64>>()
    };
    assert_eq!(opacities(&window), [0.9; 3]);
    press(&mut window, "label 3");
    settle(&mut window);
    assert_eq!(opacities(&window), [0.9, 0.0, 0.9]);
    press(&mut window, "Hide all");
    settle(&mut window);
    assert_eq!(opacities(&window), [0.0; 3]);
    press(&mut window, "Show all");
    settle(&mut window);
    assert_eq!(opacities(&window), [0.9; 3]);
}

#[test]
fn planes_are_dragged_in_the_picture() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = window(Some("head"), folder.path());
    press(&mut window, "Clipping");
    press(&mut window, "Add a plane");
    settle(&mut window);
    let camera = opened(&window).camera();
    let plane = |window: &Window| opened(window).document.settings().clip_plane.clone().unwrap()[0];
    let before = plane(&window);
    // The plane faces the eye: its disc is seen around the tip of the arrow.
    let disc = window.get_by_label("Move plane 1").rect().left_center() + vec2(1.5, 0.0);
    drag(&mut window, disc, disc + vec2(0.0, -30.0));
    let moved = plane(&window);
    assert!(moved[..3] == before[..3] && moved[3] > before[3] + 0.02, "{before:?} {moved:?}");
    let tip = window.get_by_label("Turn plane 1").rect().center();
    drag(&mut window, tip, tip + vec2(25.0, 0.0));
    let turned = plane(&window);
    let cosine: f64 = (0..3).map(|a| turned[a] * moved[a]).sum();
    assert!(cosine < 0.95 && (turned[3] - moved[3]).abs() < 1e-9, "{moved:?} {turned:?}");
    assert_eq!(opened(&window).camera(), camera, "the view stays");
    assert_eq!(viewer(&window).shown().unwrap().settings.planes.as_slice().len(), 1);
}

#[test]
fn opacity_by_gradient_is_switched_and_its_points_are_dragged() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = window(Some("head"), folder.path());
    let label = "Opacity by gradient";
    let curve = |window: &Window| opened(window).transfer().gradient().map(|curve| curve.points().to_vec());
    let before = opened(&window).transfer().clone();
    press(&mut window, label);
    settle(&mut window);
    let usual = curve(&window).unwrap();
    assert_eq!(opened(&window).transfer().points(), before.points());
    let shown = viewer(&window).shown().unwrap().settings.transfer_function.text().into_owned();
    assert!(shown.contains("\"gradient\":"), "{shown}");
    // Beside the points of the usual curve, a double click adds one.
    let at = window.get_by_label(label).rect().left_bottom() + vec2(170.0, 40.0);
    window.hover_at(at);
    for pressed in [true, false, true, false] {
        let (button, modifiers) = (PointerButton::Primary, Modifiers::NONE);
        window.event(Event::PointerButton { pos: at, button, pressed, modifiers });
        window.step();
    }
    settle(&mut window);
    let added = curve(&window).unwrap();
    assert_eq!(added.len(), usual.len() + 1, "{added:?}");
    drag(&mut window, at, at + vec2(25.0, -10.0));
    let moved = curve(&window).unwrap();
    assert!(moved[..2] == usual && moved[2][0] > added[2][0] && moved[2][1] > added[2][1], "{moved:?}");
    // Switched off and on again, it is as it was.
    press(&mut window, label);
    settle(&mut window);
    assert_eq!(curve(&window), None);
    press(&mut window, label);
    settle(&mut window);
    assert_eq!(curve(&window), Some(moved));
}

//! Tests of the window with simulated clicks, drags and keys, without a display.

mod harness;

use eframe::egui::{Color32, Event, Key, Modifiers, PointerButton, Shape, TextureId, pos2};
use egui_kittest::kittest::Queryable;
use fovolnet::Session;
use fovolnet_viewer::frames::presented::Progress;
use fovolnet_viewer::ui::dialogues::Dialogue;
use harness::{Window, click, drag, keys, opened, settle, type_path, viewer, window};
use std::time::{Duration, Instant};

#[test]
fn a_volume_of_the_start_page_opens_and_becomes_a_full_picture() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = window(None, folder.path());
    assert!(viewer(&window).opened().is_none());
    click(&mut window, "marschner-lobb");
    settle(&mut window);
    assert_eq!(viewer(&window).shown().unwrap().progress, Progress::Complete);
    assert_eq!(opened(&window).document.name(), "marschner-lobb");
    keys(&mut window, Modifiers::COMMAND, Key::W);
    settle(&mut window);
    assert!(viewer(&window).opened().is_none());
}

#[test]
fn hands_turn_move_and_zoom_and_undo_takes_it_back() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = window(Some("head"), folder.path());
    let first = opened(&window).camera();
    drag(&mut window, pos2(200.0, 200.0), pos2(300.0, 220.0));
    let turned = opened(&window).camera();
    assert!((turned.eye.length() - first.eye.length()).abs() < 1e-9 && turned.eye.distance(first.eye) > 0.3);
    assert!(opened(&window).document.is_changed());
    keys(&mut window, Modifiers::COMMAND, Key::Z);
    assert_eq!(opened(&window).camera(), first);
    keys(&mut window, Modifiers::COMMAND | Modifiers::SHIFT, Key::Z);
    assert_eq!(opened(&window).camera(), turned);
    window.hover_at(pos2(250.0, 200.0));
    window.event(Event::MouseWheel {
        unit: eframe::egui::MouseWheelUnit::Line,
        delta: [0.0, 3.0].into(),
        phase: eframe::egui::TouchPhase::Move,
        source: eframe::egui::MouseWheelSource::Wheel,
        modifiers: Modifiers::NONE,
    });
    settle(&mut window);
    assert!(opened(&window).camera().eye.length() < turned.eye.length());
    keys(&mut window, Modifiers::NONE, Key::Num3);
    assert!(opened(&window).camera().eye.normalize().x > 0.999);
    keys(&mut window, Modifiers::NONE, Key::Home);
    assert_eq!(opened(&window).camera(), first);
}

#[test]
fn the_interface_answers_while_pictures_are_made() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = window(Some("head"), folder.path());
    let mut slowest = Duration::ZERO;
    window.hover_at(pos2(200.0, 200.0));
    window.drag_at(pos2(200.0, 200.0));
    for i in 0..40 {
        window.hover_at(pos2(200.0 + i as f32 * 5.0, 200.0));
        let started = Instant::now();
        window.step();
        slowest = slowest.max(started.elapsed());
    }
    window.drop_at(pos2(400.0, 200.0));
    // No step waits for the renderer. The limit is generous for busy machines.
    assert!(slowest < Duration::from_secs(2), "{slowest:?}");
    settle(&mut window);
}

#[test]
fn views_become_keyframes_and_play() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = window(Some("head"), folder.path());
    keys(&mut window, Modifiers::NONE, Key::K);
    drag(&mut window, pos2(200.0, 200.0), pos2(320.0, 240.0));
    click(&mut window, "Add keyframe");
    settle(&mut window);
    assert_eq!(opened(&window).keyframes().len(), 2);
    opened(&window).document.settings().path.as_ref().expect("the path is of the session");
    keys(&mut window, Modifiers::NONE, Key::Space);
    let before = opened(&window).frame();
    for _ in 0..2 {
        window.step();
    }
    assert_ne!(opened(&window).frame(), before);
    keys(&mut window, Modifiers::NONE, Key::Space);
    settle(&mut window);
}

#[test]
fn transfer_functions_are_chosen_and_edited() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = window(Some("head"), folder.path());
    let first = opened(&window).transfer().clone();
    window.get_by_value("auto").click();
    settle(&mut window);
    window.get_by_label("magma").scroll_to_me();
    settle(&mut window);
    click(&mut window, "magma");
    settle(&mut window);
    assert_eq!(opened(&window).document.settings().tf, Some("magma".into()));
    assert_ne!(opened(&window).transfer(), &first);
    let points = opened(&window).transfer().points().len();
    let at = pos2(780.0, 100.0);
    window.hover_at(at);
    for _ in 0..2 {
        for pressed in [true, false] {
            let (button, modifiers) = (PointerButton::Primary, Modifiers::NONE);
            window.event(Event::PointerButton { pos: at, button, pressed, modifiers });
        }
        window.step();
    }
    settle(&mut window);
    assert_eq!(opened(&window).transfer().points().len(), points + 1);
    assert!(opened(&window).document.settings().tf.as_ref().unwrap().text().starts_with('{'));
}

/// Types `text` into the field `label`, letter by letter, and leaves the field.
fn type_setting(window: &mut Window, label: &str, text: &str) {
    let role = eframe::egui::accesskit::Role::TextInput;
    window.get_by_role_and_label(role, label).scroll_to_me();
    settle(window);
    window.get_by_role_and_label(role, label).click();
    window.step();
    keys(window, Modifiers::COMMAND, Key::A);
    for letter in text.chars() {
        window.event(Event::Text(letter.to_string()));
        window.step();
    }
    keys(window, Modifiers::NONE, Key::Enter);
}

#[test]
fn texts_of_settings_are_typed_letter_by_letter() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = window(Some("head"), folder.path());
    for label in ["Sampling", "session"] {
        window.get_by_label(label).scroll_to_me();
        settle(&mut window);
        click(&mut window, label);
        settle(&mut window);
    }
    type_setting(&mut window, "Gaze", "0.5,0.05");
    assert_eq!(opened(&window).document.settings().gaze, Some("0.5,0.05".into()));
    assert_eq!(opened(&window).gaze().gaze(0), [0.5, 0.05]);
    type_setting(&mut window, "Weights", "wnet-paper");
    assert_eq!(opened(&window).document.settings().weights.as_deref(), Some("wnet-paper"));
}

#[test]
fn pictures_are_exported_and_sessions_saved_and_opened_again() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = window(Some("head"), folder.path());
    drag(&mut window, pos2(200.0, 200.0), pos2(260.0, 230.0));
    let picture = folder.path().join("out.png");
    keys(&mut window, Modifiers::COMMAND, Key::E);
    type_path(&mut window, picture.to_str().unwrap());
    click(&mut window, "Export");
    settle(&mut window);
    assert!(picture.is_file() && folder.path().join("out.png.toml").is_file());
    let session = folder.path().join("mine.toml");
    keys(&mut window, Modifiers::COMMAND, Key::S);
    type_path(&mut window, session.to_str().unwrap());
    click(&mut window, "Save");
    settle(&mut window);
    assert!(!opened(&window).document.is_changed());
    let saved = Session::read(&session).unwrap();
    assert_eq!(&saved, opened(&window).document.session());
    let camera = opened(&window).camera();
    drop(window);
    let again = self::window(Some(session.to_str().unwrap()), folder.path());
    assert_eq!(opened(&again).camera(), camera);
    assert_eq!(opened(&again).document.name(), "mine.toml");
}

#[test]
fn what_is_wrong_is_said_and_the_rest_goes_on() {
    let folder = tempfile::tempdir().unwrap();
    let session = folder.path().join("bad.toml");
    std::fs::write(&session, "volume = \"head\"\n[render]\nsgima = 3\n").unwrap();
    let mut window = window(Some(session.to_str().unwrap()), folder.path());
    assert!(viewer(&window).opened().is_none());
    assert!(viewer(&window).messages().errors().any(|error| error.contains("sgima")));
    std::fs::write(&session, "volume = \"/no/such/volume.nrrd\"\n").unwrap();
    keys(&mut window, Modifiers::COMMAND, Key::O);
    type_path(&mut window, session.to_str().unwrap());
    click(&mut window, "Open");
    settle(&mut window);
    let errors: Vec<&str> = viewer(&window).messages().errors().collect();
    assert!(errors.iter().any(|error| error.contains("/no/such/volume.nrrd")), "{errors:?}");
    click(&mut window, "head");
    settle(&mut window);
    assert!(viewer(&window).shown().is_some());
    assert_eq!(viewer(&window).messages().errors().count(), 0);
}

#[test]
fn bare_voxels_are_asked_about() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("unknown.raw");
    std::fs::write(&path, (0..8000u32).map(|i| (i / 31) as u8).collect::<Vec<u8>>()).unwrap();
    let mut window = window(None, folder.path());
    keys(&mut window, Modifiers::COMMAND, Key::O);
    type_path(&mut window, path.to_str().unwrap());
    click(&mut window, "Open");
    settle(&mut window);
    assert!(
        matches!(viewer(&window).dialogue(), Some(Dialogue::Layout(_))),
        "{:?}",
        viewer(&window).messages()
    );
    click(&mut window, "Open");
    settle(&mut window);
    assert_eq!(opened(&window).volume.volume.grid().dims(), [20; 3]);
}

#[test]
fn unsaved_work_is_asked_about_and_comes_back_after_a_crash() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = window(Some("head"), folder.path());
    drag(&mut window, pos2(200.0, 200.0), pos2(260.0, 230.0));
    click(&mut window, "cached");
    settle(&mut window);
    let camera = opened(&window).camera();
    keys(&mut window, Modifiers::COMMAND, Key::W);
    assert!(matches!(viewer(&window).dialogue(), Some(Dialogue::Unsaved(_))));
    click(&mut window, "Cancel");
    assert_eq!(opened(&window).camera(), camera);
    // Saving first needs a name, and then closes the session.
    let session = folder.path().join("first.toml");
    keys(&mut window, Modifiers::COMMAND, Key::W);
    click(&mut window, "Save");
    type_path(&mut window, session.to_str().unwrap());
    click(&mut window, "Save");
    settle(&mut window);
    assert!(session.is_file() && viewer(&window).opened().is_none());
    drop(window);
    let mut window = self::window(Some("head"), folder.path());
    drag(&mut window, pos2(200.0, 200.0), pos2(260.0, 230.0));
    for _ in 0..50 {
        window.step();
    }
    // Dropped without closing, as if the program had been killed.
    drop(window);
    let mut again = self::window(None, folder.path());
    assert!(matches!(viewer(&again).dialogue(), Some(Dialogue::Restore(_))));
    click(&mut again, "Go on with it");
    settle(&mut again);
    assert_eq!(opened(&again).camera(), camera);
    assert!(opened(&again).document.is_changed());
    keys(&mut again, Modifiers::COMMAND, Key::W);
    click(&mut again, "Do not save");
    settle(&mut again);
    drop(again);
    assert!(viewer(&self::window(None, folder.path())).dialogue().is_none());
}

#[test]
fn a_move_of_the_hand_is_no_work_to_be_asked_about() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = window(Some("head"), folder.path());
    drag(&mut window, pos2(200.0, 200.0), pos2(260.0, 230.0));
    assert!(opened(&window).document.is_changed(), "it comes back after a crash");
    keys(&mut window, Modifiers::COMMAND, Key::W);
    settle(&mut window);
    assert!(viewer(&window).dialogue().is_none() && viewer(&window).opened().is_none());
}

#[test]
fn exports_leave_the_session_that_was_saved_and_say_what_they_replace() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = window(Some("head"), folder.path());
    let [session, picture, beside] =
        ["work.toml", "work.png", "work.png.toml"].map(|name| folder.path().join(name));
    keys(&mut window, Modifiers::COMMAND, Key::S);
    type_path(&mut window, session.to_str().unwrap());
    click(&mut window, "Save");
    settle(&mut window);
    let saved = std::fs::read(&session).unwrap();
    for is_first in [true, false] {
        keys(&mut window, Modifiers::COMMAND, Key::E);
        // The name has no extension; the warning is about the file that will be written.
        type_path(&mut window, folder.path().join("work").to_str().unwrap());
        for name in ["work.png", "work.png.toml"] {
            let said = format!("{name} is there already and will be replaced.");
            assert_eq!(window.query_by_label(&said).is_none(), is_first, "{said}");
        }
        click(&mut window, "Transparent background");
        click(&mut window, "Export");
        settle(&mut window);
    }
    assert_eq!(std::fs::read(&session).unwrap(), saved);
    assert!(picture.is_file() && Session::read(&beside).unwrap().render.transparent == Some(true));
}

#[test]
fn a_clip_of_a_free_view_moves_or_says_that_it_does_not() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = window(Some("head"), folder.path());
    drag(&mut window, pos2(200.0, 200.0), pos2(260.0, 230.0));
    keys(&mut window, Modifiers::COMMAND | Modifiers::SHIFT, Key::E);
    assert!(window.query_by_label_contains("stands still").is_none());
    assert!(window.query_by_label_contains("500 frames of 1280x720, 16.7 s").is_some());
    type_path(&mut window, folder.path().join("clip.y4m").to_str().unwrap());
    assert!(window.query_by_label_contains("1.4 GB").is_some());
    assert!(window.query_by_label_contains("This is a large file.").is_some());
    window.get_by_value("orbit from here").click();
    window.step();
    window.step();
    click(&mut window, "stands still");
    assert!(window.query_by_label_contains("all 500 frames are the same picture").is_some());
    keys(&mut window, Modifiers::NONE, Key::Escape);
    assert!(viewer(&window).dialogue().is_none());
}

#[test]
fn boundaries_are_shown_behind_the_points() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = window(Some("head"), folder.path());
    let pictures = |window: &Window| window.output().shapes.iter().filter(|s| is_picture(&s.shape)).count();
    let before = pictures(&window);
    click(&mut window, "boundaries");
    settle(&mut window);
    assert_eq!(pictures(&window), before + 1);
    click(&mut window, "values");
    assert_eq!(pictures(&window), before);
}

/// Whether `shape` is painted with its own texture.
fn is_picture(shape: &Shape) -> bool {
    let texture = match shape {
        Shape::Rect(rect) => rect.brush.as_ref().map(|brush| brush.fill_texture_id),
        Shape::Mesh(mesh) => Some(mesh.texture_id),
        _ => None,
    };
    texture.is_some_and(|texture| texture != TextureId::default())
}

#[test]
fn the_help_sheet_goes_as_it_came() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = window(None, folder.path());
    for closes in [Key::F1, Key::Escape] {
        keys(&mut window, Modifiers::NONE, Key::F1);
        assert!(matches!(viewer(&window).dialogue(), Some(Dialogue::Help)));
        keys(&mut window, Modifiers::NONE, closes);
        assert!(viewer(&window).dialogue().is_none(), "{closes:?}");
    }
}

#[test]
fn colours_of_buttons_are_those_of_the_picture() {
    let folder = tempfile::tempdir().unwrap();
    let session = folder.path().join("blue.toml");
    let text = "volume = \"head\"\n[render]\nbackground = [0.05, 0.07, 0.12]\n";
    std::fs::write(&session, text).unwrap();
    let mut window = window(Some(session.to_str().unwrap()), folder.path());
    window.get_by_label("Background").scroll_to_me();
    settle(&mut window);
    let expected = Color32::from_rgb(13, 18, 31);
    let shapes = &window.output().shapes;
    let fills = shapes.iter().filter_map(|shape| match &shape.shape {
        Shape::Rect(rect) => Some(rect.fill),
        _ => None,
    });
    assert!(fills.into_iter().any(|fill| fill == expected));
}

#[test]
fn what_stands_still_has_statistics_that_agree_and_can_be_reached() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = window(Some("head"), folder.path());
    assert!(window.query_by_label_contains("all of it measured").is_some());
    assert!(window.query_by_label("at rest").is_some() && window.query_by_label("Density").is_some());
    window.get_by_label("Made by").scroll_to_me();
    settle(&mut window);
    let place = window.get_by_label("Made by").rect();
    assert!(place.bottom() < 560.0 && place.right() < 900.0, "{place:?}");
}

#[test]
fn a_volume_that_cannot_be_shown_is_a_failure() {
    let folder = tempfile::tempdir().unwrap();
    let failure = |source: Option<&str>| {
        let window = window(source, folder.path());
        viewer(&window).failure().map(str::to_owned)
    };
    assert_eq!(failure(Some("head")), None);
    assert_eq!(failure(None), None);
    assert!(failure(Some("/no/such/volume.raw")).unwrap().contains("/no/such/volume.raw"));
    let unknown = folder.path().join("unknown.raw");
    std::fs::write(&unknown, [7u8; 12]).unwrap();
    assert!(failure(Some(unknown.to_str().unwrap())).is_some());
    let session = folder.path().join("dark.toml");
    std::fs::write(&session, "volume = \"head\"\n[render]\nambient = 7.0\n").unwrap();
    assert!(failure(Some(session.to_str().unwrap())).unwrap().contains("ambient"));
}

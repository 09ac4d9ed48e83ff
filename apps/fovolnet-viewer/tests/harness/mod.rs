//! A window of the viewer under simulated hands.
#![allow(dead_code, reason = "each test uses a part")]

use eframe::egui::{Event, Key, Modifiers, Pos2};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use fovolnet::{Device, RenderOverrides, SpeedSettings, VolumeSettings};
use fovolnet_viewer::session::opened::Opened;
use fovolnet_viewer::session::places::Places;
use fovolnet_viewer::{Start, Viewer};
use std::path::Path;
use std::time::{Duration, Instant};

/// Window that creates its viewer in the first frame.
pub type Window = Harness<'static, Option<Viewer>>;

/// Window of the volume or session `source`, with persistent state in `folder`.
pub fn window(source: Option<&str>, folder: &Path) -> Window {
    let read = VolumeSettings { dims: source.map(|_| [24; 3]), ..VolumeSettings::default() };
    window_reading(source, read, folder)
}

/// Window of `source`, read with `read`.
pub fn window_reading(source: Option<&str>, read: VolumeSettings, folder: &Path) -> Window {
    let start = Start {
        source: source.map(str::to_owned),
        read,
        render: RenderOverrides::default(),
        speed: SpeedSettings { device: Some(Device::Cpu), ..SpeedSettings::default() },
        screen: None,
        painter: None,
    };
    let places = Places::in_folder(Some(folder.join("state")));
    let show = move |ui: &mut eframe::egui::Ui, viewer: &mut Option<Viewer>| {
        let make = || Viewer::new(ui.ctx(), start.clone(), places.clone()).unwrap();
        viewer.get_or_insert_with(make).show(ui);
    };
    let builder = Harness::builder().with_size([900.0, 640.0]).with_step_dt(0.1);
    let mut window = builder.build_ui_state(show, None);
    settle(&mut window);
    window
}

pub fn viewer(window: &Window) -> &Viewer {
    window.state().as_ref().expect("it was shown")
}

pub fn opened(window: &Window) -> &Opened {
    viewer(window).opened().expect("something is open")
}

/// Runs frames until `wanted` returns true.
pub fn until(window: &mut Window, what: &str, wanted: impl Fn(&Viewer) -> bool) {
    let started = Instant::now();
    while !wanted(viewer(window)) {
        window.step();
        std::thread::sleep(Duration::from_millis(2));
        assert!(
            started.elapsed() < Duration::from_secs(120),
            "{what} never came: {:?}",
            viewer(window).messages()
        );
    }
}

/// Runs frames until no work is pending.
pub fn settle(window: &mut Window) {
    for _ in 0..3 {
        window.step();
    }
    until(window, "the end of all work", Viewer::is_settled);
    for _ in 0..16 {
        window.step();
    }
    until(window, "the end of all work", Viewer::is_settled);
}

pub fn click(window: &mut Window, label: &str) {
    window.get_by_label(label).click();
    for _ in 0..3 {
        window.step();
    }
}

pub fn keys(window: &mut Window, modifiers: Modifiers, key: Key) {
    window.key_press_modifiers(modifiers, key);
    for _ in 0..3 {
        window.step();
    }
}

pub fn drag(window: &mut Window, from: Pos2, to: Pos2) {
    window.hover_at(from);
    window.step();
    window.drag_at(from);
    window.step();
    for i in 1..=4 {
        window.hover_at(from.lerp(to, i as f32 / 4.0));
        window.step();
    }
    window.drop_at(to);
    settle(window);
}

/// Replaces a dialogue's suggested path by `text`.
pub fn type_path(window: &mut Window, text: &str) {
    window.get_by_role(eframe::egui::accesskit::Role::TextInput).click();
    window.step();
    keys(window, Modifiers::COMMAND, Key::A);
    window.event(Event::Text(text.to_owned()));
    window.step();
    window.step();
}

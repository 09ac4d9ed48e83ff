//! The command `fovolnet-viewer`: its arguments and its window.

use crate::session::kept;
use crate::session::places::Places;
use crate::window::drawing_threads;
use crate::window::no_window;
use crate::window::quad::Painter;
use crate::window::screen::Screen;
use crate::window::surface::Surface;
use crate::{Start, Viewer};
use anyhow::{Result, anyhow, bail};
use clap::Parser;
use eframe::egui::{
    Color32, ColorImage, Context, ScreenshotCallback, Ui, ViewportBuilder, ViewportCommand, Visuals,
};
use eframe::egui_wgpu::SurfaceConfig;
use fovolnet::core::{Frame, FrameSize, memory, stop, temporaries};
use fovolnet::gpu::Checks;
use fovolnet::io::image::{self, Alpha};
use fovolnet::{RenderOverrides, SpeedSettings, VolumeSettings, parse, signals};
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};

/// Look at a volume.
#[derive(Parser)]
#[command(name = "fovolnet-viewer", version, max_term_width = 100)]
struct Arguments {
    /// Volume file, folder of slices, procedural volume, or session (.toml)
    #[arg(value_parser = parse::file())]
    volume: Option<String>,
    #[command(flatten)]
    read: VolumeSettings,
    #[command(flatten)]
    render: RenderOverrides,
    #[command(flatten)]
    speed: SpeedSettings,
    /// Write a picture of the window as soon as the view is complete, and exit
    #[arg(long, value_name = "FILE.png")]
    screenshot: Option<PathBuf>,
    /// Size of the window in points
    #[arg(long, value_name = "WxH", default_value = "1280x800")]
    window_size: FrameSize,
    /// Pixels per point: 2 makes everything twice as large
    #[arg(long, value_name = "F", value_parser = clap::value_parser!(f32))]
    scale: Option<f32>,
    /// Light or dark
    #[arg(long, value_name = "THEME")]
    theme: Option<Theme>,
}

#[derive(clap::ValueEnum, Clone, Copy, PartialEq, Eq)]
enum Theme {
    Dark,
    Light,
}

/// The window, and the screenshot to take of it.
struct Window {
    /// Dropped first, because the viewer ends once its pictures are made.
    surface: Option<Surface>,
    viewer: Viewer,
    screenshot: Option<Screenshot>,
    outcome: Outcome,
    /// Whether a signal has been heard.
    is_stopped: bool,
}

/// Result of the screenshot, or the reason why the window closed.
type Outcome = Arc<Mutex<Option<Result<()>>>>;

/// Screenshot to take.
struct Screenshot {
    path: PathBuf,
    /// Frames shown since the view settled.
    settled: u32,
}

/// Frames until slowly opening parts of the window are open.
const SETTLED: u32 = 20;

impl eframe::App for Window {
    fn clear_color(&self, visuals: &Visuals) -> [f32; 4] {
        background(visuals.dark_mode).to_normalized_gamma_f32()
    }

    fn logic(&mut self, _context: &Context, _frame: &mut eframe::Frame) {
        if let Some(surface) = &mut self.surface {
            surface.resume();
        }
    }

    fn ui(&mut self, ui: &mut Ui, frame: &mut eframe::Frame) {
        self.stop_if_asked(ui.ctx());
        self.viewer.show(ui);
        self.take_screenshot(ui.ctx());
        let mended = self.surface.as_mut().map(|surface| surface.mend(frame, ui.ctx()));
        if let Some(Err(error)) = mended {
            self.viewer.give_up();
            end(&self.outcome, ui.ctx(), Err(error));
        }
    }

    fn on_exit(&mut self) {
        // Nobody waits for pictures that are being made, or for files that are being opened or exported.
        stop::ask();
    }
}

/// Colour of panels.
fn background(is_dark: bool) -> Color32 {
    let visuals = if is_dark { Visuals::dark() } else { Visuals::light() };
    visuals.panel_fill
}

/// Makes panels transparent, so that clearing the window paints them; this saves time with software rendering.
fn leave_panels_clear(context: &Context) {
    context.all_styles_mut(|style| style.visuals.panel_fill = Color32::TRANSPARENT);
}

impl Window {
    /// After a signal keeps unsaved work for the next start, and closes the window without a question.
    fn stop_if_asked(&mut self, context: &Context) {
        if stop::asked() && !self.is_stopped {
            self.is_stopped = true;
            self.viewer.give_up();
            end(
                &self.outcome,
                context,
                Err(anyhow!("interrupted; unsaved work, if any, is offered at the next start")),
            );
        }
    }

    /// Takes the requested screenshot once the view has settled.
    fn take_screenshot(&mut self, context: &Context) {
        let Some(screenshot) = &mut self.screenshot else { return };
        if let Some(failure) = self.viewer.failure() {
            return end(&self.outcome, context, Err(anyhow!("{failure}; no picture was taken")));
        }
        screenshot.settled = if self.viewer.is_settled() { screenshot.settled + 1 } else { 0 };
        if screenshot.settled == SETTLED {
            let (path, outcome, wake) = (screenshot.path.clone(), Arc::clone(&self.outcome), context.clone());
            let callback =
                ScreenshotCallback::new(move |picture| end(&outcome, &wake, write(&path, &picture)));
            context.send_viewport_cmd(ViewportCommand::Screenshot(callback));
        }
        context.request_repaint();
    }
}

/// Closes the window of `context` with the result `why`.
fn end(outcome: &Outcome, context: &Context, why: Result<()>) {
    *outcome.lock().expect("nobody panics with it") = Some(why);
    context.send_viewport_cmd(ViewportCommand::Close);
}

fn write(path: &Path, picture: &ColorImage) -> Result<()> {
    let [width, height] = picture.size.map(|side| u32::try_from(side).unwrap_or(u32::MAX));
    let colour = |pixel: &Color32| pixel.to_array().map(|c| f32::from(c) / 255.0);
    let pixels = picture.pixels.iter().map(colour).collect();
    let frame = Frame::from_pixels(FrameSize::new(width, height)?, pixels)?;
    kept::check(path, |_| false)?;
    Ok(image::write_png(path, &frame, Alpha::Drop)?)
}

fn show(arguments: Arguments) -> Result<()> {
    let [width, height] = <[u32; 2]>::from(arguments.window_size).map(|side| side as f32);
    let mut options = eframe::NativeOptions {
        viewport: ViewportBuilder::default()
            .with_title("FoVolNet")
            .with_app_id("fovolnet")
            .with_inner_size([width, height])
            .with_min_inner_size([480.0, 320.0])
            .with_drag_and_drop(true),
        ..Default::default()
    };
    // Queued frames would add latency.
    options.wgpu_options.surface = SurfaceConfig::LOW_LATENCY;
    let device = arguments.speed.device();
    let checks = Checks::of_environment()?;
    options.wgpu_options = Screen::configure(&device, checks, options.wgpu_options);
    let mut start = Start {
        source: arguments.volume,
        read: arguments.read,
        render: arguments.render,
        speed: arguments.speed,
        screen: None,
        painter: None,
    };
    let outcome = Outcome::default();
    let told = Arc::clone(&outcome);
    let wants_screenshot = arguments.screenshot.is_some();
    // Scripted screenshots must not depend on the user's preferences.
    let places = if wants_screenshot { Places::in_folder(None) } else { Places::of_user() };
    let window = move |creation: &eframe::CreationContext<'_>| {
        if let Some(scale) = arguments.scale {
            creation.egui_ctx.set_pixels_per_point(scale);
        }
        leave_panels_clear(&creation.egui_ctx);
        let window = creation.egui_ctx.clone();
        signals::listen(move || window.request_repaint());
        drawing_threads::spread();
        let state = creation.wgpu_render_state.as_ref();
        start.painter = state.map(Painter::of_window);
        start.screen = state.and_then(|state| Screen::of_window(state, &device, checks));
        let surface = start.screen.as_ref().map(|screen| Surface::of_window(screen, &creation.egui_ctx));
        let mut viewer = Viewer::new(&creation.egui_ctx, start, places)?;
        if let Some(theme) = arguments.theme {
            viewer.set_dark(theme == Theme::Dark);
        }
        let screenshot = arguments.screenshot.map(|path| Screenshot { path, settled: 0 });
        let window = Window { surface, viewer, screenshot, outcome: told, is_stopped: false };
        Ok(Box::new(window) as Box<dyn eframe::App>)
    };
    eframe::run_native("fovolnet", options, Box::new(window))
        .map_err(|error| anyhow!(no_window::explained(&error)))?;
    match outcome.lock().expect("nobody panics with it").take() {
        Some(outcome) => outcome,
        None if wants_screenshot => {
            bail!("the window was closed before the view was complete; no picture was taken")
        }
        None => Ok(()),
    }
}

/// Runs the command with `arguments`, the first of which is the program, and returns the exit status.
///
/// It is meant for the first thread of a process of its own: it opens the window, and listens to signals.
pub fn run(arguments: impl IntoIterator<Item = OsString>) -> u8 {
    fovolnet::keep_freed_memory();
    memory::before_exit(temporaries::remove_all);
    let arguments = match Arguments::try_parse_from(arguments) {
        Ok(arguments) => arguments,
        Err(error) if !error.use_stderr() => {
            print!("{error}");
            return 0;
        }
        Err(error) => {
            eprintln!("error: {}; see `fovolnet-viewer --help`", fovolnet::usage_line(&error));
            return 2;
        }
    };
    let result = show(arguments);
    // Exports may still be written on threads of their own.
    signals::leave_nothing();
    match result {
        Ok(()) => 0,
        Err(error) => {
            signals::said();
            eprintln!("error: {}", fovolnet::one_line(error.as_ref()));
            1
        }
    }
}

use crate::boundary::{call, long_call, repaired};
use crate::camera::FovolnetCamera;
use crate::committed::Committed;
use crate::frame::FovolnetFrame;
use crate::handles::{hand_out, object, release, shared};
use crate::light::FovolnetLight;
use crate::pointers::{put, put_text, text};
use crate::render_flags::RenderFlags;
use crate::status::{Failure, FovolnetStatus};
use crate::transfer_function::FovolnetTransferFunction;
use crate::volume::FovolnetVolume;
use fovolnet::core::FrameSize;
use fovolnet::{CameraChoice, Engine, Wanted};
use std::ffi::c_char;
use std::sync::{Arc, Mutex, PoisonError};

/// A renderer: settings, and what is shown with them. Frames of one renderer are made one after another, for networks remember
/// earlier ones.
pub struct FovolnetRenderer {
    parameters: Committed<Parameters>,
    engine: Mutex<Engine>,
}

/// Parameters of a renderer, pending or committed.
#[derive(Clone, Default)]
struct Parameters {
    flags: RenderFlags,
    volume: Option<Arc<FovolnetVolume>>,
    transfer_function: Option<Arc<FovolnetTransferFunction>>,
    camera: Option<Arc<FovolnetCamera>>,
    light: Option<Arc<FovolnetLight>>,
    finds_motion: bool,
}

impl Parameters {
    /// Everything that frames depend on, with the objects as they are committed now.
    fn wanted(&self) -> Result<Wanted, Failure> {
        let volume = self.volume.as_ref().ok_or_else(|| {
            Failure::invalid("the renderer has no volume; call fovolnet_renderer_set_volume, then commit")
        })?;
        let given = &self.flags.pictures;
        let mut settings = given.resolve()?;
        if let Some(function) = &self.transfer_function {
            settings.transfer_function = function.choice()?;
        }
        if let Some(camera) = &self.camera {
            let camera = camera.camera()?;
            (settings.camera, settings.projection) = (CameraChoice::Still(camera), camera.projection);
        }
        if let Some(light) = &self.light {
            settings.light = light.light()?;
        }
        let planning = given.limit()?.map(|limit| (limit, given.freedom()));
        let (speed, finds_motion) = (self.flags.speed.clone(), self.finds_motion);
        Ok(Wanted { volume: volume.opened()?, settings, speed, planning, finds_motion })
    }
}

impl FovolnetRenderer {
    /// Runs `work` on the engine, which is made anew if the work was abandoned.
    fn with<T>(&self, work: impl FnOnce(&mut Engine, Wanted) -> Result<T, Failure>) -> Result<T, Failure> {
        let wanted = self.parameters.committed("renderer")?.wanted()?;
        let mut engine = self.engine.lock().unwrap_or_else(PoisonError::into_inner);
        repaired(&mut *engine, |engine| work(engine, wanted), Engine::abandon)
    }
}

/// The function that makes renderers.
const MAKER: &str = "fovolnet_renderer_new";

/// The renderer behind `handle`.
///
/// # Safety
/// `handle` is null, or was handed out and not released.
unsafe fn of<'a>(handle: *const FovolnetRenderer) -> Result<&'a FovolnetRenderer, Failure> {
    // SAFETY: the caller promises it.
    unsafe { object(handle, "renderer", MAKER) }
}

/// Lets the pending parameters of `renderer` keep the object behind `handle`, or none for null, by `put`.
///
/// # Safety
/// Both handles are null, or were handed out and not released.
unsafe fn keep<T>(
    renderer: *mut FovolnetRenderer,
    handle: *const T,
    put: impl FnOnce(&mut Parameters, Option<Arc<T>>),
) -> FovolnetStatus {
    call(|| {
        // SAFETY: the caller promises it.
        let (renderer, object) = unsafe { (of(renderer)?, shared(handle)) };
        renderer.parameters.set(|pending| {
            put(pending, object);
            Ok(())
        })
    })
}

/// Makes a renderer with the defaults of the command line. Give the handle to fovolnet_renderer_release in the end.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fovolnet_renderer_new(renderer: *mut *mut FovolnetRenderer) -> FovolnetStatus {
    call(|| {
        let made = FovolnetRenderer { parameters: Committed::default(), engine: Mutex::default() };
        // SAFETY: see the rules at the top of the header.
        unsafe { hand_out(made, renderer, "renderer") }
    })
}

/// Gives the handle back. NULL is fine; a handle that was released must not be used again. Frames of the renderer stay.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fovolnet_renderer_release(renderer: *mut FovolnetRenderer) {
    // SAFETY: see the rules at the top of the header.
    unsafe { release(renderer) }
}

/// Sets a flag of the command line by its name and its value, such as "shadow-rays" and "16", or "clip" and "0,0.5,0,1,0,1".
/// `fovolnet render --help` lists all of them: those of pictures, and of speed "device", "threads", "filtering" and "no-skip".
/// Flags without a value take "true" and "false". A flag that may be given several times is set once; fovolnet_renderer_set_json
/// takes lists.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fovolnet_renderer_set(
    renderer: *mut FovolnetRenderer,
    name: *const c_char,
    value: *const c_char,
) -> FovolnetStatus {
    call(|| {
        // SAFETY: see the rules at the top of the header.
        let (name, value) = unsafe { (text(name, "name")?, text(value, "value")?) };
        // SAFETY: likewise.
        unsafe { of(renderer)? }.parameters.set(|pending| pending.flags.set(name, value))
    })
}

/// Sets all flags in a JSON object, such as {"size": [640, 480], "shadows": "off", "step": 0.5}. Texts are read as the command line
/// reads them. Null takes a flag back. An error changes nothing.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fovolnet_renderer_set_json(
    renderer: *mut FovolnetRenderer,
    json: *const c_char,
) -> FovolnetStatus {
    call(|| {
        // SAFETY: see the rules at the top of the header.
        let json = unsafe { text(json, "json")? };
        // SAFETY: likewise.
        unsafe { of(renderer)? }.parameters.set(|pending| pending.flags.set_json(json))
    })
}

/// Takes a flag back, so that its default holds.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fovolnet_renderer_unset(
    renderer: *mut FovolnetRenderer,
    name: *const c_char,
) -> FovolnetStatus {
    call(|| {
        // SAFETY: see the rules at the top of the header.
        let name = unsafe { text(name, "name")? };
        // SAFETY: likewise.
        unsafe { of(renderer)? }.parameters.set(|pending| pending.flags.unset(name))
    })
}

/// Writes the flags that are set, as a JSON object. Texts: see the top of the header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fovolnet_renderer_settings(
    renderer: *const FovolnetRenderer,
    text: *mut c_char,
    capacity: usize,
    length: *mut usize,
) -> FovolnetStatus {
    call(|| {
        // SAFETY: see the rules at the top of the header.
        let json = unsafe { of(renderer)? }.parameters.pending().flags.json()?;
        // SAFETY: likewise.
        unsafe { put_text(&json, text, capacity, length) }
    })
}

/// Sets width and height of frames in pixels, 1 to 32768 each. It is the flag "size".
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fovolnet_renderer_set_size(
    renderer: *mut FovolnetRenderer,
    width: u32,
    height: u32,
) -> FovolnetStatus {
    call(|| {
        let size = FrameSize::new(width, height)?;
        // SAFETY: see the rules at the top of the header.
        unsafe { of(renderer)? }.parameters.set(|pending| {
            pending.flags.pictures.size = Some(size);
            Ok(())
        })
    })
}

/// Sets the volume to show; NULL for none. The renderer keeps it, so its handle may be released.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fovolnet_renderer_set_volume(
    renderer: *mut FovolnetRenderer,
    volume: *const FovolnetVolume,
) -> FovolnetStatus {
    // SAFETY: see the rules at the top of the header.
    unsafe { keep(renderer, volume, |pending, volume| pending.volume = volume) }
}

/// Sets the transfer function; NULL for that of the flag "tf". The renderer keeps it, so its handle may be released.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fovolnet_renderer_set_transfer_function(
    renderer: *mut FovolnetRenderer,
    transfer_function: *const FovolnetTransferFunction,
) -> FovolnetStatus {
    // SAFETY: see the rules at the top of the header.
    unsafe {
        keep(renderer, transfer_function, |pending, transfer_function| {
            pending.transfer_function = transfer_function;
        })
    }
}

/// Sets the camera; NULL for that of the flags "camera", "path", "view", "turn" and "projection". The renderer keeps it, so its
/// handle may be released.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fovolnet_renderer_set_camera(
    renderer: *mut FovolnetRenderer,
    camera: *const FovolnetCamera,
) -> FovolnetStatus {
    // SAFETY: see the rules at the top of the header.
    unsafe { keep(renderer, camera, |pending, camera| pending.camera = camera) }
}

/// Sets the light; NULL for that of the flag "light". The renderer keeps it, so its handle may be released.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fovolnet_renderer_set_light(
    renderer: *mut FovolnetRenderer,
    light: *const FovolnetLight,
) -> FovolnetStatus {
    // SAFETY: see the rules at the top of the header.
    unsafe { keep(renderer, light, |pending, light| pending.light = light) }
}

/// Sets whether sparse frames have motion even if no network uses it: 0 or 1. Frames with every pixel marched never have it.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fovolnet_renderer_find_motion(
    renderer: *mut FovolnetRenderer,
    finds_motion: u32,
) -> FovolnetStatus {
    call(|| {
        // SAFETY: see the rules at the top of the header.
        unsafe { of(renderer)? }.parameters.set(|pending| {
            pending.finds_motion = finds_motion != 0;
            Ok(())
        })
    })
}

/// Checks the pending flags, and uses them from the next frame on. Files of paths and gaze are read here. After an error the flags of
/// the last commit stay.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fovolnet_renderer_commit(renderer: *mut FovolnetRenderer) -> FovolnetStatus {
    call(|| {
        // SAFETY: see the rules at the top of the header.
        let renderer = unsafe { of(renderer)? };
        let pending = renderer.parameters.pending();
        pending.flags.pictures.check_flags()?;
        pending.flags.pictures.resolve()?;
        renderer.parameters.commit(pending);
        Ok(())
    })
}

/// Renders frame `i` with all objects as they are committed now. Noise, paths and gaze follow `i`; networks take the frame for the
/// successor of the last one. The first frame prepares the volume. Give `frame` to fovolnet_frame_release in the end. May take
/// long; fovolnet_cancel ends it.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fovolnet_renderer_render(
    renderer: *mut FovolnetRenderer,
    i: u32,
    frame: *mut *mut FovolnetFrame,
) -> FovolnetStatus {
    long_call(|| {
        // SAFETY: see the rules at the top of the header.
        let rendered = unsafe { of(renderer)? }.with(|engine, wanted| Ok(engine.render(wanted, i)?))?;
        // SAFETY: likewise.
        unsafe { hand_out(FovolnetFrame(rendered), frame, "frame") }
    })
}

/// Renders frame `i` with every pixel marched and exact shadows, to compare with. Networks do not notice it. Give `frame` to
/// fovolnet_frame_release in the end. May take long; fovolnet_cancel ends it.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fovolnet_renderer_reference(
    renderer: *mut FovolnetRenderer,
    i: u32,
    frame: *mut *mut FovolnetFrame,
) -> FovolnetStatus {
    long_call(|| {
        // SAFETY: see the rules at the top of the header.
        let rendered = unsafe { of(renderer)? }.with(|engine, wanted| Ok(engine.reference(wanted, i)?))?;
        // SAFETY: likewise.
        unsafe { hand_out(FovolnetFrame(rendered), frame, "frame") }
    })
}

/// Forgets earlier frames, as after a cut.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fovolnet_renderer_reset(renderer: *mut FovolnetRenderer) -> FovolnetStatus {
    call(|| {
        // SAFETY: see the rules at the top of the header.
        unsafe { of(renderer)? }.engine.lock().unwrap_or_else(PoisonError::into_inner).reset();
        Ok(())
    })
}

/// Writes the camera of frame `i` as numbers: eye, target and up, three each, and the vertical field of view in degrees. Any of the
/// four may be NULL. Prepares the volume if no frame has done so.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fovolnet_renderer_camera(
    renderer: *mut FovolnetRenderer,
    i: u32,
    eye: *mut f64,
    target: *mut f64,
    up: *mut f64,
    fovy: *mut f64,
) -> FovolnetStatus {
    long_call(|| {
        // SAFETY: see the rules at the top of the header.
        let renderer = unsafe { of(renderer)? };
        let camera = renderer.with(|engine, wanted| Ok(engine.pipeline(wanted)?.camera(i)))?;
        let high = camera.upright.transpose() * glam::DVec3::Y;
        for (at, vector) in [(eye, camera.eye), (target, camera.target), (up, high)] {
            if !at.is_null() {
                // SAFETY: likewise.
                unsafe { put(at.cast(), vector.to_array(), "vector")? };
            }
        }
        // SAFETY: likewise.
        if fovy.is_null() { Ok(()) } else { unsafe { put(fovy, camera.fovy, "fovy") } }
    })
}

/// Writes what was assumed or replaced for the frames: one line each. Prepares the volume if no frame has done so. Texts: see the top
/// of the header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fovolnet_renderer_notes(
    renderer: *mut FovolnetRenderer,
    text: *mut c_char,
    capacity: usize,
    length: *mut usize,
) -> FovolnetStatus {
    long_call(|| {
        // SAFETY: see the rules at the top of the header.
        let renderer = unsafe { of(renderer)? };
        let notes = renderer.with(|engine, wanted| Ok(engine.pipeline(wanted)?.notes().join("\n")))?;
        // SAFETY: likewise.
        unsafe { put_text(&notes, text, capacity, length) }
    })
}

/// Writes the name of the graphics processor that renders; an empty text where the processor does. Prepares the volume if no frame
/// has done so. Texts: see the top of the header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fovolnet_renderer_gpu(
    renderer: *mut FovolnetRenderer,
    text: *mut c_char,
    capacity: usize,
    length: *mut usize,
) -> FovolnetStatus {
    long_call(|| {
        // SAFETY: see the rules at the top of the header.
        let renderer = unsafe { of(renderer)? };
        let gpu = renderer.with(|engine, wanted| Ok(engine.pipeline(wanted)?.machine().gpu))?;
        // SAFETY: likewise.
        unsafe { put_text(&gpu.unwrap_or_default(), text, capacity, length) }
    })
}

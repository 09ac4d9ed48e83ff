use crate::motion::motion;
use crate::{
    Error, Machine, OpenVolume, Reconstructor, RenderSettings, Result, Sampling, SpeedSettings, presets,
    toml_file,
};
use fovol_core::{
    Camera, CameraPath, Fovea, Frame, FrameSize, GazePath, Keyframe, Light, SampleList, SampleMask, Scene,
    Shading, ShadowMode,
};
use fovol_render::cpu::march::Marched;
use fovol_render::cpu::{self, RenderOptions, Renderer, Simd, compact, direct, mask_of, scatter};
use fovol_render::noise::Noise;
use glam::DVec3;
use serde::{Deserialize, Serialize};
use std::time::Instant;

/// Milliseconds that the parts of a frame took; 0 for what did not run.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct Timings {
    /// Mask and compaction, or drawing positions.
    pub mask: f64,
    /// Marching and scatter.
    pub march: f64,
    /// Filling.
    pub reconstruct: f64,
    /// All of it.
    pub total: f64,
}

/// One frame, and what led to it.
#[derive(Debug, Clone)]
pub struct RenderedFrame {
    /// Its number.
    pub index: u32,
    /// What was sampled: alpha 1 there, transparent black elsewhere.
    pub sparse: Frame,
    /// Which pixels were sampled.
    pub mask: SampleMask,
    /// The full frame; the sparse one where reconstruction is off.
    pub frame: Frame,
    /// For each pixel the way to where it was in the last frame, see [`motion()`]; found where a network uses it or
    /// [`Pipeline::find_motion`] asked for it, from the second frame on.
    pub motion: Option<Vec<[f32; 2]>>,
    /// How many pixels were marched, repeated ones included.
    pub samples: usize,
    /// How many of them repeated others, where positions were drawn.
    pub lost: Option<usize>,
    /// How long it took.
    pub timings: Timings,
}

/// Mask, march and reconstruction of frame after frame.
#[derive(Debug)]
pub struct Pipeline {
    renderer: Renderer,
    noise: Noise,
    size: FrameSize,
    sampling: Sampling,
    reconstructor: Reconstructor,
    /// Where the last frame was seen from.
    last_camera: Option<Camera>,
    finds_motion: bool,
    fovea: Fovea,
    gaze: GazePath,
    path: CameraPath,
    seed: u64,
    threads: rayon::ThreadPool,
}

impl Pipeline {
    /// Prepares `volume` for rendering as `settings` say.
    ///
    /// # Errors
    /// Settings that cannot be rendered with, files that they name and that cannot be read.
    pub fn new(volume: &OpenVolume, settings: &RenderSettings, speed: &SpeedSettings) -> Result<Self> {
        let threads =
            rayon::ThreadPoolBuilder::new().num_threads(speed.threads.unwrap_or(0)).build().map_err(|e| {
                Error::Setting(format!("cannot start the threads ({e}); give a smaller --threads"))
            })?;
        let scene = scene(volume, settings)?;
        let fovea = settings.base_fovea()?;
        let options =
            RenderOptions { simd: speed.simd.unwrap_or_else(Simd::best), skip_empty: !speed.no_skip };
        let renderer = threads.install(|| Renderer::new(&scene, options))?;
        let seed = settings.seed.unwrap_or(0);
        Ok(Self {
            renderer,
            noise: Noise::new(settings.noise.unwrap_or_default(), seed),
            size: settings.frame_size(),
            sampling: settings.sampling(),
            reconstructor: Reconstructor::new(settings, settings.frame_size())?,
            last_camera: None,
            finds_motion: false,
            fovea,
            gaze: settings.gaze_path()?,
            path: camera_path(settings)?,
            seed,
            threads,
        })
    }

    /// The size of the frames.
    pub fn size(&self) -> FrameSize {
        self.size
    }

    /// The prepared scene.
    pub fn renderer(&self) -> &Renderer {
        &self.renderer
    }

    /// The prepared scene, to change.
    pub fn renderer_mut(&mut self) -> &mut Renderer {
        &mut self.renderer
    }

    /// This machine as it is used here.
    pub fn machine(&self) -> Machine {
        Machine::this(self.threads.current_num_threads(), self.renderer.options().simd)
    }

    /// The camera of frame `i`.
    pub fn camera(&self, i: u32) -> Camera {
        self.path.camera(i)
    }

    /// The fovea of frame `i`.
    pub fn fovea(&self, i: u32) -> Fovea {
        Fovea { gaze: self.gaze.gaze(i), ..self.fovea }
    }

    /// Frame `i` with every pixel marched.
    pub fn reference(&self, i: u32) -> Frame {
        self.threads.install(|| self.renderer.march_full(&self.camera(i), self.size).0)
    }

    /// Frame `i`. Networks take it for the one after the last that was rendered; see [`Self::reset`].
    ///
    /// # Errors
    /// A network that cannot go on.
    pub fn render(&mut self, i: u32) -> Result<RenderedFrame> {
        let started = Instant::now();
        let camera = self.camera(i);
        let sampled = self.threads.install(|| self.sample(i, &camera));
        let before = Instant::now();
        // Every pixel is there already where all were marched.
        let reconstructs = self.sampling != Sampling::Full && self.reconstructor.is_active();
        let last_camera = self.last_camera.replace(camera);
        let (threads, reconstructor) = (&self.threads, &mut self.reconstructor);
        let moves = self.finds_motion || (reconstructs && reconstructor.uses_motion());
        let motion = last_camera
            .filter(|_| moves)
            .map(|last| threads.install(|| motion(&sampled.list, &sampled.marched, &camera, &last)));
        let frame = match reconstructs {
            true => threads.install(|| reconstructor.reconstruct(&sampled.sparse, motion.as_deref()))?,
            false => sampled.sparse.clone(),
        };
        let timings = Timings {
            mask: sampled.mask_ms,
            march: sampled.march_ms,
            reconstruct: if reconstructs { since(before) } else { 0.0 },
            total: since(started),
        };
        Ok(RenderedFrame {
            index: i,
            sparse: sampled.sparse,
            mask: sampled.mask,
            frame,
            motion,
            samples: if self.sampling == Sampling::Full { self.size.pixels() } else { sampled.list.len() },
            lost: sampled.lost,
            timings,
        })
    }

    /// From now on finds motion also where no network uses it; not where every pixel is marched.
    pub fn find_motion(&mut self) {
        self.finds_motion = true;
    }

    /// Forgets the frames so far, as after a cut.
    pub fn reset(&mut self) {
        self.reconstructor.reset();
        self.last_camera = None;
    }

    fn sample(&self, i: u32, camera: &Camera) -> Sampled {
        let started = Instant::now();
        if self.sampling == Sampling::Full {
            let (sparse, _) = self.renderer.march_full(camera, self.size);
            let mask = SampleMask::full(self.size);
            let march_ms = since(started);
            let list = SampleList::new(self.size, Vec::new());
            return Sampled { sparse, list, marched: Vec::new(), mask, lost: None, mask_ms: 0.0, march_ms };
        }
        let chosen = self.choose(i);
        let mask_ms = since(started);
        let before = Instant::now();
        let (list, marched, mask, lost) = match chosen {
            Chosen::Mask(mask) => {
                let (list, marched, _) = self.renderer.march_rejecting(camera, &mask);
                (list, marched, Some(mask), None)
            }
            Chosen::List(list, mask, lost) => {
                let (marched, _) = self.renderer.march_list(camera, &list);
                (list, marched, mask, lost)
            }
        };
        let sparse = scatter(&list, &marched);
        let march_ms = since(before);
        let mask = mask.unwrap_or_else(|| mask_of(&list));
        Sampled { sparse, list, marched, mask, lost, mask_ms, march_ms }
    }

    /// Which pixels of frame `i` are marched.
    fn choose(&self, i: u32) -> Chosen {
        let fovea = self.fovea(i);
        if self.sampling == Sampling::Direct {
            let drawn = direct(&fovea, self.size, self.seed, i);
            return Chosen::List(drawn.list, None, Some(drawn.lost));
        }
        let mask = cpu::mask(&fovea, self.size, &self.noise, i);
        match self.sampling {
            Sampling::Reject => Chosen::Mask(mask),
            _ => Chosen::List(compact(&mask), Some(mask), None),
        }
    }
}

/// Pixels to march.
enum Chosen {
    /// Walked over.
    Mask(SampleMask),
    /// Packed, with the mask they came from, or how many repeat others where they were drawn.
    List(SampleList, Option<SampleMask>, Option<usize>),
}

struct Sampled {
    sparse: Frame,
    /// The pixels that were marched and what their rays brought back; empty where all were.
    list: SampleList,
    marched: Vec<Marched>,
    mask: SampleMask,
    lost: Option<usize>,
    mask_ms: f64,
    march_ms: f64,
}

fn since(start: Instant) -> f64 {
    start.elapsed().as_secs_f64() * 1e3
}

/// The scene that `settings` describe around `volume`.
fn scene(volume: &OpenVolume, settings: &RenderSettings) -> Result<Scene> {
    let transfer = presets::find(settings.tf.as_deref().unwrap_or("auto"), volume)?;
    let mut scene = Scene::new(volume.volume.clone(), transfer);
    let defaults = Shading::default();
    scene.shading = Shading {
        light: settings
            .light
            .map(|l| Light::towards(DVec3::from_array(l)))
            .transpose()?
            .unwrap_or(defaults.light),
        ambient: settings.ambient.unwrap_or(defaults.ambient),
        shadows: settings.shadows.unwrap_or(ShadowMode::On),
        surface: settings.shading.unwrap_or_default(),
    };
    scene.background = settings.background.unwrap_or(scene.background);
    scene.step = settings.step.unwrap_or(scene.step);
    scene.check()?;
    Ok(scene)
}

fn camera_path(settings: &RenderSettings) -> Result<CameraPath> {
    if let Some([ex, ey, ez, tx, ty, tz, fovy]) = settings.camera {
        let camera = Camera::new(DVec3::new(ex, ey, ez), DVec3::new(tx, ty, tz), fovy)?;
        return Ok(CameraPath::Still(camera));
    }
    match settings.path.as_deref().unwrap_or("orbit") {
        "orbit" => Ok(CameraPath::Orbit),
        "flythrough" => Ok(CameraPath::Flythrough),
        file => {
            #[derive(Deserialize)]
            struct Keyframes {
                keyframe: Vec<Keyframe>,
            }
            let read: Keyframes = toml_file::read(
                file,
                "--path",
                "orbit, flythrough, or a TOML file of [[keyframe]] tables with frame, eye, target and fovy",
            )?;
            Ok(CameraPath::through(read.keyframe)?)
        }
    }
}

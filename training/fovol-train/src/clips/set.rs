use super::recipe::{Recipe, VolumeSource};
use super::{Clip, record};
use crate::{Error, Result};
use fovolnet::{OpenDevice, OpenVolume};
use serde::{Deserialize, Serialize};
use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::fs;
use std::path::{Path, PathBuf};

/// A folder of clips with a list of their recipes.
#[derive(Debug, Clone)]
pub struct ClipSet {
    folder: PathBuf,
    recipes: Vec<Recipe>,
}

/// Content of `clips.json`.
#[derive(Serialize, Deserialize)]
struct List {
    recipes: Vec<Recipe>,
}

/// File name of the list.
const LIST: &str = "clips.json";

impl ClipSet {
    /// Plans `count` clips in `folder`, cycling through `sources`, with seeds from `first_seed` on. [`Self::make`]
    /// renders them.
    pub fn plan(folder: &Path, sources: &[VolumeSource], count: usize, first_seed: u64) -> Self {
        let volumes = sources.len().max(1);
        let recipes = (0..count).filter_map(|i| {
            // Cycling shows every volume even in an incomplete set.
            let source = sources.get(i % volumes)?;
            Some(Recipe::draw(first_seed + i as u64, source))
        });
        Self { folder: folder.to_owned(), recipes: recipes.collect() }
    }

    /// Plans `count` clips in `folder` that follow a fly-through around each volume of `sources` without gaps.
    pub fn fly_throughs(folder: &Path, sources: &[VolumeSource], count: usize, first_seed: u64) -> Self {
        let volumes = sources.len().max(1);
        let recipes = (0..count).filter_map(|i| {
            let source = sources.get(i % volumes)?;
            Some(Recipe::fly_through(first_seed + i as u64, source, i / volumes))
        });
        Self { folder: folder.to_owned(), recipes: recipes.collect() }
    }

    /// Opens the set in `folder` with the clips made so far.
    ///
    /// # Errors
    /// The folder has no list, or the list cannot be read.
    pub fn open(folder: &Path) -> Result<Self> {
        let path = folder.join(LIST);
        let text = fs::read_to_string(&path).map_err(|e| Error::file("read", &path, &e))?;
        let list: List = serde_json::from_str(&text)
            .map_err(|e| Error::Clip(format!("{}: it is no list of clips ({e})", path.display())))?;
        Ok(Self { folder: folder.to_owned(), recipes: list.recipes }.made())
    }

    /// Drops recipes whose clips have not been made.
    #[must_use]
    pub fn made(self) -> Self {
        let made = self.recipes.iter().filter(|recipe| self.path(recipe).is_file()).cloned().collect();
        Self { recipes: made, ..self }
    }

    /// Number of clips.
    pub fn len(&self) -> usize {
        self.recipes.len()
    }

    /// Whether the set has no clips.
    pub fn is_empty(&self) -> bool {
        self.recipes.is_empty()
    }

    /// Recipe of clip `i`.
    pub fn recipe(&self, i: usize) -> &Recipe {
        &self.recipes[i]
    }

    /// Reads clip `i`.
    ///
    /// # Errors
    /// The file cannot be read.
    pub fn clip(&self, i: usize) -> Result<Clip> {
        Clip::read(&self.path(&self.recipes[i]))
    }

    /// Renders the missing clips on `device`.
    ///
    /// `progress` receives the number of clips done and returns whether to go on. The result lists exceptions:
    /// volumes that were left out because nothing is visible, and why clips were rendered on the CPU instead of a
    /// GPU.
    ///
    /// # Errors
    /// Volumes that cannot be read or rendered, files that cannot be written.
    pub fn make(&self, device: &OpenDevice, mut progress: impl FnMut(usize) -> bool) -> Result<Exceptions> {
        fs::create_dir_all(&self.folder).map_err(|e| Error::file("make", &self.folder, &e))?;
        let list = serde_json::to_string(&List { recipes: self.recipes.clone() });
        let path = self.folder.join(LIST);
        fs::write(&path, list.map_err(|e| Error::Clip(e.to_string()))?)
            .map_err(|e| Error::file("write", &path, &e))?;
        let mut open: HashMap<VolumeSource, OpenVolume> = HashMap::new();
        let Exceptions { mut left_out, mut on_processor } = Exceptions::default();
        for (i, recipe) in self.recipes.iter().enumerate() {
            if !progress(i) {
                break;
            }
            let path = self.path(recipe);
            if path.is_file() || left_out.contains(&recipe.source.to_string()) {
                continue;
            }
            let volume = match open.entry(recipe.source.clone()) {
                Entry::Occupied(open) => open.into_mut(),
                Entry::Vacant(closed) => closed.insert(recipe.source.open()?),
            };
            match recorded(recipe, volume, device, &mut on_processor) {
                Ok(clip) => clip.write(&path)?,
                Err(Error::Clip(_)) => left_out.push(recipe.source.to_string()),
                Err(error) => return Err(error),
            }
        }
        Ok(Exceptions { left_out, on_processor })
    }

    fn path(&self, recipe: &Recipe) -> PathBuf {
        self.folder.join(format!("clip_{:06}.zst", recipe.seed))
    }
}

/// Deviations from the plan while clips were made.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Exceptions {
    /// Volumes that were left out because nothing of them is visible.
    pub left_out: Vec<String>,
    /// Why a clip was rendered on the CPU instead of the GPU; the first such reason.
    pub on_processor: Option<String>,
}

/// Renders a clip on `device`. If the GPU fails, the reason goes to `on_processor` and the CPU renders the clip.
fn recorded(
    recipe: &Recipe,
    volume: &OpenVolume,
    device: &OpenDevice,
    on_processor: &mut Option<String>,
) -> Result<Clip> {
    match record(recipe, volume, device) {
        Err(Error::Render(error)) if error.is_of_gpu() => {
            on_processor.get_or_insert_with(|| format!("{}: {error}", recipe.source));
            record(recipe, volume, &OpenDevice::Cpu)
        }
        made => made,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fovol_core::CameraPath;

    #[test]
    fn fly_throughs_have_no_gaps() {
        let folder = tempfile::tempdir().unwrap();
        let sources = ["marschner-lobb:16:0", "marschner-lobb:20:1"].map(|s| VolumeSource::parse(s).unwrap());
        let mut set = ClipSet::fly_throughs(folder.path(), &sources, 4, 0);
        set.recipes.iter_mut().for_each(|recipe| *recipe = recipe.clone().with_part(32, 3));
        assert_eq!(set.make(&OpenDevice::Cpu, |_| true).unwrap(), Exceptions::default());
        let open = ClipSet::open(folder.path()).unwrap();
        let cameras: Vec<_> = [0, 2].iter().flat_map(|&i| open.clip(i).unwrap().scenery.cameras).collect();
        assert_eq!(cameras, (0..6).map(|i| CameraPath::Flythrough.camera(i)).collect::<Vec<_>>());
        assert_eq!(open.recipe(2).source, sources[0]);
    }

    #[test]
    fn a_set_goes_on_where_it_stopped() {
        let folder = tempfile::tempdir().unwrap();
        let sources = ["marschner-lobb:16:0", "marschner-lobb:20:1"].map(|s| VolumeSource::parse(s).unwrap());
        let mut set = ClipSet::plan(folder.path(), &sources, 4, 100);
        set.recipes.iter_mut().for_each(|recipe| *recipe = recipe.clone().with_part(16, 2));
        set.make(&OpenDevice::Cpu, |made| made < 2).unwrap();
        assert_eq!(ClipSet::open(folder.path()).unwrap().len(), 2);
        let first = fs::read(set.path(&set.recipes[0])).unwrap();
        set.make(&OpenDevice::Cpu, |_| true).unwrap();
        let open = ClipSet::open(folder.path()).unwrap();
        assert_eq!(open.len(), 4);
        assert_eq!([2, 3].map(|i| open.recipe(i).source.clone()), sources);
        assert_eq!(fs::read(set.path(&set.recipes[0])).unwrap(), first);
        assert_eq!(open.clip(2).unwrap().len(), 2);
    }
}

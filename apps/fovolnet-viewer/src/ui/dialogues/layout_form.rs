//! Form for the layout of raw voxel files.

use eframe::egui::{ComboBox, DragValue, Grid, Ui};
use fovolnet::VolumeSettings;
use fovolnet::core::{Dtype, Endian, MAX_DIM, path_of_text};

/// Form for the layout of a raw voxel file.
#[derive(Debug)]
pub struct LayoutForm {
    source: String,
    bytes: u64,
    dims: [usize; 3],
    dtype: Dtype,
    endian: Endian,
    spacing: [f64; 3],
}

impl LayoutForm {
    /// Form for the file `source`, with initial values from `read`.
    pub fn new(source: &str, read: &VolumeSettings) -> Self {
        let bytes = std::fs::metadata(path_of_text(source)).map_or(0, |file| file.len());
        Self {
            source: source.to_owned(),
            bytes,
            dims: read.dims.unwrap_or_else(|| [cube_root(bytes); 3]),
            dtype: read.dtype.unwrap_or(Dtype::U8),
            endian: read.endian.unwrap_or_default(),
            spacing: read.spacing.unwrap_or([1.0; 3]),
        }
    }

    /// The file.
    pub fn source(&self) -> &str {
        &self.source
    }

    /// Settings for reading the file.
    pub fn settings(&self) -> VolumeSettings {
        VolumeSettings {
            dims: Some(self.dims),
            dtype: Some(self.dtype),
            endian: Some(self.endian),
            spacing: (self.spacing != [1.0; 3]).then_some(self.spacing),
            ..VolumeSettings::default()
        }
    }

    /// Shows the form; returns a problem that prevents reading the file.
    pub fn ui(&mut self, ui: &mut Ui) -> Option<&'static str> {
        ui.heading("How do the voxels lie?");
        ui.label(format!("Nothing says so of {}, of {} bytes.", self.source, self.bytes));
        Grid::new("layout").num_columns(2).spacing([12.0, 6.0]).show(ui, |ui| {
            ui.label("Voxels");
            ui.horizontal(|ui| {
                for (dim, axis) in self.dims.iter_mut().zip(["x ", "y ", "z "]) {
                    ui.add(DragValue::new(dim).range(1..=MAX_DIM).prefix(axis));
                }
            });
            ui.end_row();
            let label = ui.label("Type").id;
            let list =
                ComboBox::from_id_salt("dtype").selected_text(self.dtype.to_string()).show_ui(ui, |ui| {
                    for dtype in Dtype::ALL {
                        ui.selectable_value(&mut self.dtype, dtype, dtype.to_string());
                    }
                });
            list.response.labelled_by(label);
            ui.end_row();
            ui.label("Bytes");
            ui.horizontal(|ui| {
                ui.selectable_value(&mut self.endian, Endian::Little, "little end first");
                ui.selectable_value(&mut self.endian, Endian::Big, "big end first");
            });
            ui.end_row();
            ui.label("Spacing");
            ui.horizontal(|ui| {
                for (spacing, axis) in self.spacing.iter_mut().zip(["x ", "y ", "z "]) {
                    ui.add(DragValue::new(spacing).range(1e-6..=1e6).speed(0.01).prefix(axis));
                }
            });
            ui.end_row();
        });
        let needed = self.needed();
        ui.label(format!("These need {needed} bytes."));
        (needed > u128::from(self.bytes) && !self.source.ends_with(".gz"))
            .then_some("The file is too small for that.")
    }

    fn needed(&self) -> u128 {
        self.dims.iter().map(|&dim| dim as u128).product::<u128>() * self.dtype.size() as u128
    }
}

/// Side of a cube of `bytes` voxels.
fn cube_root(bytes: u64) -> usize {
    ((bytes as f64).cbrt().round() as usize).clamp(1, MAX_DIM)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cube_of_bytes_is_guessed() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("some.raw");
        std::fs::write(&path, vec![0u8; 27_000]).unwrap();
        let form = LayoutForm::new(path.to_str().unwrap(), &VolumeSettings::default());
        assert_eq!(form.settings().dims, Some([30; 3]));
        assert_eq!(form.needed(), 27_000);
    }
}

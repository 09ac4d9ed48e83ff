//! Classic NetCDF files: CDF-1, CDF-2 and CDF-5. NetCDF-4 files are HDF5.

mod header;
mod records;

use super::array_axes::{ArrayAxes, likeliest};
use super::cf::{Coordinate, Described, Spaced, auxiliary, unpacked, with_spacing_notes};
use super::hdf5::unsigned;
use super::layout::Layout;
use super::{Overrides, Source};
use crate::Result;
use fovol_core::{Contents, Endian, Volume};
pub use header::is_classic;
use header::{Header, Variable, decoded};
use records::Records;

/// Reads the chosen variable, else the only one that is a volume, else the largest.
///
/// # Errors
/// Damaged files, no variable that is a volume, a choice that is not there.
pub fn parse(source: &Source, overrides: &Overrides) -> Result<Volume> {
    let damaged = || source.malformed("its NetCDF header is damaged or cut short; copy or download it again");
    let header = Header::parse(source.bytes()).ok_or_else(damaged)?;
    if is_minc(&header) {
        return Err(source
            .unsupported("MINC is not read; convert it to NIfTI, with `mnc2nii IN.mnc OUT.nii` for one"));
    }
    let records = Records::of(source, &header).ok_or_else(damaged)?;
    let file = File { source, header: &header, records };
    let auxiliary = auxiliary(header.variables.iter().map(|variable| &variable.attributes));
    let candidates: Vec<_> = header
        .variables
        .iter()
        .map(|variable| Candidate {
            axes: file.axes(variable),
            is_auxiliary: auxiliary.contains(&variable.name),
        })
        .collect();
    file.volume(&candidates, overrides)
}

/// Whether the file is of MINC, whose values are scaled slice by slice.
fn is_minc(header: &Header) -> bool {
    let has_axis = header.dimensions.iter().any(|dimension| ["xspace", "zspace"].contains(&&*dimension.name));
    let names = |name: &str| header.variables.iter().any(|variable| variable.name == name);
    names("rootvariable") || has_axis && names("image")
}

/// A variable as a volume.
struct Candidate {
    axes: std::result::Result<ArrayAxes, String>,
    /// Whether it holds bounds or coordinates of other variables.
    is_auxiliary: bool,
}

impl Candidate {
    /// The axes of a volume of its own.
    fn volume(&self) -> Option<&ArrayAxes> {
        self.axes.as_ref().ok().filter(|_| !self.is_auxiliary)
    }
}

/// An open file.
struct File<'a> {
    source: &'a Source,
    header: &'a Header,
    records: Records<'a>,
}

impl File<'_> {
    /// The axes of `variable` as a volume.
    fn axes(&self, variable: &Variable) -> std::result::Result<ArrayAxes, String> {
        if variable.dtype.is_none() {
            return Err("holds text, no numbers".into());
        }
        let names = variable.dimensions.iter().map(|&index| Some(self.header.dimensions[index].name.clone()));
        let first = variable.dimensions.first().and_then(|&index| self.coordinate_variable(index));
        let first_units = first.and_then(|first| first.attributes.text("units")).map(str::to_owned);
        Described { shape: self.records.shape(variable), names: names.collect(), first_units }.axes()
    }

    /// The index of the variable to show.
    fn shown(&self, candidates: &[Candidate], overrides: &Overrides) -> Result<usize> {
        let variables = &self.header.variables;
        if let Some(chosen) = &overrides.array {
            let found = variables.iter().position(|variable| variable.name == chosen.trim_matches('/'));
            return found
                .ok_or_else(|| Overrides::no_array(self.source, chosen, &self.listed(candidates, None)));
        }
        likeliest(candidates.iter().map(Candidate::volume)).ok_or_else(|| match variables.as_slice() {
            [] => self.source.unsupported("it holds no variables; is it the right file?"),
            _ => self.source.unsupported("none of its variables is a volume; save one with the axes z, y, x"),
        })
    }

    /// Names of all variables that are volumes, and of number `shown`.
    fn listed(&self, candidates: &[Candidate], shown: Option<usize>) -> Vec<String> {
        let named = self.header.variables.iter().zip(candidates).enumerate();
        let named =
            named.filter(|(index, (_, candidate))| candidate.volume().is_some() || shown == Some(*index));
        named.map(|(_, (variable, _))| variable.name.clone()).collect()
    }

    fn volume(&self, candidates: &[Candidate], overrides: &Overrides) -> Result<Volume> {
        let (source, shown) = (self.source, self.shown(candidates, overrides)?);
        let variable = &self.header.variables[shown];
        let refused =
            |problem: &str| source.unsupported(format!("its variable `{}` {problem}", variable.name));
        let axes = candidates[shown].axes.as_ref().map_err(|problem| refused(problem))?;
        let dtype = variable.dtype.ok_or_else(|| refused("holds text, no numbers"))?;
        let time = overrides.time_of(source, axes.times)?;
        let spaced = self.spaced(variable, axes);
        let is_unsigned =
            variable.attributes.text("_Unsigned").is_some_and(|text| text.eq_ignore_ascii_case("true"));
        let layout = Layout {
            spacing: spaced.as_ref().map_or([1.0; 3], |spaced| spaced.spacing),
            endian: Endian::Big,
            components: axes.components,
            ..Layout::new(axes.dims, if is_unsigned { unsigned(dtype) } else { dtype })
        };
        let length = layout.length(source)?;
        // A first axis of time is read at one point; a later one follows axes of length 1.
        let index = (axes.time == Some(0)).then_some(time);
        let (bytes, start) = self.records.bytes(variable, index)?;
        let start = if index.is_some() { start } else { start + time * length };
        let arrays = self.listed(candidates, Some(shown));
        let array = arrays.iter().position(|name| *name == variable.name).unwrap_or_default();
        let contents = Contents { arrays, array, ..axes.contents(time) };
        let volume = layout.volume(source, bytes, start)?.with_format("NetCDF").with_contents(contents);
        let volume = axes.notes.iter().fold(volume, |volume, note| volume.with_note(note.as_str()));
        let volume = match self.header.records {
            Some(promised) if promised > self.records.count => volume
                .with_note(format!("is cut short: {} of {promised} records are there", self.records.count)),
            _ => volume,
        };
        unpacked(source, with_spacing_notes(volume, spaced.as_ref(), overrides), &variable.attributes)
    }

    /// The variable that holds the coordinates along the dimension `index`.
    fn coordinate_variable(&self, index: usize) -> Option<&Variable> {
        let name = &self.header.dimensions[index].name;
        self.header.variables.iter().find(|variable| variable.name == *name && variable.dimensions == [index])
    }

    fn spaced(&self, variable: &Variable, axes: &ArrayAxes) -> Option<Spaced> {
        let along = axes.space.map(|axis| {
            let found = self.coordinate_variable(*variable.dimensions.get(axis?)?)?;
            let dtype = found.dtype?;
            let length = self.records.shape(found).first()?.checked_mul(dtype.size())?;
            let (bytes, start) = self.records.bytes(found, None).ok()?;
            let values = decoded((*bytes).as_ref().get(start..start.checked_add(length)?)?, dtype);
            let [factor, offset] = ["scale_factor", "add_offset"].map(|name| found.attributes.number(name));
            let values = values.iter().map(|value| value * factor.unwrap_or(1.0) + offset.unwrap_or(0.0));
            Some(Coordinate {
                name: found.name.clone(),
                values: values.collect(),
                units: found.attributes.text("units").map(str::to_owned),
            })
        });
        Spaced::from_coordinates(&along)
    }
}

#[cfg(test)]
mod tests;

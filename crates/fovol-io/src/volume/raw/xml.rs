//! XML sidecars: `.ivf` of Inviwo and `.vvd` of Voreen (its first volume).

use super::dat;
use super::description::Description;
use crate::Result;
use crate::volume::Source;
use fovol_core::Endian;
use quick_xml::events::{BytesStart, Event};
use quick_xml::{Reader, XmlVersion};

/// Sidecars hold a preview and a histogram at most.
const LONGEST: usize = 16 << 20;

/// Reads the sidecar `source`. Mappings to real-world values are left out: voxels keep the values they have.
///
/// # Errors
/// Broken XML, values that are no numbers or types.
pub fn parse(source: &Source) -> Result<Description> {
    let bytes = &source.bytes()[..source.bytes().len().min(LONGEST)];
    let text = std::str::from_utf8(bytes).map_err(|_| source.malformed("it is no UTF-8 text"))?;
    let mut reader = Reader::from_str(text);
    let mut said = Description::default();
    let mut item = String::new();
    loop {
        match reader.read_event() {
            Ok(Event::Start(element) | Event::Empty(element)) => {
                take(source, &element, &mut item, &mut said)?;
            }
            Ok(Event::End(element)) if element.name().as_ref() == "Volume" => break,
            Ok(Event::Eof) => break,
            Ok(_) => {}
            Err(e) => {
                let at = reader.error_position();
                let problem = e.to_string().replace('\n', " ");
                return Err(source.malformed(format!("its XML is broken at byte {at}: {problem}")));
            }
        }
    }
    Ok(said)
}

/// Reads one element; `item` is the name of the metadata that the next values belong to.
fn take(source: &Source, element: &BytesStart<'_>, item: &mut String, said: &mut Description) -> Result<()> {
    let get = |name: &str| attribute(source, element, name);
    match element.name().as_ref() {
        "RawFile" => said.file = get("content")?,
        "Format" => format(source, get("content")?, said)?,
        "ByteOffset" => said.offset = get("content")?.map(|text| number(source, &text)).transpose()?,
        "Dimension" => said.dims = three(source, element)?,
        "RawData" => {
            said.file = get("filename")?;
            format(source, get("format")?, said)?;
            said.dims = three(source, element)?;
        }
        "item" if said.file.is_none() => said.file = get("value")?,
        "MetaDataItem" => *item = get("key")?.unwrap_or_default(),
        "MetaItem" => *item = get("name")?.unwrap_or_default(),
        "MetaData" if item == "LittleEndian" => {
            let is_little = get("content")?.as_deref() != Some("0");
            said.endian = Some(if is_little { Endian::Little } else { Endian::Big });
        }
        "value" if item == "Spacing" => said.spacing = three(source, element)?,
        _ => {}
    }
    Ok(())
}

/// A format like `UINT8`, `uint16`, `Vector3(float)`.
fn format(source: &Source, text: Option<String>, said: &mut Description) -> Result<()> {
    let Some(text) = text else { return Ok(()) };
    let flat = text.replace("Vector", "Vec").replace(['(', ')'], "");
    let (components, dtype) = dat::format(&flat)
        .ok_or_else(|| source.malformed(format!("its format `{}` is no voxel type", text.escape_debug())))?;
    said.dtype = Some(dtype);
    said.components = components;
    Ok(())
}

/// The attributes x, y, z.
fn three<T: std::str::FromStr>(source: &Source, element: &BytesStart<'_>) -> Result<Option<[T; 3]>> {
    let mut values = Vec::new();
    for axis in ["x", "y", "z"] {
        let text = attribute(source, element, axis)?;
        let text = text.ok_or_else(|| source.malformed(format!("an element of its XML has no {axis}")))?;
        values.push(number(source, &text)?);
    }
    Ok(values.try_into().ok())
}

fn number<T: std::str::FromStr>(source: &Source, text: &str) -> Result<T> {
    text.trim()
        .parse()
        .map_err(|_| source.malformed(format!("`{}` in its XML is no number", text.escape_debug())))
}

fn attribute(source: &Source, element: &BytesStart<'_>, name: &str) -> Result<Option<String>> {
    let broken = |_| source.malformed(format!("the attribute {name} in its XML is broken"));
    let Some(attribute) = element.try_get_attribute(name).map_err(|_| broken(()))? else { return Ok(None) };
    let value = attribute.normalized_value(XmlVersion::Implicit1_0).map_err(|_| broken(()))?;
    Ok(Some(value.into_owned()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use fovol_core::Dtype;
    use std::path::Path;

    fn said(text: &str) -> Result<Description> {
        parse(&Source::from_bytes(Path::new("x.ivf"), text.as_bytes().to_vec()))
    }

    #[test]
    fn inviwo() {
        let said = said(
            r#"<?xml version="1.0" ?><InviwoTreeData version="1.0"><RawFile content="a&amp;b.raw" />
            <Format content="Vec2FLOAT32" /><Dimension x="13" y="7" z="3" /><MetaDataMap>
            <MetaDataItem type="org.inviwo.BoolMetaData" key="LittleEndian"><MetaData content="0" /></MetaDataItem>
            </MetaDataMap></InviwoTreeData>"#,
        )
        .unwrap();
        assert_eq!((said.file.as_deref(), said.dims), (Some("a&b.raw"), Some([13, 7, 3])));
        assert_eq!((said.dtype, said.components), (Some(Dtype::F32), Some(2)));
        assert_eq!(said.endian, Some(Endian::Big));
    }

    #[test]
    fn voreen() {
        let said = said(
            r#"<!-- note --><?xml version="1.0" ?><VoreenData version="1"><Volumes><Volume>
            <RawData format="uint8" x="8" y="3" z="4"><Paths><paths><item value="m.raw" /><item value="n.raw" /></paths></Paths>
            </RawData><MetaData><MetaItem name="Offset"><value x="0" y="0" z="0" /></MetaItem>
            <MetaItem name="Spacing"><value x="0.5" y="0.5" z="1" /></MetaItem></MetaData></Volume>
            <Volume><RawData filename="other" format="float" x="1" y="1" z="1" /></Volume></Volumes></VoreenData>"#,
        )
        .unwrap();
        assert_eq!((said.file.as_deref(), said.dims), (Some("m.raw"), Some([8, 3, 4])));
        assert_eq!((said.dtype, said.spacing), (Some(Dtype::U8), Some([0.5, 0.5, 1.0])));
    }

    #[test]
    fn broken_xml_is_a_one_line_error() {
        for text in [
            "<a",
            "<Format content=\"x\" />",
            "<Dimension x=\"1\" />",
            "<Dimension x=\"1\" y=\"-2\" z=\"3\" />",
            "<RawFile content=\"a />",
        ] {
            let error = said(text).unwrap_err().to_string();
            assert!(!error.contains('\n'), "{error}");
        }
    }
}

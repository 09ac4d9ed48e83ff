//! JSON as the libraries of Zarr write it.

use serde_json::{Map, Value};

/// An object of JSON.
pub type Object = Map<String, Value>;

/// Parses an object. Python also writes NaN and Infinity, which JSON lacks and attributes may hold.
///
/// # Errors
/// What is wrong with it.
pub fn parse(text: &[u8]) -> Result<Object, String> {
    let text = text.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(text);
    let parsed = serde_json::from_slice(text).or_else(|problem| {
        let strict = strict(text);
        if strict == text { Err(problem) } else { serde_json::from_slice(&strict) }
    });
    match parsed {
        Ok(Value::Object(object)) => Ok(object),
        Ok(_) => Err("is no object of JSON; write it again".into()),
        Err(problem) => Err(format!("is no JSON ({problem}); copy or download it again")),
    }
}

/// `text` with `null` for numbers that are not finite.
fn strict(text: &[u8]) -> Vec<u8> {
    const WORDS: [&[u8]; 3] = [b"NaN", b"-Infinity", b"Infinity"];
    let (mut out, mut at, mut is_quoted) = (Vec::with_capacity(text.len()), 0, false);
    while let Some(&byte) = text.get(at) {
        let word = WORDS.iter().find(|word| !is_quoted && text[at..].starts_with(word));
        if let Some(word) = word {
            out.extend_from_slice(b"null");
            at += word.len();
            continue;
        }
        out.push(byte);
        at += 1;
        match byte {
            b'"' => is_quoted = !is_quoted,
            b'\\' if is_quoted => {
                out.extend(text.get(at));
                at += 1;
            }
            _ => {}
        }
    }
    out
}

/// A list of whole numbers.
pub fn whole_numbers(value: Option<&Value>) -> Option<Vec<usize>> {
    let number = |value: &Value| value.as_u64().and_then(|number| usize::try_from(number).ok());
    value?.as_array()?.iter().map(number).collect()
}

/// The name of an extension point: `"name"` or `{"name": "name"}`.
pub fn named(value: &Value) -> &str {
    value.as_str().or_else(|| value.get("name")?.as_str()).unwrap_or_default()
}

/// An entry of the configuration of an extension point.
pub fn configured<'a>(value: &'a Value, key: &str) -> Option<&'a Value> {
    value.get("configuration")?.get(key)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_that_are_not_finite_are_null() {
        let object = parse(br#"{"a": NaN, "b": [-Infinity, 1], "c": "NaN \" Infinity"}"#).unwrap();
        assert_eq!(object["a"], Value::Null);
        assert_eq!(object["b"], serde_json::json!([null, 1]));
        assert_eq!(object["c"], "NaN \" Infinity");
        assert!(parse(b"[1]").is_err() && parse(b"{\"a\": NaNa}").is_err());
    }
}

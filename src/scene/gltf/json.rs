//! Looking into a JSON document, leniently where glTF is: `null` is nothing, and whole numbers may be written 4, 4.0 or 4e0.
//! Problems begin with the key.

use serde_json::Value;

use super::super::model::Unplaced;
use super::super::parts::decode;

/// The document of a file, or of a GLB's first chunk, which may be padded.
pub(super) fn parse(bytes: &[u8]) -> Unplaced<Value> {
    let end = bytes.iter().rposition(|&byte| byte != 0).map_or(0, |last| last + 1);
    let value: Value = serde_json::from_str(&decode(&bytes[..end])).map_err(|error| {
        let (line, column) = (error.line(), error.column());
        if error.is_eof() {
            return format!("JSON: line {line}: the text ends too early");
        }
        let what = match error.to_string().starts_with("number out of range") {
            true => "the number is too large",
            false => "is not valid JSON",
        };
        format!("JSON: line {line}, column {column}: {what}")
    })?;
    if value.is_object() { Ok(value) } else { Err("JSON: must be an object, { ... }".to_owned()) }
}

/// What stands under a key.
pub(super) fn get<'a>(object: &'a Value, key: &str) -> Option<&'a Value> {
    object.get(key).filter(|value| !value.is_null())
}

/// What stands under a chain of keys.
pub(super) fn deep<'a>(object: &'a Value, keys: &[&str]) -> Option<&'a Value> {
    keys.iter().try_fold(object, |value, key| get(value, key))
}

/// A list; empty where there is none.
pub(super) fn list<'a>(object: &'a Value, key: &str) -> Unplaced<&'a [Value]> {
    match get(object, key) {
        None => Ok(&[]),
        Some(Value::Array(items)) => Ok(items),
        Some(other) => Err(format!("{key}: must be a list, not {}", name(other))),
    }
}

/// A whole number from 0.
pub(super) fn index(object: &Value, key: &str) -> Unplaced<Option<usize>> {
    get(object, key).map(|value| whole(value).map_err(|p| format!("{key}: {p}"))).transpose()
}

/// A list of whole numbers from 0.
pub(super) fn indices(object: &Value, key: &str) -> Unplaced<Vec<usize>> {
    let items = list(object, key)?.iter();
    items.map(whole).collect::<Unplaced<_>>().map_err(|problem| format!("{key}: {problem}"))
}

fn whole(value: &Value) -> Unplaced<usize> {
    let float = || value.as_f64().filter(|v| *v >= 0.0 && v.fract() == 0.0).map(|v| v as u64);
    let number = value.as_u64().or_else(float);
    let number =
        number.ok_or_else(|| format!("must be a whole number from 0, not {}", name(value)))?;
    Ok(usize::try_from(number).unwrap_or(usize::MAX))
}

/// A number.
pub(super) fn number(object: &Value, key: &str) -> Unplaced<Option<f64>> {
    let Some(value) = get(object, key) else { return Ok(None) };
    let number = value.as_f64().filter(|v| v.is_finite());
    number.map(Some).ok_or_else(|| format!("{key}: must be a number, not {}", name(value)))
}

/// A list of `N` numbers.
pub(super) fn numbers<const N: usize>(object: &Value, key: &str) -> Unplaced<Option<[f64; N]>> {
    let Some(value) = get(object, key) else { return Ok(None) };
    let items = value.as_array().map(|items| items.iter().filter_map(Value::as_f64));
    let items: Option<[f64; N]> = items.and_then(|items| items.collect::<Vec<_>>().try_into().ok());
    let items = items.filter(|items| items.iter().all(|v| v.is_finite()));
    items.map(Some).ok_or_else(|| format!("{key}: must be a list of {N} numbers"))
}

/// A text; `None` also for anything else.
pub(super) fn text<'a>(object: &'a Value, key: &str) -> Option<&'a str> {
    get(object, key).and_then(Value::as_str)
}

/// What a value is, in words.
fn name(value: &Value) -> String {
    match value {
        Value::Null => "null".to_owned(),
        Value::Bool(_) => "true or false".to_owned(),
        Value::Number(number) => format!("the number {number}"),
        Value::String(_) => "a text".to_owned(),
        Value::Array(_) => "a list".to_owned(),
        Value::Object(_) => "an object, { ... }".to_owned(),
    }
}

//! Changing a manifest's text: only what is different.

use toml_edit::{Array, ArrayOfTables, DocumentMut, InlineTable, Item, Table, Value};

use super::entry::{Entry, Input};

/// The text, ready to be changed.
///
/// # Errors
/// Entries that are written in another way than as `[[entry]]`.
pub(super) fn parse(text: &str) -> Result<DocumentMut, String> {
    let document: DocumentMut = text.parse().map_err(|error: toml_edit::TomlError| {
        error.message().lines().next().unwrap_or_default().to_owned()
    })?;
    match document.get("entry") {
        None | Some(Item::ArrayOfTables(_)) => Ok(document),
        Some(_) => Err("entry: must be written as tables, [[entry]]".to_owned()),
    }
}

/// Add an entry at the end.
pub(super) fn add(document: &mut DocumentMut, entry: &Entry) {
    let entries = document.entry("entry").or_insert(Item::ArrayOfTables(ArrayOfTables::new()));
    if let Some(entries) = entries.as_array_of_tables_mut() {
        let mut table = Table::new();
        for (key, value) in fields(entry) {
            if let Some(value) = value {
                table.insert(key, Item::Value(value));
            }
        }
        table.decor_mut().set_prefix("\n");
        entries.push(table);
    }
}

/// Write what is different in the entry at `place`.
pub(super) fn replace(document: &mut DocumentMut, place: usize, old: &Entry, new: &Entry) {
    let entries = document.get_mut("entry").and_then(Item::as_array_of_tables_mut);
    let Some(table) = entries.and_then(|entries| entries.get_mut(place)) else { return };
    for ((key, old), (_, new)) in fields(old).into_iter().zip(fields(new)) {
        let text = |value: &Option<Value>| value.as_ref().map(ToString::to_string);
        if text(&old) == text(&new) {
            continue;
        }
        match new {
            Some(value) => drop(table.insert(key, Item::Value(value))),
            None => drop(table.remove(key)),
        }
    }
}

/// The fields in their order; `None` is left out.
fn fields(entry: &Entry) -> [(&'static str, Option<Value>); 10] {
    let results = entry.results.as_ref();
    let count =
        |count: Option<u64>| count.map(|n| Value::from(i64::try_from(n).unwrap_or(i64::MAX)));
    let text = |text: Option<&String>| text.map(|text| Value::from(text.as_str()));
    let options = entry.options.iter().map(String::as_str).collect::<Array>();
    let inputs = (!entry.inputs.is_empty()).then(|| inputs(&entry.inputs));
    [
        ("name", text(Some(&entry.name))),
        ("scene", text(Some(&entry.scene))),
        ("options", (!options.is_empty()).then_some(Value::Array(options))),
        ("generated", count(results.map(|r| r.generated))),
        ("kept", count(results.map(|r| r.kept))),
        ("fragments_hash", text(results.and_then(|r| r.fragments_hash.as_ref()))),
        ("image_hash", text(results.map(|r| &r.image_hash))),
        ("picture", text(entry.picture.as_ref())),
        ("program", text(entry.program.as_ref())),
        ("inputs", inputs),
    ]
}

/// One file a line.
fn inputs(inputs: &[Input]) -> Value {
    let mut array = Array::new();
    for Input { file, sha256 } in inputs {
        let mut table = InlineTable::new();
        table.insert("file", file.as_str().into());
        if let Some(sha256) = sha256 {
            table.insert("sha256", sha256.as_str().into());
        }
        let mut value = Value::InlineTable(table);
        value.decor_mut().set_prefix("\n    ");
        array.push_formatted(value);
    }
    array.set_trailing("\n");
    array.set_trailing_comma(true);
    Value::Array(array)
}

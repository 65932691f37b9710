//! What of JSON Schema (draft 2020-12) the schemas in docs/schemas use, and no more: any other keyword is an error, so
//! that nothing in a schema goes unchecked.
//!
//! No crate for it is a test dependency. Those that there are switch on `float_roundtrip` of `serde_json` or other
//! features of what the program itself depends on. Then scenes would be read otherwise in tests than in the program.

use serde_json::{Map, Value};

/// Keywords that say nothing of a document.
const SILENT: [&str; 5] = ["$schema", "$id", "$defs", "title", "description"];

/// What is wrong with a document, each with its place.
///
/// # Panics
/// If the schema has a keyword that is not known here, or a value that it cannot have.
pub(crate) fn errors(schema: &Value, document: &Value) -> Vec<String> {
    let mut found = Vec::new();
    Checker { root: schema }.check(schema, document, "", &mut found);
    found
}

/// Whether a document is as its schema says.
pub(crate) fn is_valid(schema: &Value, document: &Value) -> bool {
    errors(schema, document).is_empty()
}

struct Checker<'a> {
    root: &'a Value,
}

impl Checker<'_> {
    fn check(&self, schema: &Value, value: &Value, at: &str, found: &mut Vec<String>) {
        let schema = schema.as_object().unwrap_or_else(|| panic!("{schema} is no schema"));
        for (keyword, argument) in schema.iter().filter(|(k, _)| !SILENT.contains(&k.as_str())) {
            let right = match (keyword.as_str(), value) {
                ("type", _) => names(argument).iter().any(|name| is_a(name, value)),
                ("const", _) => value == argument,
                ("enum", _) => array(argument).contains(value),
                ("$ref", _) => {
                    let place = argument.as_str().and_then(|text| text.strip_prefix('#'));
                    let target = self.root.pointer(place.expect("a place in this schema"));
                    self.check(target.expect("a schema"), value, at, found);
                    true
                }
                ("anyOf", _) => self.fitting(argument, value) >= 1,
                ("oneOf", _) => self.fitting(argument, value) == 1,
                ("minimum", Value::Number(number)) => number.as_f64() >= argument.as_f64(),
                ("pattern", Value::String(text)) => matches(argument.as_str().expect("text"), text),
                ("items", Value::Array(items)) => {
                    for (i, item) in items.iter().enumerate() {
                        self.check(argument, item, &format!("{at}/{i}"), found);
                    }
                    true
                }
                ("required", Value::Object(map)) => {
                    names(argument).iter().all(|name| map.contains_key(*name))
                }
                ("properties", Value::Object(map)) => {
                    for (name, schema) in argument.as_object().expect("an object") {
                        if let Some(value) = map.get(name) {
                            self.check(schema, value, &format!("{at}/{name}"), found);
                        }
                    }
                    true
                }
                ("additionalProperties", Value::Object(map)) => {
                    self.additional(schema, argument, map, at, found)
                }
                ("minimum" | "pattern" | "items" | "required" | "properties", _)
                | ("additionalProperties", _) => true,
                _ => panic!("the keyword {keyword} is not known"),
            };
            if !right {
                let text = value.to_string();
                let text: String = text.chars().take(80).collect();
                found.push(format!("{at}: {text} is not as \"{keyword}\": {argument} says"));
            }
        }
    }

    /// Keys that `properties` does not name.
    fn additional(
        &self,
        schema: &Map<String, Value>,
        argument: &Value,
        map: &Map<String, Value>,
        at: &str,
        found: &mut Vec<String>,
    ) -> bool {
        let known = schema.get("properties").and_then(Value::as_object);
        let mut rest = map.iter().filter(|(key, _)| known.is_none_or(|k| !k.contains_key(*key)));
        if *argument == Value::Bool(false) {
            return rest.next().is_none();
        }
        for (key, value) in rest {
            self.check(argument, value, &format!("{at}/{key}"), found);
        }
        true
    }

    /// How many of several schemas a value fits.
    fn fitting(&self, schemas: &Value, value: &Value) -> usize {
        let fits = |schema: &&Value| {
            let mut found = Vec::new();
            self.check(schema, value, "", &mut found);
            found.is_empty()
        };
        array(schemas).iter().filter(fits).count()
    }
}

fn array(value: &Value) -> &Vec<Value> {
    value.as_array().unwrap_or_else(|| panic!("{value} is no list"))
}

/// One name, or several.
fn names(value: &Value) -> Vec<&str> {
    match value {
        Value::String(name) => vec![name],
        list => array(list).iter().map(|name| name.as_str().expect("a name")).collect(),
    }
}

fn is_a(name: &str, value: &Value) -> bool {
    match name {
        "null" => value.is_null(),
        "boolean" => value.is_boolean(),
        "string" => value.is_string(),
        "array" => value.is_array(),
        "object" => value.is_object(),
        "number" => value.is_number(),
        "integer" => value.is_i64() || value.is_u64(),
        other => panic!("the type {other} is not known"),
    }
}

/// The two patterns that there are: a beginning, and so many hexadecimal digits.
fn matches(pattern: &str, text: &str) -> bool {
    match pattern {
        "^[0-9a-f]{64}$" => {
            text.len() == 64
                && text.bytes().all(|b| b.is_ascii_digit() || (b'a'..=b'f').contains(&b))
        }
        "^fl2-" => text.starts_with("fl2-"),
        other => panic!("the pattern {other} is not known"),
    }
}

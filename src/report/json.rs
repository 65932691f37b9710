//! JSON documents. Keys come in the order of the fields, maps in the order of their keys, so equal values give
//! equal text.

use serde::Serialize;

use crate::error::{Error, Result};

/// One indented JSON document with a newline at its end.
///
/// # Errors
/// A value that JSON cannot hold, such as a map whose keys are not text.
pub fn document<T: Serialize + ?Sized>(value: &T) -> Result<String> {
    match serde_json::to_string_pretty(value) {
        Ok(text) => Ok(text + "\n"),
        Err(error) => Err(Error::new("--json", error.to_string())),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::Report;

    #[test]
    fn keys_are_the_fields_in_their_order() {
        let text = document(&Report::default()).unwrap();
        let keys: Vec<&str> =
            text.lines().filter_map(|line| line.strip_prefix("  \"")?.split('"').next()).collect();
        let first = ["method", "scene", "exec", "threads", "k", "width", "height", "triangles"];
        assert_eq!(keys[..first.len()], first);
        for key in ["degenerate", "dropped", "fragments_hash", "seconds", "warnings", "violations"]
        {
            assert!(keys.contains(&key), "{key}");
        }
        assert!(text.ends_with("}\n"));
    }
}

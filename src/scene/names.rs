//! What effects call objects: an `[[object]]` of a scene file with all its meshes, a mesh file given directly (one
//! object, `a`), or a mesh of a built-in scene given directly. One that is given no name is called by the letter of its
//! place: a, b, ..., z, aa, ab, ...

/// The name of the object at a place, counted from 0.
#[must_use]
pub fn letters(index: usize) -> String {
    let mut name = Vec::new();
    let mut rest = index + 1;
    while rest > 0 {
        rest -= 1;
        name.push(char::from(b'a' + (rest % 26) as u8));
        rest /= 26;
    }
    name.iter().rev().collect()
}

/// Whether `name` begins with a letter or `_` and goes on with letters, digits or `_`, all of them ASCII.
#[must_use]
pub fn is_identifier(name: &str) -> bool {
    let mut characters = name.chars();
    let first = characters.next().is_some_and(|c| c.is_ascii_alphabetic() || c == '_');
    first && characters.all(|c| c.is_ascii_alphanumeric() || c == '_')
}

/// Whether names are identifiers, each only once.
///
/// # Errors
/// The place of the first that is not, and why.
pub(super) fn check(names: impl Iterator<Item = String>) -> Result<(), (usize, String)> {
    let mut known = std::collections::BTreeMap::new();
    for (i, name) in names.enumerate() {
        if !is_identifier(&name) {
            let right = "must be letters, digits and _, not beginning with a digit";
            return Err((i, format!("name: {name:?} {right}")));
        }
        if let Some(first) = known.insert(name.clone(), i) {
            let others = "one without a name is called a, b, c, ... by its place";
            return Err((i, format!("name: {name:?} is the name of object {first} ({others})")));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn letters_go_on_after_z() {
        let names = [0, 1, 25, 26, 27, 51, 52, 701, 702].map(letters);
        assert_eq!(names, ["a", "b", "z", "aa", "ab", "az", "ba", "zz", "aaa"]);
    }

    #[test]
    fn identifiers() {
        assert!(["a", "_", "a1", "Big_Box"].iter().all(|name| is_identifier(name)));
        assert!(!["", "1a", "a-b", "a b", "é", "~"].iter().any(|name| is_identifier(name)));
    }

    #[test]
    fn wrong_and_taken_names_are_told_with_their_place() {
        let check = |names: &[&str]| check(names.iter().map(|&name| name.to_owned()));
        assert_eq!(check(&["a", "b"]), Ok(()));
        assert_eq!(check(&["a", "a b"]).unwrap_err().0, 1);
        assert!(check(&["a", "b", "a"]).unwrap_err().1.contains("is the name of object 0"));
    }
}

//! The file: the frame with everything put in.

use std::io::{self, Write};

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use sha2::{Digest as _, Sha256};

use super::Page;
use super::files::{FRAME, SCRIPTS, STYLE};
use crate::error::{Error, Result};
use crate::image::drawing::escaped;
use crate::report::timeline::page::in_script;

impl Page {
    /// Write the page.
    ///
    /// # Errors
    /// What `out` reports.
    pub fn write(&self, out: &mut impl Write) -> io::Result<()> {
        let style = STYLE.concat();
        let script = script();
        let policy = format!(
            "default-src 'none'; base-uri 'none'; form-action 'none'; img-src data: blob:; \
             style-src '{}'; script-src '{}'",
            fingerprint(&style),
            fingerprint(&script)
        );
        let contents = self.contents().map_err(|error| io::Error::other(error.to_string()))?;
        let mut rest = FRAME;
        while let Some((before, name, after)) = marked(rest) {
            out.write_all(before.as_bytes())?;
            match name {
                "policy" => out.write_all(policy.as_bytes())?,
                "title" => out.write_all(escaped(&self.title).as_bytes())?,
                "style" => out.write_all(style.as_bytes())?,
                "script" => out.write_all(script.as_bytes())?,
                "contents" => out.write_all(contents.as_bytes())?,
                "early" => attached(out, 'a', &self.early)?,
                "late" => attached(out, 'b', &self.late)?,
                other => return Err(io::Error::other(format!("nothing is called {other}"))),
            }
            rest = after;
        }
        out.write_all(rest.as_bytes())
    }

    /// The sections, as JSON that no tag can end.
    fn contents(&self) -> Result<String> {
        let text = serde_json::to_string(&self.sections);
        let text = text.map_err(|error| Error::new("the page", error.to_string()))?;
        Ok(in_script(&text))
    }
}

/// One function, so that its names are nobody else's.
fn script() -> String {
    format!("(() => {{\n\"use strict\";\n{}start();\n}})();\n", SCRIPTS.concat())
}

/// What stands before the next mark, its name, and what comes after.
fn marked(text: &str) -> Option<(&str, &str, &str)> {
    let (before, rest) = text.split_once("{{")?;
    let (name, after) = rest.split_once("}}")?;
    Some((before, name, after))
}

/// As a content security policy names it.
fn fingerprint(text: &str) -> String {
    format!("sha256-{}", STANDARD.encode(Sha256::digest(text.as_bytes())))
}

/// Data in elements that browsers leave alone.
fn attached(out: &mut impl Write, letter: char, data: &[Vec<u8>]) -> io::Result<()> {
    for (number, bytes) in data.iter().enumerate() {
        write!(out, "<script type=\"application/octet-stream\" id=\"{letter}{number}\">")?;
        // A multiple of 3, so that only the last chunk is padded.
        for chunk in bytes.chunks(48 << 10) {
            out.write_all(STANDARD.encode(chunk).as_bytes())?;
        }
        writeln!(out, "</script>")?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::super::{Pictures, Section, Table};
    use super::*;
    use crate::image::Image;
    use crate::report::grid::{Cell, Column, Grid};

    const EVIL: &str = "</script><!-- & \"'{{script}}";

    fn page() -> Page {
        let mut page = Page::new(EVIL);
        let rows = vec![[EVIL.to_owned(), EVIL.to_owned()]];
        page.add(EVIL, Section::Facts { rows, notes: vec![EVIL.to_owned()] });
        let grid = Grid {
            columns: vec![Column::new("name", EVIL)],
            rows: vec![vec![Cell::Word(EVIL.to_owned())]],
        };
        page.add("table", Section::Table(Table::new(&grid, &[Some(page.name(1))], Vec::new())));
        let mut pictures = Pictures::new([2, 1]);
        pictures.add(&mut page, EVIL, &Image::filled(2, 1, [1; 4])).unwrap();
        page.add("pictures", Section::Pictures(pictures));
        page.attach(vec![255; 100_000], false);
        page
    }

    fn written(page: &Page) -> String {
        let mut bytes = Vec::new();
        page.write(&mut bytes).unwrap();
        String::from_utf8(bytes).unwrap()
    }

    #[test]
    fn equal_pages_have_equal_bytes_and_no_name_breaks_them() {
        let text = written(&page());
        assert_eq!(text, written(&page()));
        assert_eq!(text.matches("</script>").count(), 4, "contents, script, two attached");
        assert_eq!(
            text.matches("<title>&lt;/script&gt;&lt;!-- &amp; &quot;&#39;{{script}}</title>")
                .count(),
            1
        );
        assert!(!text.contains("<!--"));
        let json = text.split("id=\"contents\">").nth(1).unwrap().split("</script>").next();
        let contents: serde_json::Value = serde_json::from_str(json.unwrap()).unwrap();
        assert_eq!(contents[0]["rows"][0][0], EVIL);
        assert_eq!(contents[1]["rows"][0]["cells"][0][0], EVIL);
        assert_eq!(contents[1]["rows"][0]["link"], contents[2]["id"]);
        assert_eq!(contents[2]["pictures"][0]["name"], EVIL);
    }

    #[test]
    fn data_comes_back() {
        let text = written(&page());
        let data = text.split("id=\"b0\">").nth(1).unwrap().split("</script>").next().unwrap();
        assert_eq!(STANDARD.decode(data).unwrap(), vec![255; 100_000]);
    }

    /// A browser runs only what the policy names.
    #[test]
    fn the_policy_names_what_is_there() {
        let text = written(&page());
        let between = |from: &str, to: &str| {
            text.split(from).nth(1).unwrap().split(to).next().unwrap().to_owned()
        };
        let (style, script) = (between("<style>", "</style>"), between("<script>", "</script>"));
        let policy = between("Content-Security-Policy\" content=\"", "\"");
        assert!(policy.contains(&format!("style-src '{}'", fingerprint(&style))), "{policy}");
        assert!(policy.contains(&format!("script-src '{}'", fingerprint(&script))), "{policy}");
        assert!(policy.starts_with("default-src 'none'"));
        for word in ["http:", "https:", "eval(", "innerHTML", "fetch(", "XMLHttpRequest"] {
            let allowed = text.replace("http://www.w3.org/2000/svg", "");
            assert!(!allowed.contains(word), "{word}");
        }
    }
}

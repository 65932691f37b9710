//! A timeline as a page of its own: one file, without a network, stepped through by keys.

use crate::error::{Error, Result};
use crate::explore::replay::timeline::Timeline;
use crate::image::drawing::escaped;

/// Draws the timeline: `timeline(element, data)`. Its first lines say how it is used.
pub const SCRIPT: &str = include_str!("../page/web/timeline.js");

/// What it looks like. All classes begin with `timeline`.
pub const STYLE: &str = include_str!("../page/web/timeline.css");

/// The page.
///
/// # Errors
/// The timeline cannot be written as JSON.
pub fn page(timeline: &Timeline) -> Result<String> {
    let json = serde_json::to_string(timeline).map_err(|e| Error::new("JSON", e.to_string()))?;
    let title = escaped(&format!("{}: {}", timeline.method, timeline.property));
    Ok(format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; \
         style-src 'unsafe-inline'; script-src 'unsafe-inline'\">\n\
         <meta name=\"viewport\" content=\"width=device-width\">\n\
         <meta name=\"color-scheme\" content=\"light dark\">\n\
         <title>{title}</title>\n<style>\n{STYLE}body {{ margin: 0; }}\n\
         #timeline {{ box-sizing: border-box; min-height: 100vh; }}\n</style>\n</head>\n<body>\n\
         <main id=\"timeline\"></main>\n\
         <noscript>This page needs JavaScript. `fragloom replay TOKEN --trace` prints the same.</noscript>\n\
         <script type=\"application/json\" id=\"data\">{}</script>\n\
         <script>\n{SCRIPT}\ntimeline(document.getElementById(\"timeline\"), \
         JSON.parse(document.getElementById(\"data\").textContent));\n\
         document.getElementById(\"timeline\").focus();\n</script>\n</body>\n</html>\n",
        in_script(&json)
    ))
}

/// JSON as it stands in a page's script: nothing in it ends the script, or begins another.
#[must_use]
pub fn in_script(json: &str) -> String {
    json.replace('<', "\\u003c")
        .replace('>', "\\u003e")
        .replace('&', "\\u0026")
        .replace('\u{2028}', "\\u2028")
        .replace('\u{2029}', "\\u2029")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::drawing::look::{Ink, SERIES};

    #[test]
    fn nothing_in_the_data_ends_the_script() {
        let json = serde_json::to_string(&["</script><script>alert(1)", "<!--", "&amp;\u{2028}"]);
        let json = json.expect("JSON");
        let safe = in_script(&json);
        assert!(!safe.contains(['<', '>', '&', '\u{2028}']), "{safe}");
        let read: Vec<String> = serde_json::from_str(&safe).expect("the same JSON");
        assert_eq!(serde_json::to_string(&read).expect("JSON"), json);
    }

    /// One look: the colours of pages are those of drawings.
    #[test]
    fn the_style_has_the_colours_of_drawings() {
        let named = [
            ("paper", Ink::Paper),
            ("text", Ink::Text),
            ("quiet", Ink::Quiet),
            ("rule", Ink::Rule),
            ("panel", Ink::Panel),
            ("fault", Ink::Fault),
            ("faultpanel", Ink::FaultPanel),
        ];
        let named = named.map(|(name, ink)| (name.to_owned(), ink));
        let series = (0..SERIES).map(|i| (format!("series{i}"), Ink::Series(i)));
        let (light, dark) = STYLE.split_once("prefers-color-scheme: dark").expect("both");
        for (name, ink) in named.into_iter().chain(series) {
            for (text, on_dark) in [(light, false), (dark, true)] {
                let [r, g, b] = ink.color(on_dark);
                let line = format!("--timeline-{name}: #{r:02x}{g:02x}{b:02x};");
                assert!(text.contains(&line), "{line}, dark {on_dark}");
            }
        }
    }
}

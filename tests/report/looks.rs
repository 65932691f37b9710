//! The slider, the keyboard, the dark scheme, print, and names of controls.

use browser::SHIFT;
use fragloom::image::Image;

use super::*;

/// The colour on the screen at a pixel of the stage, which must not be magnified by less than 3.
fn on_screen(browser: &mut Browser, [x, y]: [u32; 2]) -> [u8; 4] {
    let part = |place: u32, whole: u32| (f64::from(place) + 0.5) / f64::from(whole);
    let [left, top] = browser.place(".stage", [part(x, SIZE[0]), part(y, SIZE[1])]);
    let shot = browser.screenshot();
    shot.pixel(left as u32, top as u32)
}

#[test]
fn the_slider_lies_between_two_pictures() {
    let Some(mut browser) = Browser::start() else { return };
    let dir = Dir::new();
    let (path, _) = written(&dir, Data::Color);
    let frame =
        fragloom::inspect::frame::Frame::new(&scene(), &methods(Data::Color)).map(|f| f.exact);
    let exact: Image = frame.expect("a frame");
    let kb: Image =
        fragloom::render::render(&scene(), &methods(Data::Color)[0]).expect("drawn").image;
    browser.open(&path);
    browser.wait("[...document.images].every((image) => image.complete)");
    let differ = |x: u32| (20..60).map(move |y| [x, y]).collect::<Vec<_>>();
    let differ = |xs: std::ops::Range<u32>| {
        let mut all = xs.flat_map(differ);
        all.find(|&[x, y]| exact.pixel(x, y) != kb.pixel(x, y)).expect("a difference")
    };
    let (west, east) = (differ(30..46), differ(54..70));
    let at = |image: &Image, [x, y]: [u32; 2]| image.pixel(x, y);
    assert_eq!(on_screen(&mut browser, west), at(&exact, west));
    assert_eq!(on_screen(&mut browser, east), at(&kb, east));
    // The line is moved to the left edge, and then to the right edge, by the mouse.
    browser.drag(".line", [-2_000.0, 0.0]);
    assert_eq!(on_screen(&mut browser, west), at(&kb, west));
    assert_eq!(browser.eval("document.querySelector('.slider').value"), "0");
    browser.drag(".line", [2_000.0, 0.0]);
    assert_eq!(on_screen(&mut browser, east), at(&exact, east));
    // And back by the keyboard.
    browser.eval("document.querySelector('.slider').focus()");
    browser.key("Home", 0);
    assert_eq!(on_screen(&mut browser, east), at(&kb, east));
    // The other picture is another method's.
    browser.key("]", 0);
    assert!(browser.text(".name-right").contains("kplus-array"));
    browser.key("[", 0);
    assert!(browser.text(".name-right").contains("kb"));
    // All panels are zoomed together.
    browser.key("+", 0);
    browser.key("+", 0);
    let all =
        "new Set([...document.querySelectorAll('.panel img')].map((i) => i.style.transform)).size";
    assert_eq!(browser.eval(all), 1);
    assert_eq!(browser.text(".zoomed"), "4\u{d7}");
    // A click in a magnified picture is at the pixel that is there.
    browser.click_at(".stage", [0.5, 0.5]);
    shows(&mut browser, [SIZE[0] / 2, SIZE[1] / 2]);
    browser.key("0", 0);
    assert_eq!(browser.text(".zoomed"), "1\u{d7}");
    assert_eq!(browser.complaints(), Vec::<String>::new());
}

/// What can be reached, in the order of the document.
const CONTROLS: &str =
    "[...document.querySelectorAll('a[href], button, input, select, textarea, [tabindex=\"0\"]')]
    .filter((e) => e.checkVisibility({ visibilityProperty: true }))";

#[test]
fn everything_works_by_the_keyboard() {
    let Some(mut browser) = Browser::start() else { return };
    let dir = Dir::new();
    let (path, _) = written(&dir, Data::Color);
    browser.open(&path);
    look_at(&mut browser, [50, 40]);
    for (key, modifiers, pixel) in [
        ("ArrowRight", 0, [51, 40]),
        ("ArrowDown", 0, [51, 41]),
        ("ArrowLeft", SHIFT, [41, 41]),
        ("ArrowUp", SHIFT, [41, 31]),
        ("ArrowUp", SHIFT, [41, 21]),
        ("ArrowLeft", 0, [40, 21]),
    ] {
        browser.key(key, modifiers);
        shows(&mut browser, pixel);
    }
    let found = inspect(&scene(), &methods(Data::Color), [40, 21]).expect("inspected");
    assert_eq!(differences(&mut browser, &found), Vec::<String>::new());
    // Tab leads through all controls, and each is seen to have the focus.
    browser.eval("document.activeElement.blur(); window.scrollTo(0, 0)");
    let count = browser.eval(&format!("{CONTROLS}.length")).as_u64().expect("a number");
    assert!(count > 20, "{count}");
    browser.eval("window.passed = []");
    // Between the last and the first, the focus is the browser's.
    for _ in 0..count + 3 {
        browser.key("Tab", 0);
        browser.eval("window.passed.push(document.activeElement)");
        let unseen = "document.activeElement !== document.body
            && getComputedStyle(document.activeElement).outlineStyle !== 'solid'
            ? document.activeElement.outerHTML.slice(0, 200) : null";
        assert_eq!(browser.eval(unseen), Value::Null);
    }
    let missed = format!(
        "{CONTROLS}.filter((e) => !window.passed.includes(e)).map((e) => e.outerHTML.slice(0, 200))"
    );
    assert_eq!(browser.eval(&missed), serde_json::json!([]));
    // Help opens, and closes.
    browser.key("?", SHIFT);
    assert_eq!(browser.eval("document.getElementById('help').open"), true);
    assert!(browser.text("#help").contains("arrow keys"));
    browser.key("Escape", 0);
    assert_eq!(browser.eval("document.getElementById('help').open"), false);
    assert_eq!(browser.complaints(), Vec::<String>::new());
}

/// Every control and picture has a name, every table headings, every section a heading, and no name is there twice.
pub(crate) const NAMELESS: &str = "(() => { const named = (e) => (e.ariaLabel || (e.labels && [...e.labels].map((l) => l.innerText).join(''))
    || e.alt || e.getAttribute('aria-labelledby') || e.textContent || '').trim() !== '';
    const all = [...document.querySelectorAll('button, a, input, select, textarea, img, [role=img], [role=region], [role=application], section, dialog')];
    const ids = [...document.querySelectorAll('[id]')].map((e) => e.id);
    return [...all.filter((e) => !named(e)).map((e) => e.outerHTML.slice(0, 200)),
      ...ids.filter((id, i) => ids.indexOf(id) !== i),
      ...[...document.querySelectorAll('table')].filter((t) => !t.querySelector('th[scope]')).map((t) => t.className),
      ...(document.documentElement.lang ? [] : ['lang'])]; })()";

/// The contrast of text and its ground.
const CONTRAST: &str = "(() => { const light = (c) => { const [r, g, b] = c.match(/[\\d.]+/g).map(Number).map((v) => {
      v /= 255; return v <= 0.03928 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4; }); return 0.2126 * r + 0.7152 * g + 0.0722 * b; };
    const style = getComputedStyle(document.body); const quiet = getComputedStyle(document.querySelector('.note'));
    const paper = light(style.backgroundColor);
    return [style, quiet].map((s) => { const [a, b] = [light(s.color), paper].sort((x, y) => y - x); return (a + 0.05) / (b + 0.05); }); })()";

#[test]
fn dark_printed_and_named() {
    let Some(mut browser) = Browser::start() else { return };
    let dir = Dir::new();
    let (path, _) = written(&dir, Data::Color);
    browser.open(&path);
    look_at(&mut browser, [50, 40]);
    document(&mut browser);
    assert_eq!(browser.eval(NAMELESS), serde_json::json!([]));
    let paper = "getComputedStyle(document.body).backgroundColor";
    let mut papers = Vec::new();
    for scheme in ["light", "dark"] {
        browser.emulate("screen", scheme);
        papers.push(browser.eval(paper));
        for contrast in browser.eval(CONTRAST).as_array().expect("numbers") {
            assert!(contrast.as_f64().expect("a number") >= 4.5, "{scheme}: {contrast}");
        }
    }
    assert_ne!(papers[0], papers[1]);
    browser.key("+", 0);
    browser.emulate("print", "light");
    let shown = "[...document.querySelectorAll('button.control, select, input, textarea, .line')].filter((e) => e.checkVisibility()).length";
    assert_eq!(browser.eval(shown), 0, "controls are not printed");
    let pictures = "[...document.querySelectorAll('.gallery img')].filter((e) => e.checkVisibility() && getComputedStyle(e).transform === 'none').length";
    assert_eq!(browser.eval(pictures), 1 + 3 * 4, "all pictures and maps are, and whole");
    assert_eq!(browser.eval("document.querySelectorAll('table').length >= 3"), true);
    let hidden = "[...document.querySelectorAll('table')].filter((e) => !e.closest('dialog') && !e.checkVisibility()).length";
    assert_eq!(browser.eval(hidden), 0);
    assert_eq!(browser.complaints(), Vec::<String>::new());
}

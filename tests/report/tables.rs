//! Tables that are sorted and exported, against the library's.

use fragloom::report::grid::{Grid, Syntax};
use fragloom::report::page::drawing::grid;

use super::*;

#[test]
fn a_table_sorts_and_is_exported_as_it_is_shown() {
    let Some(mut browser) = Browser::start() else { return };
    let dir = Dir::new();
    let (path, rows) = written(&dir, Data::Color);
    browser.open(&path);
    let whole = grid(&rows, SIZE);
    let shown = cells(&mut browser, ".kind-table");
    let text = whole.write(Syntax::Text);
    for (row, line) in shown.iter().zip(text.lines().skip(1)) {
        assert_eq!(row.join(" "), line.split_whitespace().collect::<Vec<_>>().join(" "));
    }
    assert_eq!(order(&mut browser), names(&rows));
    let flip = whole.columns.iter().position(|column| column.name == "flip").expect("a column") + 1;
    let head = format!(".kind-table th:nth-child({flip})");
    let mut sorted: Vec<usize> = (0..rows.len()).collect();
    sorted.sort_by(|&a, &b| rows[a].metrics.flip.total_cmp(&rows[b].metrics.flip));
    let up = sorted.clone();
    let down: Vec<usize> = sorted.into_iter().rev().collect();
    assert_ne!(up, (0..rows.len()).collect::<Vec<_>>(), "it is not sorted at first");
    let plain: Vec<usize> = (0..rows.len()).collect();
    for (order_now, told) in [(up, "ascending"), (down, "descending"), (plain, "none")] {
        browser.click(&format!("{head} button"));
        let titles: Vec<String> = order_now.iter().map(|&i| rows[i].title.clone()).collect();
        assert_eq!(order(&mut browser), titles, "{told}");
        let sort = browser.eval(&format!("document.querySelector('{head}').ariaSort"));
        assert_eq!(sort, told);
        let again = order_now.iter().map(|&i| whole.rows[i].clone()).collect();
        let again = Grid { columns: whole.columns.clone(), rows: again };
        for (number, syntax) in [(1, Syntax::Csv), (2, Syntax::Latex)] {
            let button = format!(".kind-table > .controls button:nth-child({number})");
            if browser.eval(&format!("document.querySelector('{button}').ariaExpanded")) == "false"
            {
                browser.click(&button);
            }
            let area =
                format!("document.querySelectorAll('.kind-table textarea')[{}].value", number - 1);
            assert_eq!(browser.eval(&area), again.write(syntax));
        }
    }
    // By the keyboard, a column of words.
    browser.eval("document.querySelector('.kind-table th button').focus()");
    browser.key("Enter", 0);
    let mut words = names(&rows);
    words.sort();
    assert_eq!(order(&mut browser), words);
    assert_eq!(browser.complaints(), Vec::<String>::new());
}

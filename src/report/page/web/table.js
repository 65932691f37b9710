// Tables that sort by a column, and give what they show as CSV and LaTeX.

function table(place, { columns, rows, csv, latex, notes }, { id }) {
  let order = rows.map((_, i) => i);
  let sorted = { column: null, down: false };

  const numbers = (i, column) => rows[i].cells[column][1];
  const words = (i, column) => rows[i].cells[column][0];
  /** Numbers before what is none, in both directions; words by their characters. */
  function compare(column, down) {
    const sign = down ? -1 : 1;
    return (a, b) => {
      if (columns[column].word) {
        const [x, y] = [words(a, column), words(b, column)];
        return x === y ? a - b : (x < y ? -sign : sign);
      }
      const [x, y] = [numbers(a, column), numbers(b, column)];
      if (x === null || y === null) return (x === null) - (y === null) || a - b;
      return sign * (x - y) || a - b;
    };
  }

  const body = el("tbody");
  const heads = columns.map(({ text, word }, column) => {
    const arrow = el("span", { class: "arrow", "aria-hidden": "true" });
    const button = el("button", { type: "button", onclick: () => sort(column) }, text, arrow);
    return el("th", { scope: "col", "aria-sort": "none", class: word ? "word" : "number" }, button);
  });
  const lines = rows.map(({ cells, link }) => el("tr", {}, cells.map(([text], column) => {
    const shown = column === 0 && link ? el("a", { href: `#${link}` }, text) : text;
    const look = columns[column].word ? "word" : "number";
    return column === 0 ? el("th", { scope: "row", class: look }, shown) : el("td", { class: look }, shown);
  })));

  /** Up, then down, then as it was. */
  function sort(column) {
    if (sorted.column !== column) sorted = { column, down: false };
    else if (!sorted.down) sorted = { column, down: true };
    else sorted = { column: null, down: false };
    order = rows.map((_, i) => i);
    if (sorted.column !== null) order.sort(compare(sorted.column, sorted.down));
    show();
  }

  function show() {
    body.replaceChildren(...order.map((i) => lines[i]));
    heads.forEach((head, column) => {
      const by = column === sorted.column;
      head.setAttribute("aria-sort", by ? (sorted.down ? "descending" : "ascending") : "none");
      head.querySelector(".arrow").textContent = by ? (sorted.down ? " \u25bc" : " \u25b2") : "";
    });
    exports.forEach(({ refresh }) => refresh());
  }

  const all = (syntax, [head, foot]) => () => head + order.map((i) => rows[i][syntax]).join("") + foot;
  const exports = [
    exported("CSV", `${id}.csv`, "text/csv", all("csv", csv)),
    exported("LaTeX", `${id}.tex`, "text/x-tex", all("latex", latex)),
  ];
  show();
  place.append(
    el("div", { class: "scrolled", tabindex: "0", role: "region", "aria-label": "table" },
      el("table", {}, el("thead", {}, el("tr", {}, heads)), body)),
    ...notes.map((note) => el("p", { class: "note" }, note)),
    el("div", { class: "controls" }, exports.map(({ button }) => button)),
    ...exports.map(({ box }) => box),
  );
}

function facts(place, { rows, notes }) {
  const pairs = rows.flatMap(([name, value]) => [el("dt", {}, name), el("dd", {}, value)]);
  place.append(el("dl", {}, pairs), ...notes.map((note) => el("p", { class: "note" }, note)));
}

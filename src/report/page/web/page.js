// The page: its sections one below the other, and the keys that work everywhere.

/** What shows each kind of section: it gets a place and the section, and may return keys. */
const kinds = { facts, table, pictures, timeline: interleaving };

function interleaving(place, data) {
  const box = el("div");
  place.append(box);
  timeline(box, data);
}

const KEYS = [
  ["click, Enter", "look at a pixel of the pictures"],
  ["arrow keys", "in the pictures: move the pixel; with Shift by 10"],
  ["+  -  0", "zoom in, out, show all; or the wheel, with Ctrl where the pictures have no focus"],
  ["drag", "move the zoomed pictures, or the line between two"],
  ["[  ]", "the picture on the right: the one before, the next"],
  ["{  }", "the picture on the left"],
  ["\u2190  \u2192  Home  End  F", "in a timeline: one step back, one on, the first, the last, the fault"],
  ["Tab", "to the next control"],
  ["?", "this list"],
];

function help() {
  const close = el("button", { type: "button", class: "control", onclick: () => dialog.close() }, "Close");
  const rows = KEYS.map(([key, what]) => el("tr", {}, el("th", { scope: "row" }, el("kbd", {}, key)), el("td", {}, what)));
  const dialog = el("dialog", { id: "help", "aria-label": "Keys" }, el("h2", {}, "Keys"),
    el("table", {}, el("tbody", {}, rows)), close);
  document.body.append(dialog);
  document.getElementById("help-button").addEventListener("click", () => dialog.showModal());
  return dialog;
}

function start() {
  const sections = JSON.parse(document.getElementById("contents").textContent);
  const page = document.getElementById("page");
  const able = [];
  for (const section of sections) {
    const heading = el("h2", { id: `${section.id}-title` }, section.title);
    const place = el("section", { id: section.id, "aria-labelledby": heading.id, class: `kind-${section.kind}` }, heading);
    page.append(place);
    const made = kinds[section.kind](place, section.data ?? section, section);
    if (made?.keys) able.push({ place, keys: made.keys });
  }
  const dialog = help();
  document.addEventListener("keydown", (event) => {
    const { target, key } = event;
    const types = target instanceof Element
      && target.matches("textarea, select, input:not([type=range]):not([type=checkbox])");
    if (types || event.ctrlKey || event.altKey || event.metaKey || dialog.open || event.defaultPrevented) return;
    if (key === "?") {
      event.preventDefault();
      dialog.showModal();
      return;
    }
    // The section with the focus, otherwise the first that knows the key.
    const inside = able.filter(({ place }) => place.contains(target));
    const found = [...inside, ...able].find(({ keys }) => Object.hasOwn(keys, key));
    if (!found) return;
    event.preventDefault();
    found.keys[key]();
  });
  performance.mark("ready");
  document.documentElement.dataset.ready = "yes";
}

// One pixel: its fragments, what became of each, the colours, and the absorbance.

const MARKS = {
  kept: "\u25cf", merged: "\u25d0", culled: "\u25cb", evicted: "\u21e5", dropped: "\u2715", lost: "\u26a0",
  "not-kept": "\u2013",
};

/** A fate in a cell: with its record, `?` if that is not known. */
function fateText({ fate, reason, record }, { records }) {
  if (fate === "dropped" && reason) return `${fate}: ${reason}`;
  if (record !== null) return reason ? `${fate} ${record}?` : `${fate} ${record}`;
  return fate === "merged" && records.length > 0 ? `${fate} ?` : fate;
}

/** `3 kept, 2 evicted`. */
function sums({ fates }) {
  const order = ["kept", "merged", "culled", "evicted", "dropped", "lost", "not-kept"];
  return order.map((name) => [fates.filter(({ fate }) => fate === name).length, name])
    .filter(([count]) => count > 0).map(([count, name]) => `${count} ${name}`).join(", ");
}

function swatch([r, g, b], opacity = 1) {
  const patch = el("span", { class: "swatch", "aria-hidden": "true" });
  patch.style.backgroundColor = `rgb(${r} ${g} ${b} / ${opacity})`;
  return patch;
}

/** The picture shows linear colours as they look. */
function srgb(linear) {
  return linear.slice(0, 3).map((byte) => {
    const c = byte / 255;
    return Math.round(255 * (c <= 0.0031308 ? 12.92 * c : 1.055 * c ** (1 / 2.4) - 0.055));
  });
}

/** A table whose columns stand right where all of them are numbers. */
function grid(caption, heads, rows, look) {
  if (rows.length === 0) return null;
  const right = heads.map((_, i) => rows.every((row) => typeof row[i] === "string" && /^-?[\d.]+$/.test(row[i])));
  const side = (i) => (right[i] ? "number" : "word");
  return el("div", { class: "scrolled", tabindex: "0", role: "region", "aria-label": caption },
    el("table", { class: look }, el("caption", {}, caption),
      el("thead", {}, el("tr", {}, heads.map((head, i) => el("th", { scope: "col", class: side(i) }, head)))),
      el("tbody", {}, rows.map((row) => el("tr", {}, row.map((cell, i) => el("td", { class: side(i) }, cell)))))));
}

function fragmentsTable({ fragments, methods }) {
  const heads = ["#", "object", ...methods.map(({ title }) => title),
    "distance", "r g b a", "opacity", "depth", "triangle"];
  const fates = ({ index }) => methods.map((method) => {
    const fate = method.fates[index];
    if (!fate) return "-";
    const mark = el("span", { class: "mark", "aria-hidden": "true" }, MARKS[fate.fate] ?? "");
    return el("span", { class: `fate fate-${fate.fate}`, title: fate.reason }, mark, fateText(fate, method));
  });
  const rows = fragments.map((fragment) => [
    String(fragment.index), fragment.object ?? "-", ...fates(fragment), fragment.distance.toFixed(6),
    [swatch(srgb(fragment.rgba), fragment.rgba[3] / 255), fragment.rgba.join(" ")],
    (fragment.rgba[3] / 255).toFixed(4), String(fragment.depth), String(fragment.triangle),
  ]);
  return grid("Fragments, front to back", heads, rows, "fragments");
}

function methodsTable({ exact, methods }) {
  const rgb = (color) => [swatch(color), color.slice(0, 3).join(" ")];
  const rows = [["all fragments", rgb(exact.color), "", exact.absorbed.toFixed(6), ""]];
  for (const method of methods) {
    rows.push([method.title, rgb(method.color), String(method.difference), method.absorbed.toFixed(6), sums(method)]);
  }
  return grid("Colours", ["method", "r g b", "by at most", "absorbed", "fates"], rows, "colours");
}

function recordsTable({ title, records }) {
  const heads = ["#", "depth", "distance", "thickness", "r", "g", "b", "opacity", "weight"];
  const rows = records.map(({ depth, distance, thickness, rgba, weight }, place) => [
    String(place), String(depth), distance.toFixed(6), thickness.toFixed(6),
    ...rgba.map((channel) => channel.toFixed(6)), String(weight)]);
  return grid(`Records of ${title}`, heads, rows, "records");
}

function extraTable({ title, extra }) {
  const rows = extra.map(({ what, depth, distance, data }) =>
    [what, String(depth), distance.toFixed(6), data.toString(16).padStart(8, "0")]);
  return grid(`Not generated, but in the list of ${title}`, ["", "depth", "distance", "data"], rows, "extra");
}

/** What is known of fates besides their names, once for each method. */
function reasons({ methods }) {
  const notes = methods.flatMap(({ title, fates }) => fates.filter(({ reason }) => reason)
    .map(({ fate, record, reason }) => `${title}, ${fate}${record === null ? "" : ` ${record}`}: ${reason}`));
  return [...new Set(notes)].map((note) => el("p", { class: "note" }, note));
}

/** The panel of a picture's pixels; `moved` is told of pixels that are typed. */
function inspector(place, size, about, moved) {
  const pixels = new Pixels(size, about);
  let shown = null;
  let wanted = 0;
  const typed = ["x", "y"].map((name, axis) => el("input", {
    type: "number", min: "0", max: String(size[axis] - 1), step: "1", inputmode: "numeric",
    "aria-label": axis === 0 ? "column of the pixel" : "row of the pixel",
    onchange: () => moved(typed.map((input, i) =>
      Math.min(Math.max(Math.round(Number(input.value) || 0), 0), size[i] - 1))),
  }));
  const status = el("p", { class: "status", role: "status" }, "Click on a picture, or press Enter in it, to look at a pixel.");
  const result = el("div", { class: "found" });
  const json = exported("Pixel as JSON", "pixel.json", "application/json", () => {
    const told = (method) => Object.fromEntries(Object.entries(method).filter(([name]) => name !== "title"));
    return shown ? `${JSON.stringify({ ...shown, methods: shown.methods.map(told) }, null, 2)}\n` : "";
  });
  place.append(
    el("h3", {}, "Pixel"),
    el("div", { class: "controls" }, el("label", {}, "x ", typed[0]), el("label", {}, "y ", typed[1]), json.button),
    json.box, status, result);

  async function show([x, y]) {
    [typed[0].value, typed[1].value] = [x, y];
    const own = ++wanted;
    status.textContent = `Reading pixel ${x},${y}.`;
    try {
      const found = await pixels.pixel(x, y);
      if (own !== wanted) return;
      shown = found;
      const count = found.fragments.length;
      status.textContent = `Pixel ${x},${y}: ${count === 1 ? "1 fragment" : `${thousands(count)} fragments`}, `
        + `depth words ${found.depth_format}.`;
      result.replaceChildren(...[
        fragmentsTable(found), methodsTable(found), ...found.methods.map(recordsTable),
        ...found.methods.map(extraTable), ...reasons(found), plot(found),
      ].filter((part) => part !== null));
      json.refresh();
      result.dataset.pixel = `${x},${y}`;
    } catch (error) {
      if (own !== wanted) return;
      status.textContent = `Pixel ${x},${y} cannot be read: ${error.message}`;
      result.replaceChildren();
    }
  }
  return { show };
}

// The absorbance along a pixel's ray: the exact one, and each method's over it.

const PLOT = { width: 640, height: 320, left: 52, right: 12, top: 12, bottom: 44 };
const DASHES = ["none", "7 3", "2 3", "9 3 2 3", "4 2", "12 4"];
const MARGIN = 0.05;

/** Round steps of an axis, about `count` of them. */
function ticks(low, high, count) {
  const rough = (high - low) / count;
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].map((factor) => factor * power).find((wide) => wide >= rough) ?? rough;
  const found = [];
  for (let i = Math.ceil(low / step); i * step <= high; i++) found.push(Number((i * step).toPrecision(12)));
  return found;
}

function plot(found) {
  const corners = [found.exact, ...found.methods].flatMap(({ absorbance }) => absorbance);
  if (corners.length === 0) return el("p", { class: "note" }, "There is nothing on this pixel's ray.");
  const distances = corners.map(([x]) => x);
  let [near, far] = [Math.min(...distances), Math.max(...distances)];
  const span = far > near ? far - near : Math.max(Math.abs(far), MARGIN);
  [near, far] = [near - MARGIN * span, far + MARGIN * span];
  const { width, height, left, right, top, bottom } = PLOT;
  const x = (value) => left + (value - near) / (far - near) * (width - left - right);
  const y = (value) => height - bottom - value * (height - top - bottom);
  const line = (points, number) => svg("polyline", {
    class: `curve curve-${number % 7}`, fill: "none",
    "stroke-dasharray": number === 0 ? "none" : DASHES[(number - 1) % DASHES.length],
    points: points.map(([a, b]) => `${x(a).toFixed(2)},${y(b).toFixed(2)}`).join(" "),
  });
  const steps = (absorbance) => [[near, 0], ...absorbance, [far, absorbance.at(-1)?.[1] ?? 0]];
  const methods = found.methods.map(({ absorbance, absorbed }, i) => {
    // Of a colour only what is absorbed in all is known.
    const alone = absorbance.length === 0 && absorbed > 0;
    return line(alone ? [[far - (far - near) * MARGIN, absorbed], [far, absorbed]] : steps(absorbance), i + 1);
  });
  const text = (a, b, anchor, label) => svg("text", { x: a, y: b, "text-anchor": anchor }, label);
  const axes = [
    ...ticks(near, far, 6).map((value) => svg("g", { class: "tick" },
      svg("line", { x1: x(value), x2: x(value), y1: y(0), y2: y(1) }),
      text(x(value), y(0) + 16, "middle", String(value)))),
    ...[0, 0.25, 0.5, 0.75, 1].map((value) => svg("g", { class: "tick" },
      svg("line", { x1: x(near), x2: x(far), y1: y(value), y2: y(value) }),
      text(left - 6, y(value) + 4, "end", String(value)))),
    text((left + width - right) / 2, height - 8, "middle", "eye distance (world units)"),
  ];
  const names = ["exact", ...found.methods.map(({ title }) => title)];
  const legend = names.map((name, number) => el("li", {},
    svg("svg", { viewBox: "0 0 40 10", width: "40", height: "10", "aria-hidden": "true" },
      svg("line", {
        class: `curve curve-${number % 7}`, x1: "0", x2: "40", y1: "5", y2: "5",
        "stroke-dasharray": number === 0 ? "none" : DASHES[(number - 1) % DASHES.length],
      })), name));
  const [px, py] = found.pixel;
  return el("figure", { class: "plot" },
    svg("svg", {
      viewBox: `0 0 ${width} ${height}`, role: "img",
      "aria-label": `absorbance by eye distance at pixel ${px},${py}`,
    }, axes, line(steps(found.exact.absorbance), 0), methods),
    el("figcaption", {}, "Absorbance (1 - transmittance) along the ray"),
    el("ul", { class: "legend" }, legend));
}

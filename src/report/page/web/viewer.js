// Pictures of one size that are zoomed together, two at a time under a slider.

const MOST_ZOOM = 64;

function pictures(place, { size, pictures: all, pixels }) {
  const [width, height] = size;
  const plain = all.map((_, i) => i).filter((i) => !all[i].map);
  const state = { zoom: 1, x: width / 2, y: height / 2, left: plain[0], right: plain[1] ?? plain[0], split: 50, pixel: null };
  const sources = all.map(({ data }) => `data:image/png;base64,${attached(data)}`);
  const panels = [];

  /** A picture in a frame, with a mark at the pixel. */
  function panel(i) {
    const image = el("img", { src: sources[i], alt: all[i].name, draggable: "false", decoding: "async" });
    const mark = el("div", { class: "cursor", hidden: true, "aria-hidden": "true" });
    const frame = el("div", { class: "panel" }, image, mark);
    frame.style.aspectRatio = `${width} / ${height}`;
    panels.push({ frame, images: [image], mark });
    reach(frame);
    return frame;
  }

  // The stage: the left picture, and the right one over it, cut off at the line.
  const layers = [0, 1].map(() => el("img", { alt: "", draggable: "false", decoding: "async" }));
  const cut = el("div", { class: "cut" }, layers[1]);
  const line = el("div", { class: "line", "aria-hidden": "true" }, el("span", {}, "\u21c6"));
  const mark = el("div", { class: "cursor", hidden: true, "aria-hidden": "true" });
  const stage = el("div", {
    class: "panel stage", tabindex: "0", role: "application", "aria-roledescription": "pictures",
    "aria-label": "Two pictures under a slider. Arrow keys move the pixel, + and - zoom.", onkeydown: pressed,
  }, layers[0], cut, mark, line);
  stage.style.aspectRatio = `${width} / ${height}`;
  panels.push({ frame: stage, images: layers, mark });
  // A click on the line is one on the picture below it.
  const placeOnStage = reach(stage);
  line.addEventListener("pointerdown", (event) => {
    if (event.button !== 0) return;
    line.setPointerCapture(event.pointerId);
    event.stopPropagation();
    let dragged = false;
    line.onpointermove = (moved) => {
      dragged ||= Math.abs(moved.clientX - event.clientX) >= 4;
      if (!dragged) return;
      const { left, width: wide } = stage.getBoundingClientRect();
      state.split = Math.min(Math.max((moved.clientX - left) / wide * 100, 0), 100);
      show();
    };
    line.onpointerup = (end) => {
      end.stopPropagation();
      line.onpointermove = null;
      if (!dragged) choose(placeOnStage(end), false);
    };
  });

  const choice = (label, side) => {
    const select = el("select", { onchange: () => { state[side] = Number(select.value); show(); } },
      plain.map((i) => el("option", { value: String(i) }, all[i].name)));
    return { select, label: el("label", {}, `${label} `, select) };
  };
  const [left, right] = [choice("Left", "left"), choice("Right", "right")];
  const slider = el("input", {
    type: "range", min: "0", max: "100", step: "0.5", class: "slider", "aria-label": "where the left picture ends",
    oninput: () => { state.split = Number(slider.value); show(); },
  });
  const zoomed = el("output", { class: "zoomed" });
  const button = (label, text, act) => el("button", { type: "button", class: "control", "aria-label": label, onclick: act }, text);
  const below = pixels ? el("div", { class: "inspector" }) : null;
  const look = pixels ? inspector(below, size, pixels, (pixel) => choose(pixel)) : null;

  place.append(el("div", { class: pixels ? "viewer beside" : "viewer" },
    el("div", { class: "looks" },
      el("div", { class: "controls" }, left.label, right.label,
        button("zoom out", "\u2212", () => zoom(0.5)), button("zoom in", "+", () => zoom(2)),
        button("show all", "0", () => zoom(0)), zoomed),
      stage, slider,
      el("p", { class: "under" }, el("span", { class: "name-left" }), el("span", { class: "name-right" })),
      el("div", { class: "gallery" }, all.map(({ name, map }, i) =>
        el("figure", {}, panel(i), el("figcaption", {}, name, map ? el("small", {}, ` ${map}`) : null))))),
    below ?? []));
  const names = place.querySelectorAll(".under span");

  /** Where the picture's corner lies, in per cent of a panel. */
  function corner() {
    const at = (centre, whole) => Math.min(Math.max(50 - state.zoom * centre / whole * 100, 100 - 100 * state.zoom), 0);
    return [at(state.x, width), at(state.y, height)];
  }

  function show() {
    const [tx, ty] = corner();
    for (const { images, mark: cursor } of panels) {
      for (const image of images) image.style.transform = `translate(${tx}%, ${ty}%) scale(${state.zoom})`;
      cursor.hidden = state.pixel === null;
      if (state.pixel) {
        const [x, y] = state.pixel;
        cursor.style.left = `${tx + x / width * 100 * state.zoom}%`;
        cursor.style.top = `${ty + y / height * 100 * state.zoom}%`;
        cursor.style.width = `${100 / width * state.zoom}%`;
        cursor.style.height = `${100 / height * state.zoom}%`;
      }
    }
    layers.forEach((layer, i) => {
      const shown = [state.left, state.right][i];
      if (layer.dataset.shown !== String(shown)) {
        layer.dataset.shown = String(shown);
        layer.src = sources[shown];
        layer.alt = all[shown].name;
      }
    });
    left.select.value = String(state.left);
    right.select.value = String(state.right);
    names[0].textContent = `\u25c0 ${all[state.left].name}`;
    names[1].textContent = `${all[state.right].name} \u25b6`;
    cut.style.clipPath = `inset(0 0 0 ${state.split}%)`;
    line.style.left = `${state.split}%`;
    slider.value = String(state.split);
    slider.setAttribute("aria-valuetext", `${all[state.left].name} to ${Math.round(state.split)} %, then ${all[state.right].name}`);
    zoomed.textContent = `${state.zoom}\u00d7`;
  }

  /** Zoom by a factor, or to the whole picture, around a place of the picture. */
  function zoom(factor, around = null) {
    const before = state.zoom;
    state.zoom = factor === 0 ? 1 : Math.min(Math.max(state.zoom * factor, 1), MOST_ZOOM);
    const centre = around ?? (state.pixel && factor > 1 && before === 1 ? state.pixel.map((c) => c + 0.5) : null);
    if (around) {
      const keep = before / state.zoom;
      state.x = around[0] + (state.x - around[0]) * keep;
      state.y = around[1] + (state.y - around[1]) * keep;
    } else if (centre) [state.x, state.y] = centre;
    settle();
    show();
  }

  /** The centre stays where it can be seen. */
  function settle() {
    const at = (centre, whole) => Math.min(Math.max(centre, whole / 2 / state.zoom), whole - whole / 2 / state.zoom);
    [state.x, state.y] = [at(state.x, width), at(state.y, height)];
  }

  function choose(pixel, follow = true) {
    state.pixel = pixel;
    if (follow) {
      const half = [width / 2 / state.zoom, height / 2 / state.zoom];
      pixel.forEach((c, axis) => {
        const name = ["x", "y"][axis];
        state[name] = Math.min(Math.max(state[name], c + 1 - half[axis]), c + half[axis]);
      });
      settle();
    }
    show();
    look?.show(pixel);
  }

  /** Clicks, drags and wheels on a panel; gives the pixel that an event is at. */
  function reach(frame) {
    const placeOf = ({ clientX, clientY }) => {
      const box = frame.getBoundingClientRect();
      const [tx, ty] = corner();
      const at = (client, start, long, t, whole) => ((client - start) / long * 100 - t) / (100 * state.zoom) * whole;
      return [at(clientX, box.left, box.width, tx, width), at(clientY, box.top, box.height, ty, height)];
    };
    const pixelOf = (event) =>
      placeOf(event).map((c, axis) => Math.min(Math.max(Math.floor(c), 0), size[axis] - 1));
    let from = null;
    frame.addEventListener("pointerdown", (event) => {
      if (event.button !== 0) return;
      frame.setPointerCapture(event.pointerId);
      from = { x: event.clientX, y: event.clientY, centre: [state.x, state.y], dragged: false };
    });
    frame.addEventListener("pointermove", (event) => {
      if (!from) return;
      const [dx, dy] = [event.clientX - from.x, event.clientY - from.y];
      if (!from.dragged && Math.hypot(dx, dy) < 4) return;
      from.dragged = true;
      const box = frame.getBoundingClientRect();
      state.x = from.centre[0] - dx / box.width * width / state.zoom;
      state.y = from.centre[1] - dy / box.height * height / state.zoom;
      settle();
      show();
    });
    frame.addEventListener("pointerup", (event) => {
      if (from && !from.dragged) {
        choose(pixelOf(event), false);
      }
      from = null;
    });
    frame.addEventListener("pointercancel", () => { from = null; });
    // Without the focus, the wheel scrolls the page.
    frame.addEventListener("wheel", (event) => {
      if (!event.ctrlKey && document.activeElement !== stage) return;
      event.preventDefault();
      zoom(event.deltaY < 0 ? 1.25 : 0.8, placeOf(event));
    }, { passive: false });
    return pixelOf;
  }

  const ARROWS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
  function pressed(event) {
    if (event.ctrlKey || event.altKey || event.metaKey) return;
    const step = ARROWS[event.key];
    if (!step && event.key !== "Enter") return;
    event.preventDefault();
    const start = state.pixel ?? [Math.floor(state.x), Math.floor(state.y)];
    const far = event.shiftKey ? 10 : 1;
    const to = step && state.pixel ? start.map((c, axis) => c + step[axis] * far) : start;
    choose(to.map((c, axis) => Math.min(Math.max(c, 0), size[axis] - 1)));
  }

  /** Keys that work everywhere on the page. */
  const turn = (side, by) => {
    const at = plain.indexOf(state[side]);
    state[side] = plain[(at + by + plain.length) % plain.length];
    show();
  };
  const keys = {
    "+": () => zoom(2), "=": () => zoom(2), "-": () => zoom(0.5), 0: () => zoom(0),
    "]": () => turn("right", 1), "[": () => turn("right", -1), "}": () => turn("left", 1), "{": () => turn("left", -1),
  };
  show();
  return { keys };
}

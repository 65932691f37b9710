// Reading blocks of pixels: see block.rs for what is in them. A pixel comes as the document of `inspect --json`.

const KEPT_BLOCKS = 16;
const HEAD_STREAMS = 5;
const METHOD_STREAMS = 7;

/** Bytes that are read from the front. */
class Stream {
  constructor(bytes) {
    this.bytes = bytes;
    this.view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
    this.at = 0;
  }

  get some() {
    return this.bytes.length > 0;
  }

  /** LEB128. */
  number() {
    for (let value = 0, shift = 0; ; shift += 7) {
      const byte = this.bytes[this.at++];
      value |= (byte & 0x7f) << shift;
      if (byte < 0x80) return value >>> 0;
    }
  }

  /** A wrapped difference of u32. */
  apart() {
    const value = this.number();
    return (value >>> 1) ^ -(value & 1);
  }

  word() {
    this.at += 4;
    return this.view.getUint32(this.at - 4, true);
  }

  real() {
    this.at += 8;
    return this.view.getFloat64(this.at - 8, true);
  }
}

function streamsOf(bytes) {
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  const count = view.getUint32(0, true);
  const streams = [];
  let at = 4 + 4 * count;
  for (let i = 0; i < count; i++) {
    const length = view.getUint32(4 + 4 * i, true);
    streams.push(new Stream(bytes.subarray(at, at + length)));
    at += length;
  }
  return streams;
}

/** Words whose bytes lie in four planes. */
function planes({ bytes }) {
  const count = bytes.length / 4;
  return Uint32Array.from({ length: count }, (_, i) => (bytes[i] | bytes[i + count] << 8
    | bytes[i + 2 * count] << 16 | bytes[i + 3 * count] << 24) >>> 0);
}

const rgbaOf = (word) => [word & 255, word >>> 8 & 255, word >>> 16 & 255, word >>> 24];

/** The words of a block's fragments, and where each pixel's begin. */
function readFragments([counts, triangles, depths, colors, exact], across, down) {
  const pixels = across * down;
  const starts = new Uint32Array(pixels + 1);
  for (let p = 0; p < pixels; p++) starts[p + 1] = starts[p] + counts.number();
  const all = starts[pixels];
  const found = { starts, triangle: new Uint32Array(all), depth: new Uint32Array(all), color: planes(colors) };
  const seen = new Map();
  const { triangle, depth, color } = found;
  for (let p = 0; p < pixels; p++) {
    const other = p % across > 0 ? p - 1 : p - across;
    const others = other >= 0 ? starts[other + 1] - starts[other] : 0;
    for (let i = 0, f = starts[p]; f < starts[p + 1]; i++, f++) {
      const beside = i < others ? triangle[starts[other] + i] : (i > 0 ? triangle[f - 1] : 0);
      triangle[f] = beside + triangles.apart();
      const known = seen.get(triangle[f]);
      const earlier = known && known.number < p ? known : null;
      const guess = earlier ? earlier.depth + earlier.slope : (i > 0 ? depth[f - 1] : 0);
      depth[f] = guess + depths.apart();
      if (earlier) color[f] ^= earlier.color;
      if (!known) seen.set(triangle[f], { number: p, depth: depth[f], slope: 0, color: color[f] });
      else if (earlier) {
        known.slope = depth[f] - known.depth;
        known.number = p;
        known.depth = depth[f];
        known.color = color[f];
      }
    }
  }
  found.exact = planes(exact);
  for (let p = 1; p < pixels; p++) found.exact[p] ^= found.exact[p - 1];
  return found;
}

/** What one method made of them, by pixel. */
function readMethod([words, fates, parts, picture, records, extra, absorbed], { starts, exact }) {
  const told = JSON.parse(new TextDecoder().decode(words.bytes));
  const colors = planes(picture);
  return Array.from(exact, (color, p) => {
    const own = { fates: [], records: [], extra: [], color: rgbaOf((colors[p] ^ color) >>> 0), absorbed: null };
    for (let f = starts[p]; f < starts[p + 1]; f++) {
      const [fate, reason] = fates.some ? told[fates.number()] : [];
      const part = parts.some ? parts.number() : 0;
      own.fates.push({ fate, reason, record: part > 0 ? part - 1 : null });
    }
    for (let n = records.some ? records.number() : 0; n > 0; n--) {
      const depth = records.word();
      const [thickness, r, g, b, a, weight] = Array.from({ length: 6 }, () => records.real());
      own.records.push({ depth, thickness, rgba: [r, g, b, a], weight });
    }
    for (let n = extra.some ? extra.number() : 0; n > 0; n--) {
      const what = extra.word() === 1 ? "torn" : "duplicated";
      own.extra.push({ what, depth: extra.word(), data: extra.word(), color: extra.word() });
    }
    if (absorbed.some) own.absorbed = absorbed.real();
    return own;
  });
}

/** The pixels of a picture whose blocks are attached. */
class Pixels {
  constructor([width, height], about) {
    Object.assign(this, { width, height, about, kept: new Map() });
  }

  /** A block, of which the latest few are kept. */
  block(number) {
    let block = this.kept.get(number);
    this.kept.delete(number);
    block ??= this.read(number);
    this.kept.set(number, block);
    for (const old of this.kept.keys()) {
      if (this.kept.size <= KEPT_BLOCKS) break;
      this.kept.delete(old);
    }
    return block;
  }

  async read(number) {
    const { edge, blocks, methods } = this.about;
    const columns = Math.ceil(this.width / edge);
    const [x, y] = [number % columns * edge, Math.floor(number / columns) * edge];
    const across = Math.min(edge, this.width - x);
    const down = Math.min(edge, this.height - y);
    const streams = streamsOf(await unpacked(blocks[number]));
    const fragments = readFragments(streams.slice(0, HEAD_STREAMS), across, down);
    const method = (_, i) => {
      const from = HEAD_STREAMS + METHOD_STREAMS * i;
      return readMethod(streams.slice(from, from + METHOD_STREAMS), fragments);
    };
    return { x, y, across, fragments, methods: methods.map(method) };
  }

  /** From the eye's plane along the line of sight, in world units. */
  distance(word) {
    const { depth_format: format, near, far, parallel } = this.about;
    const code = { d32: () => word, d24: () => word * 256 + 127.5, f32: () => floatOf(word) }[format]();
    const z = Math.min(code / 4294967295, 1);
    return parallel ? near + z * (far - near) : (near * far) / (far - z * (far - near));
  }

  object(triangle) {
    const { objects, ends, solids } = this.about;
    let [low, high] = [0, ends.length];
    while (low < high) {
      const middle = (low + high) >> 1;
      if (ends[middle] <= triangle) low = middle + 1;
      else high = middle;
    }
    return low < ends.length ? objects[solids[low]] : null;
  }

  /** Everything about a pixel. */
  async pixel(x, y) {
    const { edge, scene, background, depth_format } = this.about;
    const columns = Math.ceil(this.width / edge);
    const block = await this.block(Math.floor(y / edge) * columns + Math.floor(x / edge));
    const p = (y - block.y) * block.across + x - block.x;
    const { starts, triangle, depth, color, exact } = block.fragments;
    const fragments = Array.from({ length: starts[p + 1] - starts[p] }, (_, index) => {
      const f = starts[p] + index;
      return {
        index, object: this.object(triangle[f]), triangle: triangle[f], depth: depth[f],
        distance: this.distance(depth[f]), rgba: rgbaOf(color[f]),
      };
    });
    const surface = ({ distance, rgba }) => ({ near: distance, far: distance, opacity: rgba[3] / 255 });
    const answer = { color: rgbaOf(exact[p]), ...along(fragments.map(surface)) };
    const methods = this.about.methods.map((method, i) =>
      this.inspected(method, block.methods[i][p], fragments, answer));
    return {
      pixel: [x, y], scene, width: this.width, height: this.height, background, depth_format,
      fragments, exact: answer, methods,
    };
  }

  /** What one method makes of a pixel. */
  inspected({ title, method, exec, k, holds, data, warnings, violations }, own, fragments, exact) {
    const difference = Math.max(...own.color.map((c, i) => Math.abs(c - exact.color[i])));
    const records = own.records.map((record) => ({
      depth: record.depth, distance: this.distance(record.depth), thickness: record.thickness,
      rgba: record.rgba, weight: record.weight,
    }));
    const extra = own.extra.map(({ what, depth, data: word }) =>
      ({ what, depth, distance: this.distance(depth), data: word }));
    let light = { absorbed: own.absorbed ?? 0, absorbance: [] };
    if (holds === "records") {
      light = along(records.map(({ distance, thickness, rgba }) => {
        const begin = distance - thickness;
        const near = Number.isFinite(begin) && begin < distance ? begin : distance;
        return { near, far: distance, opacity: share(rgba[3]) };
      }));
    } else if (holds === "fragments") {
      // The method's list: the kept fragments, and what it holds besides, in the order of its words.
      const kept = fragments.filter((_, i) => own.fates[i].fate === "kept").map((fragment) => {
        const [r, g, b, a] = fragment.rgba;
        const color = data === "none" ? 0 : (r | g << 8 | b << 16 | a << 24) >>> 0;
        return { depth: fragment.depth, word: data === "primitive" ? fragment.triangle : color, color };
      });
      const others = own.extra.map(({ depth, data: word, color }) => ({ depth, word, color }));
      const list = [...kept, ...others].sort((a, b) => a.depth - b.depth || a.word - b.word);
      light = along(list.map(({ depth, color }) => {
        const distance = this.distance(depth);
        return { near: distance, far: distance, opacity: (color >>> 24) / 255 };
      }));
    }
    return {
      method, exec, k, color: own.color, difference, absorbed: light.absorbed, records, fates: own.fates,
      extra, absorbance: light.absorbance, warnings, violations, title,
    };
  }
}

function floatOf(word) {
  const view = new DataView(new ArrayBuffer(4));
  view.setUint32(0, word);
  return view.getFloat32(0);
}

const share = (x) => (Number.isNaN(x) ? 0 : Math.min(Math.max(x, 0), 1));

/** The corners of the absorbance along slabs that end ever farther from the eye, and what they absorb together. */
function along(slabs) {
  const absorbance = [];
  let [light, reached] = [1, -Number.MAX_VALUE];
  for (const { near, far, opacity } of slabs) {
    absorbance.push([Math.max(near, reached), 1 - light]);
    reached = Math.max(far, reached);
    light *= 1 - opacity;
    absorbance.push([reached, 1 - light]);
  }
  return { absorbed: 1 - light, absorbance };
}

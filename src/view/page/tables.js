"use strict";
// Tables: from the text of the page to numbers, axes, and the two ways to look a value up.

const DATA = JSON.parse(document.getElementById("data").textContent);

function bytesOf(text) {
  return Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
}

function halfToNumber(bits) {
  const sign = bits & 0x8000 ? -1 : 1;
  const exponent = (bits >> 10) & 31;
  const fraction = bits & 1023;
  if (exponent === 31) return fraction ? NaN : sign * Infinity;
  return sign * (exponent ? 2 ** (exponent - 15) * (1 + fraction / 1024) : 2 ** -24 * fraction);
}

function numbersOf(text, storage) {
  const view = new DataView(bytesOf(text).buffer);
  const size = storage === "f16" ? 2 : 4;
  const at = (i) => (storage === "f16" ? halfToNumber(view.getUint16(2 * i, true)) : view.getFloat32(4 * i, true));
  return Float32Array.from({ length: view.byteLength / size }, (_, i) => at(i));
}

// The mappings of the library's axes, there and back.
const MAPPINGS = {
  "sqrt-mu": [Math.sqrt, (u) => u * u],
  sqrt: [Math.sqrt, (u) => u * u],
  log1p: [Math.log1p, Math.expm1],
};

function coordinate(axis, value) {
  const [there] = MAPPINGS[axis.mapping];
  return (there(value) - there(axis.min)) / (there(axis.max) - there(axis.min));
}

function valueAt(axis, u) {
  const [there, back] = MAPPINGS[axis.mapping];
  const value = back(there(axis.min) + u * (there(axis.max) - there(axis.min)));
  return Math.min(Math.max(value, axis.min), axis.max);
}

const clamp = (value, low, high) => Math.min(Math.max(value, low), high);

// Values on a grid whose texels sit at the ends of both axes.
class Grid {
  constructor(data, width, height, channels) {
    Object.assign(this, { data, width, height, channels });
  }

  at(x, y, channel) {
    return this.data[(y * this.width + x) * this.channels + Math.min(channel, this.channels - 1)];
  }

  // The lookup of a shader: linear between neighbours.
  linear(u, v, channel) {
    const [px, py] = [clamp(u, 0, 1) * (this.width - 1), clamp(v, 0, 1) * (this.height - 1)];
    const [x, y] = [Math.min(Math.floor(px), Math.max(this.width - 2, 0)), Math.min(Math.floor(py), this.height - 2)];
    const [wx, wy] = [px - x, py - y];
    const right = Math.min(x + 1, this.width - 1);
    const row = (j) => (1 - wx) * this.at(x, j, channel) + wx * this.at(right, j, channel);
    return (1 - wy) * row(y) + wy * row(y + 1);
  }

  // The same through four neighbours along each axis, for the reference, whose points lie densely.
  cubic(u, v, channel) {
    const [xs, wx] = Grid.stencil(clamp(u, 0, 1), this.width);
    const [ys, wy] = Grid.stencil(clamp(v, 0, 1), this.height);
    let sum = 0;
    ys.forEach((y, j) => xs.forEach((x, i) => (sum += wy[j] * wx[i] * this.at(x, y, channel))));
    return sum;
  }

  static stencil(u, count) {
    if (count === 1) return [[0], [1]];
    const place = u * (count - 1);
    const first = clamp(Math.floor(place) - 1, 0, count - 4);
    const nodes = [0, 1, 2, 3].map((i) => first + i);
    const weight = (i) => nodes.reduce((w, node) => (node === i ? w : (w * (place - node)) / (i - node)), 1);
    return [nodes, nodes.map(weight)];
  }
}

const decoded = new Map();

// Decodes once.
function grid(key, text, storage, width, height, channels) {
  if (!decoded.has(key)) decoded.set(key, new Grid(numbersOf(text, storage), width, height, channels));
  return decoded.get(key);
}

// A table of `size` in `storage`: albedos, and their means over the roughness.
function tableOf(surface, sheet, size, storage) {
  const about = DATA.surfaces[surface].sheets[sheet];
  const [albedo, mean] = about.tables[DATA.sizes.indexOf(size)][storage];
  const key = [surface, sheet, size, storage].join();
  return {
    albedo: grid(key, albedo, storage, size, size, about.channels),
    mean: grid(key + "m", mean, storage, 1, size, about.channels),
  };
}

// What the library computed between the texels of all of them.
function referenceOf(surface, sheet) {
  const { channels, reference } = DATA.surfaces[surface].sheets[sheet];
  const key = [surface, sheet].join();
  const [width, height] = reference.size;
  return {
    albedo: grid(key, reference.albedo, "f32", width, height, channels),
    mean: grid(key + "m", reference.mean, "f32", 1, height, channels),
  };
}

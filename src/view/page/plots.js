// Plots with axes, units and legends, as SVG: sharp at every size, and their text takes the page's font and colour.

const SVG = "http" + "://www.w3.org/2000/svg"; // a name, and no address
const FRAME = { width: 340, height: 280, left: 58, right: 12, top: 24, bottom: 42 };

function element(parent, name, attributes, text) {
  const node = document.createElementNS(SVG, name);
  for (const [key, value] of Object.entries(attributes)) node.setAttribute(key, value);
  if (text !== undefined) node.textContent = text;
  parent.append(node);
  return node;
}

// Round numbers that divide [low, high] into about `count` steps.
function ticks(low, high, count) {
  const rough = (high - low) / count;
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 2.5, 5, 10].find((factor) => factor * power >= rough * 0.999) * power;
  const first = Math.ceil(low / step - 1e-9);
  const last = Math.floor(high / step + 1e-9);
  const digits = Math.max(0, -Math.floor(Math.log10(step) + 1e-9) + (step / 10 ** Math.floor(Math.log10(step) + 1e-9) === 2.5 ? 1 : 0));
  return Array.from({ length: last - first + 1 }, (_, i) => [(first + i) * step, ((first + i) * step).toFixed(digits)]);
}

// Round values of an axis of roughness, as many as have room.
function marksOf(axis) {
  const round = [-3, -2, -1, 0, 1, 2, 3, 4, 5].flatMap((power) => [1, 2, 5].map((digit) => digit * 10 ** power));
  const inside = (values) => values.filter((value) => value >= axis.min * 0.9999 && value <= axis.max * 1.0001);
  const place = (value) => coordinate(axis, value);
  const chosen = [];
  // powers of ten first, the others where they leave room
  for (const value of [...inside([0, ...round.filter((_, i) => i % 3 === 0)]), ...inside(round)]) {
    if (chosen.every((other) => Math.abs(place(other) - place(value)) > 0.09)) chosen.push(value);
  }
  return chosen.map((value) => [place(value), String(Number(value.toPrecision(2)))]);
}

// A number with few digits.
function short(value) {
  const size = Math.abs(value);
  if (size === 0) return "0";
  if (size >= 1e3 && size < 1e5) return String(Math.round(value));
  if (size >= 1e5 || size < 1e-3) return value.toExponential(1).replace("e+", "e");
  return String(Number(value.toPrecision(3)));
}

// An empty plot with its axes; returns where data go.
function axes(svg, { xTicks, yTicks, xLabel, yLabel, x, y, right = FRAME.right }) {
  svg.replaceChildren();
  svg.setAttribute("viewBox", `0 0 ${FRAME.width} ${FRAME.height}`);
  const [left, top] = [FRAME.left, FRAME.top];
  const [width, height] = [FRAME.width - left - right, FRAME.height - top - FRAME.bottom];
  const px = (value) => left + width * x(value);
  const py = (value) => top + height * (1 - y(value));
  const data = element(svg, "g", {});
  const frame = element(svg, "g", { class: "axes" });
  for (const [value, text] of xTicks) {
    element(frame, "line", { x1: px(value), x2: px(value), y1: top + height, y2: top + height + 5 });
    element(frame, "text", { x: px(value), y: top + height + 18, "text-anchor": "middle" }, text);
  }
  for (const [value, text] of yTicks) {
    element(frame, "line", { x1: left - 5, x2: left, y1: py(value), y2: py(value) });
    element(frame, "text", { x: left - 8, y: py(value) + 4, "text-anchor": "end" }, text);
  }
  element(frame, "rect", { x: left, y: top, width, height, class: "frame" });
  element(frame, "text", { x: left + width / 2, y: FRAME.height - 8, "text-anchor": "middle" }, xLabel);
  const [cx, cy] = [11, top + height / 2];
  element(frame, "text", { x: cx, y: cy, "text-anchor": "middle", transform: `rotate(-90 ${cx} ${cy})` }, yLabel);
  return { data, frame, px, py, left, top, width, height };
}

// The furnace value against the angle: curves of the shader, points of the prediction.
function plotEnergy(svg, { strip, predicted, theta, isGrey }) {
  const values = [1, ...predicted.flatMap(([, value]) => value)];
  for (let i = 0; i < strip.length; i += 4) values.push(...strip.slice(i, i + 3));
  const finite = values.filter(Number.isFinite);
  let [low, high] = [Math.min(...finite), Math.max(...finite)];
  const room = Math.max(0.06 * (high - low), 0.005);
  [low, high] = [Math.max(low - room, low < 0.25 ? 0 : -Infinity, 0), high + room];
  const angles = [0, 15, 30, 45, 60, 75, 90].map((angle) => [angle, String(angle)]);
  const y = (value) => (value - low) / (high - low);
  const plot = axes(svg, {
    xTicks: angles,
    yTicks: ticks(low, high, 5),
    xLabel: "angle from the normal, degrees",
    yLabel: "furnace value",
    x: (value) => value / 90,
    y,
  });
  element(plot.data, "line", { class: "one", x1: plot.left, x2: plot.left + plot.width, y1: plot.py(1), y2: plot.py(1) });
  const at = plot.px(theta);
  element(plot.data, "line", { class: "chosen", x1: at, x2: at, y1: plot.top, y2: plot.top + plot.height });
  const names = isGrey ? ["grey"] : ["red", "green", "blue"];
  names.forEach((name, channel) => {
    const points = [];
    for (let i = 0; i < strip.length / 4; i++) {
      const value = strip[4 * i + channel];
      if (Number.isFinite(value)) points.push(`${plot.px(((i + 0.5) * 90) / (strip.length / 4)).toFixed(2)},${plot.py(value).toFixed(2)}`);
    }
    element(plot.data, "polyline", { class: `curve ${name}`, points: points.join(" ") });
    // the letter tells what the colour alone would not
    if (!isGrey) {
      const first = plot.py(predicted[0][1][channel]);
      element(plot.data, "text", { class: `letter ${name}`, x: plot.left + 5 + 10 * channel, y: first - 6 }, name[0].toUpperCase());
    }
    for (const [angle, value] of predicted) {
      element(plot.data, "circle", { class: `point ${name}`, cx: plot.px(angle), cy: plot.py(value[channel]), r: 2.4 });
    }
  });
}

// A map over (sqrt mu, roughness) with a scale beside it.
function plotMap(svg, { width, height, colour, axis, row, scale, label }) {
  const mus = [0, 0.05, 0.2, 0.5, 1].map((mu) => [mu, String(mu)]);
  const plot = axes(svg, {
    xTicks: mus,
    yTicks: marksOf(axis),
    xLabel: "mu, cosine of the angle",
    yLabel: axis.name,
    x: Math.sqrt,
    y: (u) => u,
    right: 80,
  });
  const image = { x: plot.left, y: plot.top, width: plot.width, height: plot.height, preserveAspectRatio: "none" };
  element(plot.data, "image", { ...image, href: imageOf(width, height, colour), class: "texels" });
  const at = plot.py(row);
  for (const kind of ["under", "over"]) {
    element(plot.data, "line", { class: `row ${kind}`, x1: plot.left, x2: plot.left + plot.width, y1: at, y2: at });
  }
  // the scale of colours
  const [x, barWidth] = [FRAME.width - 68, 12];
  const bar = { x, y: plot.top, width: barWidth, height: plot.height, preserveAspectRatio: "none" };
  element(plot.data, "image", { ...bar, href: imageOf(1, 128, (_, j) => scale.colour(j / 127)) });
  element(plot.frame, "rect", { x, y: plot.top, width: barWidth, height: plot.height, class: "frame" });
  for (const [u, text] of scale.marks) {
    const y = plot.top + plot.height * (1 - u);
    element(plot.frame, "line", { x1: x + barWidth, x2: x + barWidth + 4, y1: y, y2: y });
    element(plot.frame, "text", { x: x + barWidth + 7, y: y + 4 }, text);
  }
  element(plot.frame, "text", { x: FRAME.width - 4, y: 14, "text-anchor": "end" }, label);
}

// The texels of one channel.
function plotTable(svg, settings, channel) {
  const { material, surface, size, storage, row } = settings;
  const { albedo } = tableOf(material.surface, channel.sheet, size, storage);
  const all = Array.from({ length: size * size }, (_, i) => albedo.at(i % size, Math.floor(i / size), channel.index));
  const [low, high] = [Math.min(...all), Math.max(...all)];
  const span = high - low || 1;
  plotMap(svg, {
    width: size,
    height: size,
    colour: (x, y) => sequential((albedo.at(x, y, channel.index) - low) / span),
    axis: surface.roughness,
    row,
    scale: { colour: sequential, marks: [0, 0.25, 0.5, 0.75, 1].map((u) => [u, Number((low + u * span).toPrecision(2))]) },
    label: "albedo",
  });
  return { low, high };
}

// Sampled minus true at the points of the reference.
function plotError(svg, settings, channel) {
  const { material, surface, size, storage, row } = settings;
  const { albedo } = tableOf(material.surface, channel.sheet, size, storage);
  const truth = referenceOf(material.surface, channel.sheet).albedo;
  const error = (x, y) =>
    albedo.linear(x / (truth.width - 1), y / (truth.height - 1), channel.index) - truth.at(x, y, channel.index);
  let [worst, place, sum] = [0, [0, 0], 0];
  for (let y = 0; y < truth.height; y++) {
    for (let x = 0; x < truth.width; x++) {
      const size = Math.abs(error(x, y));
      sum += size;
      if (size > worst) [worst, place] = [size, [x, y]];
    }
  }
  const most = worst || 1e-9;
  const power = Math.floor(Math.log10(most));
  const unit = (u) => ((2 * u - 1) * most) / 10 ** power;
  plotMap(svg, {
    width: truth.width,
    height: truth.height,
    colour: (x, y) => diverging(0.5 + (0.5 * error(x, y)) / most),
    axis: surface.roughness,
    row,
    scale: { colour: diverging, marks: [0, 0.25, 0.5, 0.75, 1].map((u) => [u, (u > 0.5 ? "+" : "") + unit(u).toFixed(1).replace("-", "\u2212")]) },
    label: `error, 1e${power}`,
  });
  return {
    worst,
    mean: sum / (truth.width * truth.height),
    mu: (place[0] / (truth.width - 1)) ** 2,
    roughness: valueAt(surface.roughness, place[1] / (truth.height - 1)),
  };
}

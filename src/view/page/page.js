// The page itself: choices, what follows from them, and the reading aloud.

const $ = (id) => document.getElementById(id);
const SLIDERS = ["roughness", "r0", "ks", "kd", "theta", "light", "environment"];
const WHITE = 0.72; // the tone of radiance 1: a light grey, with room for gains

let renderer = null;
let strip = null;
let reading = null;

function option(parent, value, text) {
  const node = document.createElement("option");
  node.value = value;
  node.textContent = text;
  parent.append(node);
}

function fill() {
  const groups = [["Of the scene", (material) => !material.free], ["Any roughness and r0", (material) => material.free]];
  for (const [label, belongs] of groups) {
    const group = document.createElement("optgroup");
    group.label = label;
    materials().forEach((material, index) => belongs(material) && option(group, index, material.name));
    $("material").append(group);
  }
  for (const size of DATA.sizes) option($("size"), size, `${size} x ${size}`);
  $("size").value = 32;
  $("tolerance").textContent = short(DATA.tolerance);
  $("rule").textContent = String(RULE_ERROR);
  if (DATA.leftOut.length) {
    const list = document.createElement("ul");
    for (const { name, reason } of DATA.leftOut) {
      const item = document.createElement("li");
      item.textContent = `${name}: ${reason}`;
      list.append(item);
    }
    const title = document.createElement("p");
    title.textContent = "Materials that are not shown:";
    $("left-out").append(title, list);
  }
}

const chosenMaterial = () => materials()[Number($("material").value)];

// What the material says, into every control.
function reset() {
  const material = chosenMaterial();
  const surface = DATA.surfaces[material.surface];
  const roughness = middle(surface.roughness, material.roughness);
  $("roughness").value = 1000 * coordinate(surface.roughness, roughness);
  $("roughness").dataset.exact = roughness; // a step of the slider lies beside it
  $("ks").value = Math.max(...material.ks);
  $("kd").value = Math.max(...material.kd);
  $("r0").value = material.r0[0];
  $("white").checked = false;
  $("coupling").value = material.coupling;
  const channels = $("channel");
  channels.replaceChildren();
  for (const { name } of channelsOfTable(material)) option(channels, channels.length, name);
  channels.value = String(channels.length > 2 && material.sheet ? 0 : material.sheet ? 0 : 1);
}

// What tables of a material hold, as channels of its sheets.
function channelsOfTable(material) {
  const pair = [
    { name: "rho for r0 = 0", sheet: 0, index: 0 },
    { name: "E, rho for r0 = 1", sheet: 0, index: 1 },
  ];
  if (!material.sheet) return pair;
  const { channels } = DATA.surfaces[material.surface].sheets[material.sheet];
  const names = channels === 1 ? [`rho, ${material.fresnel}`] : ["red", "green", "blue"].map((name) => `rho, ${name}`);
  return [...names.map((name, index) => ({ name, sheet: material.sheet, index })), pair[1]];
}

// The colour of a material, as bright as a slider says.
function scaled(colour, value, isWhite) {
  const most = Math.max(...colour);
  return isWhite || most === 0 ? triple(value) : colour.map((one) => (one / most) * value);
}

function choices() {
  const material = chosenMaterial();
  const axis = DATA.surfaces[material.surface].roughness;
  const slider = $("roughness");
  const isWhite = $("white").checked;
  return completed({
    material: Number($("material").value),
    roughness: slider.dataset.exact ? Number(slider.dataset.exact) : valueAt(axis, slider.value / 1000),
    r0: material.free ? Number($("r0").value) : undefined,
    ks: scaled(material.ks, Number($("ks").value), isWhite),
    kd: scaled(material.kd, Number($("kd").value), isWhite),
    coupling: $("coupling").value,
    compensation: $("compensation").value,
    size: Number($("size").value),
    storage: $("storage").value,
  });
}

const isGrey = (values) => values.every((value) => Math.abs(value - values[0]) < 1e-6);

// One number, or three in their colours.
function show(node, values, digits, sign) {
  node.replaceChildren();
  const names = isGrey(values) ? [""] : ["red", "green", "blue"];
  names.forEach((name, i) => {
    const part = document.createElement("span");
    if (name) part.className = name;
    if (name) part.title = name;
    const text = values[i].toFixed(digits).replace(/^-(0\.?0*)$/, "$1");
    part.textContent = (sign && values[i] > 0 ? "+" : "") + text.replace("-", "\u2212");
    node.append(part);
  });
}

function labels(settings) {
  const { material, surface } = settings;
  $("roughness-name").textContent = `${surface.roughness.name}, ${surface.family}`;
  $("roughness-value").textContent = short(settings.roughness);
  $("roughness").setAttribute("aria-valuetext", `${surface.roughness.name} ${short(settings.roughness)}`);
  $("r0-row").hidden = !material.free;
  for (const name of ["r0", "ks", "kd"]) $(`${name}-value`).textContent = $(name).value;
  $("kd").disabled = settings.coupling === "none";
  $("theta-value").textContent = `${$("theta").value}\u00b0`;
  $("theta").setAttribute("aria-valuetext", `${$("theta").value} degrees`);
  $("light-value").textContent = `${$("light").value}\u00b0`;
  $("environment-value").textContent = $("environment").value;
  const hasColour = !isGrey(material.ks) || !isGrey(material.kd);
  $("white").disabled = !hasColour;
}

// Everything at one angle.
function readAt(settings, mu) {
  const shader = renderer.read(mu);
  const expected = predictor(settings)(mu);
  return { shader, expected, error: statedError(settings)(mu) };
}

let spoken = 0;

function tell(settings) {
  const theta = Number($("theta").value);
  const { shader, expected, error } = reading;
  show($("read"), shader, 4);
  show($("should"), expected, 4);
  show($("difference"), shader.map((value, i) => value - expected[i]), 5, true);
  $("stated").textContent = `\u00b1 ${error.toFixed(4)}`;
  const balance = shader.map((value) => 100 * (1 - value));
  const gains = balance.every((value) => value <= 0);
  $("balance-name").textContent = gains ? "gained, %" : "lost, %";
  show($("balance"), gains ? balance.map((value) => -value) : balance, 2);
  clearTimeout(spoken);
  // people who listen get what stays for a moment, and not every step of a slider
  spoken = setTimeout(() => {
    const list = (values) => (isGrey(values) ? values[0].toFixed(4) : values.map((value) => value.toFixed(4)).join(", "));
    $("summary").textContent =
      `${settings.material.name}, ${settings.surface.roughness.name} ${short(settings.roughness)}, at ${theta} degrees: the shader ` +
      `reads ${list(shader)}, it should read ${list(expected)}, with a stated error of ${error.toFixed(4)}. ` +
      `${$("error-fact").textContent}`;
  }, 400);
}

function plots(settings) {
  const predict = predictor(settings);
  const predicted = Array.from({ length: 46 }, (_, i) => [2 * i, predict(Math.cos((i * Math.PI) / 90))]);
  const theta = Number($("theta").value);
  const grey = isGrey(settings.ks) && isGrey(settings.r0) && (settings.coupling === "none" || isGrey(settings.kd)) &&
    DATA.surfaces[settings.material.surface].sheets[settings.material.sheet].channels < 3;
  plotEnergy($("energy"), { strip, predicted, theta, isGrey: grey });
  let worst = 0;
  for (let i = 0; i < STRIP; i++) {
    const expected = predict(strip[4 * i + 3]);
    for (const channel of RGB) worst = Math.max(worst, Math.abs(strip[4 * i + channel] - expected[channel]));
  }
  $("energy-fact").textContent = `Shader and expectation differ by ${short(worst)} at most.`;
}

function maps(settings) {
  const channel = channelsOfTable(settings.material)[Number($("channel").value)];
  const { low, high } = plotTable($("table"), settings, channel);
  const { size, storage } = settings;
  const sheet = DATA.surfaces[settings.material.surface].sheets[channel.sheet];
  const bytes = size * size * sheet.channels * (storage === "f16" ? 2 : 4);
  $("table-fact").textContent =
    `${size} x ${size} texels, ${storage}, ${bytes.toLocaleString("en")} bytes; ${channel.name}: ${short(low)} to ${short(high)}. ` +
    `The dashed line is the roughness above.`;
  const { worst, mean, mu, roughness } = plotError($("error"), settings, channel);
  $("error-fact").textContent =
    `Sampled minus true: at most ${worst.toExponential(1)} at mu ${short(mu)}, ${settings.surface.roughness.name} ${short(roughness)}; ` +
    `${mean.toExponential(1)} on average.`;
}

// Pixels of the screen that a sphere takes.
function fit(canvas) {
  const size = clamp(Math.round(canvas.clientWidth * (devicePixelRatio || 1)), 64, 720);
  if (canvas.width !== size) [canvas.width, canvas.height] = [size, size];
}

function spheres() {
  const theta = (Number($("theta").value) * Math.PI) / 180;
  const light = (Number($("light").value) * Math.PI) / 180;
  for (const name of ["enclosed", "lit"]) fit($(name));
  renderer.sphere("enclosed", $("enclosed"), {
    u_white: WHITE,
    u_exaggerate: Number($("exaggerate").value),
    u_ring: Math.sin(theta),
  });
  renderer.sphere("lit", $("lit"), {
    u_light: [Math.sin(light) * Math.cos(0.6), Math.sin(0.6), Math.cos(light) * Math.cos(0.6)],
    u_irradiance: 0.75,
    u_environment: Number($("environment").value),
    u_ground: groundColour(),
  });
}

// What a change of a control calls for: everything, or a part.
function update(what) {
  if (!renderer) return;
  const settings = choices();
  labels(settings);
  if (what === "all") {
    renderer.choose(settings);
    strip = renderer.furnace();
  }
  if (what === "all" || what === "maps") maps(settings);
  if (what !== "light" && what !== "maps") {
    reading = readAt(settings, Math.cos((Number($("theta").value) * Math.PI) / 180));
    plots(settings);
    tell(settings);
  }
  if (what !== "maps") spheres();
}

// Changes within one frame are one.
let pending = null;
function later(what) {
  if (pending === null) {
    requestAnimationFrame(() => {
      const all = pending;
      pending = null;
      attempt(() => (all.size > 1 ? update("all") : update([...all][0])));
    });
    pending = new Set();
  }
  pending.add(what);
}

const CONCERNS = { theta: "theta", light: "light", environment: "light", exaggerate: "light", channel: "maps" };

function listen() {
  $("controls").addEventListener("input", ({ target }) => {
    if (target.id === "turn") return turn(target.checked);
    if (target.id === "material") reset();
    if (target.id === "roughness") delete target.dataset.exact;
    later(CONCERNS[target.id] ?? "all");
  });
  $("controls").addEventListener("submit", (event) => event.preventDefault());
  $("reset").addEventListener("click", () => {
    reset();
    later("all");
  });
  const enclosed = $("enclosed");
  const point = (event) => {
    const box = enclosed.getBoundingClientRect();
    const [x, y] = [event.clientX - box.left, event.clientY - box.top].map((at) => (1.12 * (2 * at - box.width)) / box.width);
    const radius = Math.min(Math.hypot(x, y), 0.9999);
    $("theta").value = Math.round((Math.asin(radius) * 180) / Math.PI);
    later("theta");
  };
  enclosed.addEventListener("pointerdown", point);
  enclosed.addEventListener("pointermove", (event) => event.buttons && point(event));
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => later("all"));
  addEventListener("resize", () => later("light"));
  renderer.canvas.addEventListener("webglcontextlost", () => trouble("The graphics of this browser stopped: load the page again."));
}

// The light goes round; in steps, seldom, for those who want no motion.
let turning = 0;
function turn(isOn) {
  clearInterval(turning);
  if (!isOn) return;
  const calm = matchMedia("(prefers-reduced-motion: reduce)").matches;
  turning = setInterval(() => {
    const next = Number($("light").value) + 5;
    $("light").value = next > 90 ? -90 : next;
    later("light");
  }, calm ? 2000 : 120);
}

function trouble(text) {
  $("trouble").textContent = text;
  $("trouble").hidden = false;
}

function attempt(act) {
  try {
    act();
  } catch (error) {
    trouble(`This page cannot show what it should: ${error.message}.`);
    // nothing follows them any more
    for (const controls of document.querySelectorAll("fieldset")) controls.disabled = true;
    throw error;
  }
}

// For tests, and for whoever likes to ask by hand: the furnace value for any choice, from the same shader.
function read(chosen) {
  const settings = completed(chosen);
  renderer.choose(settings);
  const result = readAt(settings, chosen.mu ?? 0.5);
  if (strip) renderer.choose(choices());
  return result;
}

attempt(() => {
  fill();
  $("material").value = 0;
  reset();
  renderer = new Renderer();
  listen();
  update("all");
  window.furnace = { read, materials: materials().map(({ name }) => name), data: DATA };
});

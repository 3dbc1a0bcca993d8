// What a furnace reads, from albedos alone: those of the library, or those that a table gives back.

const COUPLINGS = ["none", "mikkelsen", "energy-preserving"];
const COMPENSATIONS = ["none", "kulla-conty", "turquin"];
// What the shader's rule errs by at most, measured over all families, roughnesses and angles.
const RULE_ERROR = 5e-4;
const RGB = [0, 1, 2];

const triple = (value) => (Array.isArray(value) ? value : [value, value, value]);

// Every choice of the page with its defaults, from those that are given.
function completed(chosen) {
  const known = materials();
  const named = chosen.material ?? 0;
  const material = typeof named === "number" ? known[named] : known.find((one) => one.name === named);
  if (!material) throw new RangeError(`no material ${JSON.stringify(named)}`);
  const surface = DATA.surfaces[material.surface];
  const roughness = chosen.roughness ?? middle(surface.roughness, material.roughness);
  return {
    material,
    surface,
    roughness,
    row: clamp(coordinate(surface.roughness, roughness), 0, 1),
    r0: triple(chosen.r0 ?? material.r0),
    ks: triple(chosen.ks ?? material.ks),
    kd: triple(chosen.kd ?? material.kd),
    coupling: chosen.coupling ?? material.coupling,
    compensation: chosen.compensation ?? "none",
    size: chosen.size ?? 32,
    storage: chosen.storage ?? "f32",
  };
}

// The middle of a range of roughness, as its axis sees it.
function middle(axis, [low, high]) {
  return low === high ? low : valueAt(axis, (coordinate(axis, low) + coordinate(axis, high)) / 2);
}

let cast = null;

// Those of the scene, and each of its surfaces under any r0 and roughness.
function materials() {
  if (!cast) {
    const free = DATA.surfaces.map((surface, index) => ({
      name: `any ${surface.family}, ${surface.masking}`,
      surface: index,
      sheet: 0,
      fresnel: "schlick",
      fresnelCode: 3,
      r0: [1, 1, 1],
      eta: [1, 1, 1],
      k: [0, 0, 0],
      roughness: [surface.roughness.min, surface.roughness.max],
      ks: [1, 1, 1],
      kd: [1, 1, 1],
      coupling: "none",
      free: true,
    }));
    cast = [...DATA.materials, ...free];
  }
  return cast;
}

// rho and E of the lobe at its roughness: functions of mu, and their means. `kind` is "table" or "reference".
function albedosOf(settings, kind) {
  const { material, row, r0, size, storage } = settings;
  const fetch = (sheet) =>
    kind === "table" ? tableOf(material.surface, sheet, size, storage) : referenceOf(material.surface, sheet);
  const method = kind === "table" ? "linear" : "cubic";
  const [pair, own] = [fetch(0), fetch(material.sheet)];
  const isPair = material.sheet === 0;
  const rho = (grid, u, channel) =>
    isPair
      ? (1 - r0[channel]) * grid[method](u, row, 0) + r0[channel] * grid[method](u, row, 1)
      : grid[method](u, row, channel);
  return {
    rho: (mu) => RGB.map((channel) => rho(own.albedo, Math.sqrt(mu), channel)),
    e: (mu) => pair.albedo[method](Math.sqrt(mu), row, 1),
    rhoMean: RGB.map((channel) => rho(own.mean, 0, channel)),
    eMean: pair.mean[method](0, row, 1),
  };
}

// The share of light that comes back after several bounces, under Schlick's term.
function multiple(r0, eMean) {
  const mean = r0 + (1 - r0) / 21;
  return (mean * mean * eMean) / (1 - mean * (1 - eMean));
}

// The lobe with its compensation: albedo and mean.
function compensated(settings, albedos) {
  const { compensation, r0 } = settings;
  if (compensation === "kulla-conty") {
    const added = RGB.map((channel) => multiple(r0[channel], albedos.eMean));
    return {
      rho: (mu) => albedos.rho(mu).map((rho, channel) => rho + added[channel] * (1 - albedos.e(mu))),
      mean: albedos.rhoMean.map((rho, channel) => rho + added[channel] * (1 - albedos.eMean)),
    };
  }
  if (compensation === "turquin") {
    const rho = (mu) => {
      const e = albedos.e(mu);
      return albedos.rho(mu).map((one, channel) => one * (1 + (r0[channel] * (1 - e)) / e));
    };
    return { rho, mean: meanOf(rho) };
  }
  return { rho: albedos.rho, mean: albedos.rhoMean };
}

// 2 int rho(mu) mu dmu = 4 int rho(t^2) t^3 dt, the midpoint rule.
function meanOf(rho) {
  const COUNT = 256;
  const sum = [0, 0, 0];
  for (let k = 0; k < COUNT; k++) {
    const t = (k + 0.5) / COUNT;
    rho(t * t).forEach((value, channel) => (sum[channel] += (4 * value * t ** 3) / COUNT));
  }
  return sum;
}

// The furnace value at mu that the library's albedos predict.
function predictor(settings) {
  const { ks, kd, coupling } = settings;
  const lobe = compensated(settings, albedosOf(settings, "reference"));
  return (mu) =>
    lobe.rho(mu).map((rho, channel) => {
      const spent = ks[channel] * rho;
      if (coupling === "none") return spent;
      const scale = coupling === "mikkelsen" ? 1 - ks[channel] * lobe.mean[channel] : 1;
      return spent + (1 - spent) * kd[channel] * scale;
    });
}

// The same with what the tables give back in place of every albedo that the shader looks up, and the lobe itself integrated truly.
function sampledPredictor(settings) {
  const { ks, kd, coupling, compensation, r0 } = settings;
  const [tables, known] = [albedosOf(settings, "table"), albedosOf(settings, "reference")];
  const looked = compensated(settings, tables);
  const lookedMean = meanOf(looked.rho);
  const eMean = meanOf((mu) => triple(tables.e(mu)))[0];
  const lobe = (mu, channel, rho) => {
    const e = tables.e(mu);
    if (compensation === "turquin") return rho * (1 + (r0[channel] * (1 - e)) / e);
    if (compensation === "none") return rho;
    return rho + (multiple(r0[channel], tables.eMean) * (1 - e) * (1 - eMean)) / Math.max(1 - tables.eMean, 1e-6);
  };
  return (mu) => {
    const [rho, there] = [known.rho(mu), looked.rho(mu)];
    return RGB.map((channel) => {
      const k = ks[channel];
      const spent = k * lobe(mu, channel, rho[channel]);
      if (coupling === "none") return spent;
      const left = 1 - k * looked.mean[channel];
      const base = kd[channel] * (1 - k * there[channel]) * (1 - k * lookedMean[channel]);
      return spent + (coupling === "mikkelsen" ? base : base / Math.max(left, 1e-6));
    });
  };
}

// How far the shader may be from the prediction at mu: its rule, and what its tables make of it.
function statedError(settings) {
  const [sampled, exact] = [sampledPredictor(settings), predictor(settings)];
  return (mu) => {
    const truth = exact(mu);
    return sampled(mu).reduce((worst, value, i) => Math.max(worst, RULE_ERROR + Math.abs(value - truth[i])), 0);
  };
}

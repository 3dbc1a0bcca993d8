// Microfacet lobes, and what tables of their albedos are for: a diffuse base under a lobe, and the light that scatters
// between facets more than once.
//
// Local frame: the normal is +z, wo and wi are unit vectors that point away from the surface. Values are BRDFs in sr^-1,
// without the cosine. Everything is f32; squares of sines and cosines are formed from wo + wi before it is normalised, so
// that narrow lobes keep their digits.

const FURNACE_GGX: u32 = 0u;
const FURNACE_BECKMANN: u32 = 1u;
const FURNACE_VMF: u32 = 2u;
const FURNACE_PHONG: u32 = 3u;
const FURNACE_CHARLIE: u32 = 4u;

const FURNACE_MASKING_NONE: u32 = 0u;
const FURNACE_V_GROOVE: u32 = 1u;
const FURNACE_SMITH: u32 = 2u;
const FURNACE_SMITH_CORRELATED: u32 = 3u;
const FURNACE_NEUBELT: u32 = 4u;

const FURNACE_FRESNEL_NONE: u32 = 0u;
const FURNACE_DIELECTRIC: u32 = 1u;
const FURNACE_CONDUCTOR: u32 = 2u;
const FURNACE_SCHLICK: u32 = 3u;
const FURNACE_CONDUCTOR_APPROXIMATE: u32 = 4u;

const FURNACE_MIKKELSEN: u32 = 0u;
const FURNACE_ENERGY_PRESERVING: u32 = 1u;

const FURNACE_PI: f32 = 3.14159265358979;
const FURNACE_ONE_OVER_PI: f32 = 0.318309886183791;

// Values that diverge with both directions at the horizon end here.
const FURNACE_LARGEST: f32 = 1e30;

struct FurnaceLobe {
    // FURNACE_GGX, ...
    family: u32,
    // FURNACE_V_GROOVE, ...; Smith masking needs GGX or Beckmann, anything else reflects nothing under it
    masking: u32,
    // FURNACE_SCHLICK, ...
    fresnel: u32,
    // alpha of GGX and Charlie, m of Beckmann, kappa of vMF, n of Phong
    roughness: f32,
    // scale of the lobe
    reflectance: vec3f,
    // relative index of refraction; of Schlick's term the reflectance at normal incidence
    eta: vec3f,
    // extinction of conductors
    k: vec3f,
}

// ln cos of an angle from its squared sine and its cosine, with all digits near 0: -atanh(s), s = sin^2/(2 - sin^2).
fn furnace_ln_cos(sin_squared: f32, cosine: f32) -> f32 {
    if sin_squared > 0.5 {
        return log(max(cosine, 1e-30));
    }
    let s = sin_squared / (2.0 - sin_squared);
    let q = s * s;
    let series = 1.0 + q * (0.33333333 + q * (0.2 + q * (0.14285714 + q * (0.11111111 + q * (0.09090909 + q * 0.07692308)))));
    return -s * series;
}

// p(h) = D (n.h), the density of normals over solid angle, from the squared sine and cosine of h.
fn furnace_density(family: u32, roughness: f32, sin_squared: f32, cosine: f32) -> f32 {
    if family == FURNACE_GGX {
        let stretched = roughness * cosine;
        let root = roughness / (stretched * stretched + sin_squared);
        return root * root * FURNACE_ONE_OVER_PI * cosine;
    }
    if family == FURNACE_BECKMANN {
        let width = roughness * cosine;
        let sine = sqrt(sin_squared);
        // e^-88 is below the smallest number
        if sine >= 9.38 * width {
            return 0.0;
        }
        let slope = sine / width;
        return exp(-slope * slope) * FURNACE_ONE_OVER_PI / (width * width * cosine);
    }
    if family == FURNACE_VMF {
        let versine = sin_squared / (1.0 + cosine);
        var whole = 1.0 + roughness * (0.5 + roughness * (0.083333333 - roughness * roughness * (0.0013888889 - roughness * roughness * 0.000033068783)));
        if roughness > 0.7 {
            whole = roughness / (1.0 - exp(-roughness));
        }
        return whole * exp(-roughness * versine) * (0.5 * FURNACE_ONE_OVER_PI);
    }
    if family == FURNACE_PHONG {
        let power = exp((roughness + 1.0) * furnace_ln_cos(sin_squared, cosine));
        return (roughness + 2.0) * (0.5 * FURNACE_ONE_OVER_PI) * power;
    }
    // Charlie: D = (2 + 1/alpha) sin^(1/alpha)/(2 pi); the sine is the cosine of the angle with the horizon
    let exponent = 1.0 / roughness;
    let power = exp(exponent * furnace_ln_cos(cosine * cosine, sqrt(sin_squared)));
    return (2.0 + exponent) * (0.5 * FURNACE_ONE_OVER_PI) * power * cosine;
}

// int D(h) max(0, -w.h) dh = (n.w) Lambda(w) of Smith's masking, finite at the horizon.
fn furnace_hidden(family: u32, roughness: f32, w: vec3f) -> f32 {
    let cosine = abs(w.z);
    let t = roughness * length(w.xy);
    if t <= 0.0 {
        return 0.0;
    }
    if family == FURNACE_GGX {
        return 0.5 * t * (t / (cosine + sqrt(cosine * cosine + t * t)));
    }
    // t/2 int_x^inf erfc with x = (n.w)/t, which is e^(-x^2) times a rational function to 4e-7 (tests/shader.rs)
    if cosine > 9.3 * t {
        return 0.0;
    }
    let x = cosine / t;
    let above = 0.5641896 + x * (0.40513567 + x * (0.15016465 + x * 0.024635236));
    let below = 1.0 + x * (2.4905431 + x * (2.6804534 + x * (1.5865098 + x * (0.53044779 + x * 0.087410434))));
    return 0.5 * t * exp(-x * x) * (above / below);
}

// Dielectric interface, eta of the far side over the near side. Numerators are products that do not cancel.
fn furnace_dielectric(cosine: f32, eta: f32) -> f32 {
    let contrast = (eta - 1.0) * (eta + 1.0);
    if contrast == 0.0 {
        return 0.0;
    }
    let sine = sqrt(max((1.0 - cosine) * (1.0 + cosine), 0.0));
    var beyond = (eta - sine) * (eta + sine);
    if cosine < sine {
        beyond = contrast + cosine * cosine;
    }
    if min(cosine, beyond) <= 0.0 {
        return 1.0;
    }
    let g = sqrt(beyond);
    let across = contrast / ((cosine + g) * (cosine + g));
    // eta^2 cos^2 - sin^2 in the form that keeps its digits on either side of eta = 1
    var brewster = (eta * cosine - sine) * (eta * cosine + sine);
    if eta < 1.0 {
        brewster = (g - eta * sine) * (g + eta * sine);
    }
    let sum = eta * eta * cosine + g;
    let along = contrast * brewster / (sum * sum);
    return min(0.5 * (across * across + along * along), 1.0);
}

// Conductor of index eta + ik, exact: sums of squares, with the root (a + ib)^2 = (eta + ik)^2 - sin^2.
fn furnace_conductor(cosine: f32, eta: f32, k: f32) -> f32 {
    let contrast = (eta - 1.0) * (eta + 1.0);
    if abs(contrast) + k == 0.0 {
        return 0.0;
    }
    if cosine <= 0.0 {
        return 1.0;
    }
    let sin_squared = max((1.0 - cosine) * (1.0 + cosine), 0.0);
    let sine = sqrt(sin_squared);
    var real = (eta - sine) * (eta + sine) - k * k;
    if cosine < sine {
        real = contrast + cosine * cosine - k * k;
    }
    let imaginary = 2.0 * eta * k;
    let modulus = sqrt(real * real + imaginary * imaginary);
    let larger = 0.5 * (modulus + abs(real));
    var smaller = 0.0;
    if larger > 0.0 {
        smaller = 0.25 * imaginary * imaginary / larger;
    }
    let a_squared = select(smaller, larger, real >= 0.0);
    let b_squared = select(larger, smaller, real >= 0.0);
    let a = sqrt(a_squared);
    let sum = a + cosine;
    let difference = (b_squared + contrast - k * k) / sum;
    let across = (difference * difference + b_squared) / (sum * sum + b_squared);
    let low = a * cosine - sin_squared;
    let high = a * cosine + sin_squared;
    let cosine_b = cosine * cosine * b_squared;
    let denominator = high * high + cosine_b;
    var ratio = 1.0;
    if denominator > 0.0 {
        ratio = (low * low + cosine_b) / denominator;
    }
    return min(0.5 * across * (1.0 + ratio), 1.0);
}

// The approximation for conductors of large eta, k.
fn furnace_conductor_approximate(cosine: f32, eta: f32, k: f32) -> f32 {
    let cos_squared = cosine * cosine;
    let norm = eta * eta + k * k;
    let cross_term = 2.0 * eta * cosine;
    let inner = eta * cosine - 1.0;
    let outer = eta - cosine;
    let along = (inner * inner + k * k * cos_squared) / (norm * cos_squared + cross_term + 1.0);
    let across = (outer * outer + k * k) / (norm + cross_term + cos_squared);
    return 0.5 * (along + across);
}

// Schlick's r0 + (1 - r0) (1 - cos)^5.
fn furnace_schlick(cosine: f32, r0: vec3f) -> vec3f {
    let rest = clamp(1.0 - cosine, 0.0, 1.0);
    let square = rest * rest;
    return r0 + (vec3f(1.0) - r0) * (square * square * rest);
}

// The Fresnel term of a lobe for facets under the cosine `cos_d` = wo.h = wi.h, without the lobe's reflectance.
fn furnace_fresnel(lobe: FurnaceLobe, cos_d: f32) -> vec3f {
    let cosine = clamp(cos_d, 0.0, 1.0);
    if lobe.fresnel == FURNACE_DIELECTRIC {
        return vec3f(
            furnace_dielectric(cosine, lobe.eta.x),
            furnace_dielectric(cosine, lobe.eta.y),
            furnace_dielectric(cosine, lobe.eta.z),
        );
    }
    if lobe.fresnel == FURNACE_CONDUCTOR {
        return vec3f(
            furnace_conductor(cosine, lobe.eta.x, lobe.k.x),
            furnace_conductor(cosine, lobe.eta.y, lobe.k.y),
            furnace_conductor(cosine, lobe.eta.z, lobe.k.z),
        );
    }
    if lobe.fresnel == FURNACE_SCHLICK {
        return furnace_schlick(cosine, lobe.eta);
    }
    if lobe.fresnel == FURNACE_CONDUCTOR_APPROXIMATE {
        return vec3f(
            furnace_conductor_approximate(cosine, lobe.eta.x, lobe.k.x),
            furnace_conductor_approximate(cosine, lobe.eta.y, lobe.k.y),
            furnace_conductor_approximate(cosine, lobe.eta.z, lobe.k.z),
        );
    }
    return vec3f(1.0);
}

// The BRDF of a lobe, R F(wo.h) G2 D(h)/(4 (n.o)(n.i)); 0 for directions on different sides of the surface.
fn furnace_f(lobe: FurnaceLobe, wo: vec3f, wi: vec3f) -> vec3f {
    let side = select(1.0, -1.0, wo.z + wi.z < 0.0);
    let o = wo * side;
    let i = wi * side;
    let highest = max(o.z, i.z);
    if min(o.z, i.z) < 0.0 {
        return vec3f(0.0);
    }
    if highest <= 0.0 {
        return vec3f(0.0);
    }
    let sum = o + i;
    // relative to its largest component no square of it underflows
    let size = max(max(abs(sum.x), abs(sum.y)), sum.z);
    let h = sum / size;
    let squared = dot(h, h);
    let sin_squared = min(dot(h.xy, h.xy) / squared, 1.0);
    let cosine = min(h.z / sqrt(squared), 1.0);
    let cos_d = min(0.5 * size * sqrt(squared), 1.0);
    let density = furnace_density(lobe.family, lobe.roughness, sin_squared, cosine);
    // f = F p/divisor
    let unmasked = 4.0 * o.z * i.z * cosine;
    var divisor = unmasked;
    if lobe.masking == FURNACE_MASKING_NONE {
        if unmasked <= 0.0 {
            return vec3f(0.0);
        }
    } else if lobe.masking == FURNACE_V_GROOVE {
        divisor = max(unmasked, 2.0 * cos_d * highest);
    } else if lobe.masking == FURNACE_NEUBELT {
        divisor = 4.0 * cosine * (o.z + i.z - o.z * i.z);
    } else {
        if lobe.family > FURNACE_BECKMANN {
            return vec3f(0.0);
        }
        let hidden_o = furnace_hidden(lobe.family, lobe.roughness, o);
        let hidden_i = furnace_hidden(lobe.family, lobe.roughness, i);
        if lobe.masking == FURNACE_SMITH {
            divisor = 4.0 * cosine * (o.z + hidden_o) * (i.z + hidden_i);
        } else {
            divisor = 4.0 * cosine * (o.z * i.z + (i.z * hidden_o + o.z * hidden_i));
        }
    }
    if density <= 0.0 {
        return vec3f(0.0);
    }
    let value = density / max(divisor, density / FURNACE_LARGEST);
    return lobe.reflectance * furnace_fresnel(lobe, cos_d) * value;
}

// The diffuse base under a specular lobe, (1 - ks rho(i)) kd/pi (1 - ks rho(o)), and over 1 - ks rho_mean where nothing may
// be lost. rho_o and rho_i are the lobe's albedos (tables of rho_hd) at the cosines of wo and wi, rho_mean its mean (rho_hh),
// all at ks = 1. The lobe itself, ks f, is to be added. Albedos that exceed 1 leave nothing.
fn furnace_base(coupling: u32, ks: vec3f, kd: vec3f, rho_o: vec3f, rho_i: vec3f, rho_mean: vec3f) -> vec3f {
    let left = max(vec3f(1.0) - ks * rho_o, vec3f(0.0)) * max(vec3f(1.0) - ks * rho_i, vec3f(0.0));
    let base = kd * left * FURNACE_ONE_OVER_PI;
    if coupling == FURNACE_MIKKELSEN {
        return base;
    }
    let unspent = vec3f(1.0) - ks * rho_mean;
    return select(vec3f(0.0), base / max(unspent, vec3f(1e-30)), unspent > vec3f(0.0));
}

// Light that facets scatter more than once, of a lobe with Schlick's Fresnel term: to be added to the lobe. e_o, e_i and
// e_mean are rho_hd at both cosines and rho_hh of the lobe for F = 1.
fn furnace_kulla_conty(r0: vec3f, e_o: f32, e_i: f32, e_mean: f32) -> vec3f {
    let missing = 1.0 - e_mean;
    if missing <= 0.0 {
        return vec3f(0.0);
    }
    let lost = max(1.0 - e_o, 0.0) * (max(1.0 - e_i, 0.0) / missing) * FURNACE_ONE_OVER_PI;
    let mean = (20.0 * r0 + vec3f(1.0)) / 21.0;
    return mean * mean * (e_mean / (vec3f(1.0) - mean * missing)) * lost;
}

// The same light as a factor of the lobe, 1 + r0 (1/e_o - 1): exact in energy at r0 = 1, but not reciprocal.
fn furnace_turquin(r0: vec3f, e_o: f32) -> vec3f {
    return vec3f(1.0) + r0 * (max(1.0 - e_o, 0.0) / max(e_o, 1e-4));
}

// Albedo of a lobe with Schlick's Fresnel term from a table of two channels, those for r0 = 0 and r0 = 1.
fn furnace_albedo_schlick(pair: vec2f, r0: vec3f) -> vec3f {
    return vec3f(pair.x) + r0 * (pair.y - pair.x);
}

// The same pair as scale and bias: the albedo is r0 scale + bias.
fn furnace_scale_bias(pair: vec2f) -> vec2f {
    return vec2f(pair.y - pair.x, pair.x);
}

// Albedo of Oren and Nayar's qualitative model at the cosine mu, over its reflectance:
// a = 1 - s^2/(2 (s^2 + 0.33)), b = 0.45 s^2/(s^2 + 0.09) for the deviation s of facet angles, in radians.
fn furnace_oren_nayar(a: f32, b: f32, mu: f32) -> f32 {
    let cosine = clamp(mu, 0.0, 1.0);
    let sine = sqrt((1.0 - cosine) * (1.0 + cosine));
    let below = 0.5 * sine * (acos(cosine) - sine * cosine);
    let above = sine * cosine * (1.0 + sine * (1.0 + sine)) / (3.0 * (1.0 + sine));
    return a + b * (2.0 * FURNACE_ONE_OVER_PI) * (below + above);
}

// The white furnace: int f(wo, wi) cos theta_i dwi, what a direction sees of a surface in an environment of radiance 1.
//
// The lobe is integrated over its half vectors, drawn by their own distribution: with 1 - P(theta_h) = s^2 and azimuths psi,
//   int f cos theta_i dwi = int_0^1 2 s ds (1/pi) int_0^reach dpsi  f cos theta_i 4 (o.h) / p(h),
// the midpoint rule in y and x with s = c(y), psi = reach c(x), c(x) = x^3 (10 - 15 x + 6 x^2): points crowd towards the ends, where
// h nears the normal or the horizon, or wi the surface, and c' and c'' vanish there, as the rule likes it. What depends on
// cosines alone is integrated over t = sqrt(mu_i), along which the tables are linear between texels.

uniform float u_mu;    // the cosine, or -1 for a strip of them, uniform in theta
uniform float u_width; // pixels of the strip
out uvec4 o_bits;      // the bits of floats: targets of integers need no extension

const int POLAR = 96;
const int AZIMUTHS = 48;
const int COSINES = 128;

float crowded(float x) {
    return x * x * x * (10.0 + x * (6.0 * x - 15.0));
}

float crowding(float x) {
    float rest = x * (1.0 - x);
    return 30.0 * rest * rest;
}

// sin and cos of theta_h, and p(h), where 1 - P(theta_h) = s^2.
vec3 half_vector(float s) {
    float r = u_roughness;
    if (u_family == 0u || u_family == 1u) {
        float slope = u_family == 0u ? r * sqrt((1.0 - s) * (1.0 + s)) / s : r * sqrt(-2.0 * log(s));
        float c = inversesqrt(1.0 + slope * slope);
        float q = r / (1.0 + (r - 1.0) * (r + 1.0) * c * c);
        return vec3(slope * c, c, u_family == 0u ? q * q * c / PI : s * s / (PI * r * r * c * c * c));
    }
    if (u_family == 2u) {
        float decay = exp(-r);
        float e = decay + (1.0 - decay) * s * s;
        float v = r < 1e-3 ? 1.0 - s * s : -log(e) / r;
        return vec3(sqrt(v * (2.0 - v)), 1.0 - v, (r < 1e-3 ? 1.0 : r / (1.0 - decay)) * e / (2.0 * PI));
    }
    float power = log(s) * 2.0 / (r + 2.0);
    float c = exp(power);
    return vec3(sqrt(1.0 - c * c), c, (r + 2.0) / (2.0 * PI) * exp((r + 1.0) * power));
}

vec3 lobe_part(vec3 wo) {
    FurnaceLobe lobe = lobe();
    float mu = wo.z;
    vec3 sum = vec3(0.0);
    for (int j = 0; j < POLAR; j++) {
        float y = (float(j) + 0.5) / float(POLAR);
        float s = crowded(y);
        vec3 polar = half_vector(s);
        // wi lies above the surface up to this azimuth
        float edge = mu * (1.0 - 2.0 * polar.y * polar.y) / (2.0 * polar.x * polar.y * max(wo.x, 1e-6));
        float reach = acos(clamp(edge, -1.0, 1.0));
        vec3 ring = vec3(0.0);
        for (int k = 0; k < AZIMUTHS; k++) {
            float x = (float(k) + 0.5) / float(AZIMUTHS);
            float psi = reach * crowded(x);
            vec3 h = vec3(polar.x * cos(psi), polar.x * sin(psi), polar.y);
            float cos_d = dot(wo, h);
            vec3 wi = 2.0 * cos_d * h - wo;
            if (cos_d > 0.0 && wi.z > 0.0) {
                ring += furnace_f(lobe, wo, wi) * (wi.z * cos_d * crowding(x));
            }
        }
        ring *= reach / PI;
        sum += ring * (2.0 * s * crowding(y) / polar.z);
    }
    return sum * (4.0 / float(POLAR * AZIMUTHS));
}

vec3 furnace(float mu) {
    vec3 wo = vec3(sqrt(max(1.0 - mu * mu, 0.0)), 0.0, mu);
    Albedo o = sampled(mu);
    vec3 rest = vec3(0.0);
    for (int k = 0; k < COSINES; k++) {
        float t = (float(k) + 0.5) / float(COSINES);
        rest += smooth_part(o, sampled(t * t)) * (t * t * t);
    }
    return gain(o) * lobe_part(wo) + rest * (4.0 * PI / float(COSINES));
}

void main() {
    float theta = 0.5 * PI * gl_FragCoord.x / u_width;
    float mu = u_mu >= 0.0 ? u_mu : sin(0.5 * PI - theta);
    o_bits = floatBitsToUint(vec4(furnace(max(mu, 1e-6)), mu));
}

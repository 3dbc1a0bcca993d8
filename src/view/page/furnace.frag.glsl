// The white furnace: int f(wo, wi) cos theta_i dwi, what a direction sees of a surface in an environment of radiance 1.
//
// The lobe is integrated over its half vectors, drawn by their own distribution: with 1 - P(theta_h) = s^2 and azimuths psi,
//   int f cos theta_i dwi = (1/pi) int_0^pi dpsi int_0^1 2 s ds  f cos theta_i 4 (o.h) / p(h),
// the midpoint rule in both. s and not s^2, since f cos theta_i / p is smooth in s where h nears the horizon. What depends on
// cosines alone is integrated over t = sqrt(mu_i), along which the tables are linear between texels.

uniform float u_mu;    // the cosine, or -1 for a strip of them, uniform in theta
uniform float u_width; // pixels of the strip
out uvec4 o_bits;      // the bits of floats: targets of integers need no extension

const int POLAR = 96;
const int AZIMUTHS = 48;
const int COSINES = 128;

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
    vec3 sum = vec3(0.0);
    for (int j = 0; j < POLAR; j++) {
        float s = (float(j) + 0.5) / float(POLAR);
        vec3 polar = half_vector(s);
        vec3 ring = vec3(0.0);
        for (int k = 0; k < AZIMUTHS; k++) {
            float psi = PI * (float(k) + 0.5) / float(AZIMUTHS);
            vec3 h = vec3(polar.x * cos(psi), polar.x * sin(psi), polar.y);
            float cos_d = dot(wo, h);
            vec3 wi = 2.0 * cos_d * h - wo;
            if (cos_d > 0.0 && wi.z > 0.0) {
                ring += furnace_f(lobe, wo, wi) * (wi.z * cos_d);
            }
        }
        sum += ring * (2.0 * s / polar.z);
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

// The material that is chosen: its lobe, its tables, and f of the whole as a renderer would shade with it.

uniform uint u_family;
uniform uint u_masking;
uniform uint u_fresnel;
uniform float u_roughness;
uniform vec3 u_eta;
uniform vec3 u_k;
uniform vec3 u_r0;
uniform vec3 u_ks;
uniform vec3 u_kd;
uniform int u_coupling;     // 0 none, 1 as printed, 2 energy preserving
uniform int u_compensation; // 0 none, 1 Kulla and Conty, 2 Turquin
uniform sampler2D u_table;  // rho in r, g, b and E, the albedo under F = 1, in a, over sqrt(mu) and the roughness
uniform float u_row;        // where the roughness lies between the rows, from 0 to n - 1
uniform vec3 u_rho_mean;    // rho_bar of the compensated lobe
uniform float u_e_mean;     // E_bar

const float PI = 3.14159265358979;

struct Albedo {
    vec3 rho;
    float e;
};

FurnaceLobe lobe() {
    return FurnaceLobe(u_family, u_masking, u_fresnel, u_roughness, vec3(1.0), u_eta, u_k);
}

// A bilinear lookup with exact weights: hardware may keep 8 bits of them, and filters no 32-bit floats on many phones.
Albedo sampled(float mu) {
    ivec2 size = textureSize(u_table, 0);
    vec2 place = vec2(sqrt(clamp(mu, 0.0, 1.0)) * float(size.x - 1), u_row);
    ivec2 low = min(ivec2(place), size - 2);
    vec2 weight = place - vec2(low);
    vec4 below = mix(texelFetch(u_table, low, 0), texelFetch(u_table, low + ivec2(1, 0), 0), weight.x);
    vec4 above = mix(texelFetch(u_table, low + ivec2(0, 1), 0), texelFetch(u_table, low + ivec2(1, 1), 0), weight.x);
    vec4 texel = mix(below, above, weight.y);
    return Albedo(texel.rgb, texel.a);
}

// The albedo of the lobe with its compensation, which is what a base has to be coupled to.
vec3 compensated(Albedo a) {
    if (u_compensation == 1) {
        // int (1 - E(mu_i)) cos theta_i dwi = pi (1 - E_bar), and 1 - E(mu_i) is a factor of the added lobe
        return a.rho + PI * (1.0 - u_e_mean) * furnace_kulla_conty(u_r0, a.e, 0.0, u_e_mean);
    }
    return u_compensation == 2 ? a.rho * furnace_turquin(u_r0, a.e) : a.rho;
}

// What the lobe itself is multiplied with.
vec3 gain(Albedo o) {
    return u_compensation == 2 ? u_ks * furnace_turquin(u_r0, o.e) : u_ks;
}

// All parts of f that depend on both cosines alone.
vec3 smooth_part(Albedo o, Albedo i) {
    vec3 f = vec3(0.0);
    if (u_compensation == 1) {
        f += u_ks * furnace_kulla_conty(u_r0, o.e, i.e, u_e_mean);
    }
    if (u_coupling != 0) {
        f += furnace_base(uint(u_coupling - 1), u_ks, u_kd, compensated(o), compensated(i), u_rho_mean);
    }
    return f;
}

vec3 shaded(vec3 wo, vec3 wi) {
    Albedo o = sampled(wo.z);
    return gain(o) * furnace_f(lobe(), wo, wi) + smooth_part(o, sampled(wi.z));
}

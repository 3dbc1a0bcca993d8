// A sphere under a directional light and a uniform environment, seen from far away.

uniform highp usampler2D u_strip;
uniform vec3 u_light;       // towards the light
uniform float u_irradiance; // of a surface that faces it, over pi
uniform float u_environment;
uniform float u_pixel;
uniform vec3 u_ground;      // what lies behind, as the page has it
in vec2 v_place;
out vec4 o_colour;

vec3 strip(float mu) {
    float size = float(textureSize(u_strip, 0).x);
    float place = clamp(acos(clamp(mu, 0.0, 1.0)) / (0.5 * PI) * size - 0.5, 0.0, size - 1.0);
    int low = min(int(place), int(size) - 2);
    vec3 a = uintBitsToFloat(texelFetch(u_strip, ivec2(low, 0), 0).rgb);
    vec3 b = uintBitsToFloat(texelFetch(u_strip, ivec2(low + 1, 0), 0).rgb);
    return mix(a, b, place - float(low));
}

// Highlights roll off above 0.8 towards 1, so that a sharp one is not a white disc.
vec3 encoded(vec3 linear) {
    vec3 over = max(linear - 0.8, 0.0);
    vec3 c = min(linear, 0.8) + 0.2 * over / (over + 0.2);
    return mix(12.92 * c, 1.055 * pow(max(c, 1e-6), vec3(1.0 / 2.4)) - 0.055, step(0.0031308, c));
}

void main() {
    vec2 place = v_place * 1.12;
    float radius = length(place);
    float inside = 1.0 - smoothstep(1.0 - u_pixel, 1.0 + u_pixel, radius);
    vec3 n = vec3(place, sqrt(max(1.0 - radius * radius, 1e-6)));
    n = normalize(n);
    // a frame about the normal; which, does not matter to what is isotropic
    vec3 x = normalize(cross(abs(n.x) > 0.5 ? vec3(0.0, 1.0, 0.0) : vec3(1.0, 0.0, 0.0), n));
    mat3 frame = mat3(x, cross(n, x), n);
    vec3 wo = vec3(0.0, 0.0, 1.0) * frame;
    vec3 wi = u_light * frame;
    vec3 seen = u_environment * strip(wo.z);
    if (wi.z > 0.0) {
        seen += shaded(wo, wi) * (wi.z * PI * u_irradiance);
    }
    o_colour = vec4(mix(u_ground, encoded(seen), inside), 1.0);
}

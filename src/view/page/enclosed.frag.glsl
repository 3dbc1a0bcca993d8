// A sphere in a white environment of radiance 1, seen from far away: it shows the furnace value at the angle of each pixel.

uniform highp usampler2D u_strip;
uniform float u_white;      // the tone of radiance 1
uniform float u_exaggerate; // of differences from it
uniform float u_ring;       // the angle that is chosen, a circle of this radius
uniform float u_pixel;      // of the radius
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

vec3 encoded(vec3 linear) {
    vec3 c = clamp(linear, 0.0, 1.0);
    return mix(12.92 * c, 1.055 * pow(max(c, 1e-6), vec3(1.0 / 2.4)) - 0.055, step(0.0031308, c));
}

void main() {
    vec2 place = v_place * 1.12;
    float radius = length(place);
    vec3 seen = vec3(1.0);
    if (radius < 1.0) {
        seen = strip(sqrt(1.0 - radius * radius));
    }
    vec3 tone = encoded(u_white * (1.0 + (seen - 1.0) * u_exaggerate));
    // a dotted circle at the chosen angle, dark on light and light on dark
    float dots = step(0.5, fract(atan(place.y, place.x) * 8.0 / PI));
    float line = dots * smoothstep(1.5 * u_pixel, 0.5 * u_pixel, abs(radius - u_ring));
    float contrast = dot(tone, vec3(0.3, 0.6, 0.1)) > 0.4 ? 0.0 : 1.0;
    o_colour = vec4(mix(tone, vec3(contrast), 0.55 * line), 1.0);
}

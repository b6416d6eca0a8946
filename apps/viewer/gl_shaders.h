// What the graphics system does for each corner and each pixel: the background, surfaces and lines.
#pragma once

namespace proxima::gl_shaders {

inline constexpr const char* background_vertices = R"(#version 330 core
out float part;
void main() {
    vec2 at = vec2(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0);
    part = 0.5 + 0.5 * at.y;
    gl_Position = vec4(at, 0.0, 1.0);
})";

inline constexpr const char* background_colors = R"(#version 330 core
in float part;
uniform vec3 top;
uniform vec3 bottom;
out vec4 color;
void main() { color = vec4(mix(bottom, top, part), 1.0); })";

inline constexpr const char* surface_vertices = R"(#version 330 core
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
uniform mat4 clip;
uniform vec4 cut;
uniform float lift;
uniform vec2 depth_of_nearness;
out vec3 direction;
out float beyond;
void main() {
    direction = normal;
    beyond = dot(cut.xyz, position) - cut.w;
    gl_Position = clip * vec4(position, 1.0);
    if (lift != 0.0)
        gl_Position.z = depth_of_nearness.x * gl_Position.w + depth_of_nearness.y * (1.0 + lift);
})";

// As Lamps::shade has it; what is seen from behind is lit as if it faced the eye.
inline constexpr const char* surface_colors = R"(#version 330 core
in vec3 direction;
in float beyond;
uniform vec3 own;
uniform float opacity;
uniform bool lit;
uniform vec3 toward[3];
uniform vec3 light[3];
uniform vec3 everywhere;
out vec4 color;
void main() {
    if (beyond > 0.0) discard;
    vec3 normal = gl_FrontFacing ? normalize(direction) : -normalize(direction);
    vec3 sum = everywhere + light[2] * (0.5 + 0.5 * dot(normal, toward[2]));
    for (int i = 0; i < 2; ++i) sum += light[i] * max(0.0, dot(normal, toward[i]));
    color = vec4(lit ? own * sum : own, opacity);
})";

// Each segment is a ribbon of four corners, cut where it passes the eye.
inline constexpr const char* line_vertices = R"(#version 330 core
layout(location = 0) in vec3 from;
layout(location = 1) in vec3 to;
uniform mat4 clip;
uniform vec2 size;
uniform float width;
uniform float lift;
uniform float least;
uniform vec2 depth_of_nearness;
uniform vec4 cut;
out float beyond;
void main() {
    beyond = dot(cut.xyz, gl_VertexID < 2 ? from : to) - cut.w;
    vec4 a = clip * vec4(from, 1.0);
    vec4 b = clip * vec4(to, 1.0);
    if (a.w < least && b.w < least) { gl_Position = vec4(0.0, 0.0, 2.0, 1.0); return; }
    if (a.w < least) a = mix(a, b, (least - a.w) / (b.w - a.w));
    if (b.w < least) b = mix(b, a, (least - b.w) / (a.w - b.w));
    vec2 along = (b.xy / b.w - a.xy / a.w) * size;
    along = length(along) > 0.0 ? normalize(along) : vec2(1.0, 0.0);
    float end = gl_VertexID < 2 ? -1.0 : 1.0;
    float side = (gl_VertexID & 1) == 0 ? -1.0 : 1.0;
    vec2 pixels = 0.5 * width * (side * vec2(-along.y, along.x) + 0.35 * end * along);
    vec4 at = gl_VertexID < 2 ? a : b;
    at.xy += 2.0 * pixels / size * at.w;
    if (depth_of_nearness.y != 0.0)
        at.z = depth_of_nearness.x * at.w + depth_of_nearness.y * (1.0 + lift);
    gl_Position = at;
})";

inline constexpr const char* line_colors = R"(#version 330 core
in float beyond;
uniform vec3 own;
uniform float opacity;
out vec4 color;
void main() { if (beyond > 0.0) discard; color = vec4(own, opacity); })";

} // namespace proxima::gl_shaders

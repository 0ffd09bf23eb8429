#include "engine/render/shaders.hpp"

namespace pantin::detail {

const char* const kFrameSource = R"(
layout(std140) uniform Frame {
  vec4 clip[4];
  vec4 light[3];
  vec4 sun, sunlight, sky, soil;
  vec4 ray[3];
  vec4 horizon, zenith, tiles[4], shade_map, ground_origin, viewport;
};

// The filmic curve of K. Narkowicz (2016), darker by 0.62, and the sRGB transfer curve by square
// roots (within 0.003 of the exact one).
vec3 display(vec3 linear) {
  vec3 c = 0.62 * linear;
  c = min(c * (2.51 * c + 0.03) / (c * (2.43 * c + 0.59) + 0.14), 1.0);
  vec3 s1 = sqrt(c), s2 = sqrt(s1), s3 = sqrt(s2);
  return 0.662002687 * s1 + 0.684122060 * s2 - 0.323583601 * s3 - 0.0225411470 * c;
}

vec3 to_light(vec3 position) {
  vec4 p = vec4(position, 1.0);
  return vec3(dot(light[0], p), dot(light[1], p), dot(light[2], p));
}

#ifdef SHADOWS
uniform sampler2DShadow shadow_map;

// Three by three texels seen through four filtered taps, weighted as a tent. [Castano 2013]
float lit(vec3 position) {
  vec3 p = to_light(position);
  float size = sunlight.w;
  vec2 texel = p.xy * size, base = floor(texel + 0.5), s = texel + 0.5 - base;
  vec2 w0 = 3.0 - 2.0 * s, w1 = 1.0 + 2.0 * s;
  vec2 low = (base - 0.5 + (2.0 - s) / w0 - 1.0) / size, high = (base - 0.5 + s / w1 + 1.0) / size;
  float depth = min(p.z, 1.0);
  return (w0.x * w0.y * texture(shadow_map, vec3(low, depth)) +
          w1.x * w0.y * texture(shadow_map, vec3(high.x, low.y, depth)) +
          w0.x * w1.y * texture(shadow_map, vec3(low.x, high.y, depth)) +
          w1.x * w1.y * texture(shadow_map, vec3(high, depth))) / 16.0;
}
#endif
)";

const char* const kSolidVertex = R"(
layout(location = 0) in vec3 corner;
layout(location = 1) in vec3 mesh_normal;
layout(location = 2) in vec4 turn;
layout(location = 3) in vec4 position_metallic;
layout(location = 4) in vec4 core_skin;
layout(location = 5) in vec4 colour_roughness;
out vec3 at;
out vec3 normal;
flat out vec4 colour;
flat out float metallic;
out float gl_ClipDistance[1];

vec3 turned(vec3 v) { return v + 2.0 * cross(turn.xyz, cross(turn.xyz, v) + turn.w * v); }

void main() {
  at = position_metallic.xyz + turned(corner * core_skin.xyz + mesh_normal * core_skin.w);
  vec4 p = vec4(at, 1.0);
#ifdef DEPTH
  gl_Position = vec4(2.0 * to_light(at) - 1.0, 1.0);
#else
  gl_Position = vec4(dot(clip[0], p), dot(clip[1], p), dot(clip[2], p), dot(clip[3], p));
#endif
  gl_ClipDistance[0] = at.y - viewport.z;
  normal = turned(mesh_normal);
  colour = colour_roughness;
  metallic = position_metallic.w;
}
)";

const char* const kRibbonVertex = R"(
layout(location = 0) in vec3 centre;
layout(location = 1) in vec3 along;
layout(location = 2) in float side;
out vec3 at;
out vec3 normal;  // across the string, as long as the way from its middle
flat out vec4 colour;
flat out float metallic;
out float gl_ClipDistance[1];

void main() {
#ifdef DEPTH
  vec3 view = sun.xyz;
  float half_width = max(STRING_RADIUS, 1.3 * sun.w);
#else
  vec3 view = -normalize(centre);
  float half_width = max(STRING_RADIUS, 0.75 * sky.w * dot(clip[3].xyz, centre));
#endif
  vec3 across = cross(along, view);
  across *= side * inversesqrt(max(dot(across, across), 1e-20));
  at = centre + half_width * across;
  vec4 p = vec4(at, 1.0);
#ifdef DEPTH
  gl_Position = vec4(2.0 * to_light(at) - 1.0, 1.0);
#else
  gl_Position = vec4(dot(clip[0], p), dot(clip[1], p), dot(clip[2], p), dot(clip[3], p));
#endif
  gl_ClipDistance[0] = at.y - viewport.z;
  normal = across;
  colour = vec4(0.62, 0.56, 0.44, 0.7);
  metallic = 0.0;
}
)";

const char* const kDepthFragment = R"(
void main() {}
)";

const char* const kSurfaceFragment = R"(
in vec3 at;
in vec3 normal;
flat in vec4 colour;
flat in float metallic;
out vec4 shown;

void main() {
  vec3 v = -normalize(at);
#ifdef RIBBON
  vec3 n = normalize(normal + v * sqrt(max(1.0 - dot(normal, normal), 0.0)));
#else
  vec3 n = normalize(normal);
#endif
  vec3 l = sun.xyz, h = normalize(l + v);
  float nl = dot(n, l), nv = max(dot(n, v), 0.05), nh = max(dot(n, h), 0.0);
  float roughness = max(colour.a, 0.06), a = roughness * roughness, a2 = a * a;
  vec3 matt = colour.rgb * (1.0 - metallic);
  vec3 f0 = mix(vec3(0.04), colour.rgb, metallic);

  float sunny = max(nl, 0.0);
#ifdef SHADOWS
  // Pushed out along the normal, the more the flatter the light falls.
  sunny *= lit(at + n * sun.w * (1.2 + 2.0 * (1.0 - sunny)));
#endif
  // GGX with the height-correlated Smith term in the form of Hammon (2017).
  float q = nh * nh * (a2 - 1.0) + 1.0;
  float d = a2 / (3.14159265 * q * q);
  float vis = 0.5 / mix(2.0 * sunny * nv + 1e-3, max(nl, 0.0) + nv, a);
  float u = 1.0 - max(dot(v, h), 0.0), u2 = u * u;
  vec3 f = f0 + (1.0 - f0) * (u2 * u2 * u);
  vec3 sum = sunlight.rgb * sunny * (matt * (1.0 / 3.14159265) * (1.0 - f) + f * min(d * vis, 4.0));

  // The sky above and the ground below, once scattered and once mirrored (fit of Karis 2014).
  sum += matt * mix(soil.rgb, sky.rgb, 0.5 + 0.5 * n.y);
  vec3 r = reflect(-v, n);
  vec3 mirrored = mix(soil.rgb, 1.9 * sky.rgb, smoothstep(-0.25 - roughness, 0.25 + roughness, r.y));
  vec4 k = roughness * vec4(-1.0, -0.0275, -0.572, 0.022) + vec4(1.0, 0.0425, 1.04, -0.04);
  float edge = min(k.x * k.x, exp2(-9.28 * nv)) * k.x + k.y;
  vec2 scale = vec2(-1.04, 1.04) * edge + k.zw;
  sum += mirrored * (f0 * scale.x + scale.y);
  shown = vec4(display(sum), 1.0);
}
)";

const char* const kScreenVertex = R"(
void main() {
  gl_Position = vec4(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0, 0.0, 1.0);
}
)";

const char* const kSkyFragment = R"(
out vec4 shown;
void main() {
  // Taken in the middle column: rows of one colour are packed well by every encoder.
  vec3 way = ray[0].xyz + ray[1].xyz / viewport.x + gl_FragCoord.y * ray[2].xyz;
  float up = way.y * inversesqrt(dot(way, way));
  float t = clamp(1.6 * abs(up), 0.0, 1.0);
  shown = vec4(sqrt(mix(horizon.rgb, zenith.rgb, t * (2.0 - t))), 1.0);
}
)";

// The four tile colours use the same lighting as the solids. They are mixed as squares of display
// values, which is nearly linear light and needs only one square root here.
const char* const kGroundFragment = R"(
out vec4 shown;
#ifdef NEAR
uniform sampler2D contact_shade;
#endif

void main() {
  vec3 way = ray[0].xyz + gl_FragCoord.x * ray[1].xyz + gl_FragCoord.y * ray[2].xyz;
  float down = soil.w / way.y;
  vec2 position = down * way.xz;
  // Checkers and lines averaged over the pixel's footprint, by their integrals.
  vec2 p = (position + ground_origin.xy) / horizon.w;
  vec2 wide = max(abs(dFdx(p)), abs(dFdy(p))) + 1e-4;
  vec2 lo = p - 0.5 * wide, hi = p + 0.5 * wide;
  vec2 wave = 2.0 * (abs(fract(0.5 * lo) - 0.5) - abs(fract(0.5 * hi) - 0.5)) / wide;
  float dark = 0.5 - 0.5 * wave.x * wave.y;
  vec2 l0 = lo + 0.5 * LINE, l1 = hi + 0.5 * LINE;
  vec2 line = (floor(l1) + min(fract(l1) / LINE, 1.0) - floor(l0) - min(fract(l0) / LINE, 1.0)) *
              LINE / wide;
  float ink = 1.0 - 0.30 * max(line.x, line.y);

  vec3 c = mix(tiles[0].rgb, tiles[1].rgb, dark);
#ifdef NEAR
  vec2 at = position * shade_map.xy + shade_map.zw;
  float open = texture(contact_shade, at).r;
#ifdef SHADOWS
  c = mix(mix(tiles[2].rgb, tiles[3].rgb, dark), c, lit(vec3(position.x, soil.w, position.y)));
#endif
  c *= open * open;
#endif
  float far = dot(position - ground_origin.zw, position - ground_origin.zw) / (zenith.w * zenith.w);
  float fade = 1.0 / (1.0 + far * far);
  shown = vec4(sqrt(mix(horizon.rgb, c * ink, fade)), 1.0);
}
)";

const char* const kMergeFragment = R"(
uniform sampler2D solids;
out vec4 shown;
void main() { shown = texelFetch(solids, ivec2(gl_FragCoord.xy), 0); }
)";

const char* const kOverlayVertex = R"(
layout(location = 0) in vec2 pixel;
layout(location = 1) in vec2 local;
layout(location = 2) in vec4 form;
layout(location = 3) in vec4 paint;
out vec2 inside;
flat out vec4 shape;
flat out vec4 colour;
void main() {
  gl_Position = vec4(pixel * viewport.xy - 1.0, 0.0, 1.0);
  inside = local;
  shape = form;
  colour = paint;
}
)";

// form.w 0: a glyph, `inside` in the atlas. 1: a rounded box of half size form.xy and radius
// form.z, `inside` in pixels from its centre; a line is a rotated box.
const char* const kOverlayFragment = R"(
in vec2 inside;
flat in vec4 shape;
flat in vec4 colour;
uniform sampler2D atlas;
out vec4 shown;
void main() {
  float cover;
  if (shape.w < 0.5) {
    cover = texture(atlas, inside).r;
  } else {
    vec2 d = abs(inside) - shape.xy + shape.z;
    float outside = length(max(d, 0.0)) + min(max(d.x, d.y), 0.0) - shape.z;
    cover = clamp(0.5 - outside, 0.0, 1.0);
  }
  shown = vec4(colour.rgb, colour.a * cover);
}
)";

namespace {

Result<GLuint> compile(const Gl& gl, GLenum stage, const std::string& defines, const char* source) {
  const std::string head = "#version 330 core\n" + defines;
  const char* const parts[] = {head.c_str(), kFrameSource, source};
  const GLuint shader = gl.CreateShader(stage);
  gl.ShaderSource(shader, 3, parts, nullptr);
  gl.CompileShader(shader);
  GLint good = 0;
  gl.GetShaderiv(shader, GL_COMPILE_STATUS, &good);
  if (good) return shader;
  char log[1024] = "";
  gl.GetShaderInfoLog(shader, sizeof log, nullptr, log);
  gl.DeleteShader(shader);
  return Error{std::string("the driver refuses a shader: ") + log};
}

}  // namespace

Result<GLuint> make_program(const Gl& gl, const std::string& defines, const char* vertex,
                            const char* fragment) {
  auto first = compile(gl, GL_VERTEX_SHADER, defines, vertex);
  if (!first) return first;
  auto second = compile(gl, GL_FRAGMENT_SHADER, defines, fragment);
  if (!second) return second;
  const GLuint program = gl.CreateProgram();
  gl.AttachShader(program, *first);
  gl.AttachShader(program, *second);
  gl.LinkProgram(program);
  gl.DeleteShader(*first);
  gl.DeleteShader(*second);
  GLint good = 0;
  gl.GetProgramiv(program, GL_LINK_STATUS, &good);
  if (good) return program;
  char log[1024] = "";
  gl.GetProgramInfoLog(program, sizeof log, nullptr, log);
  gl.DeleteProgram(program);
  return Error{std::string("the driver does not link a program: ") + log};
}

}  // namespace pantin::detail

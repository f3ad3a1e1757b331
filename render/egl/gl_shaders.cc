#include "render/egl/gl_shaders.h"

#include <initializer_list>
#include <string>

#include "core/base/error.h"

namespace engram::gl {
namespace {

constexpr const char* kVersion = "#version 420 core\n";

constexpr const char* kVertexShader = R"(
layout(location = 0) in vec4 corner;     // of a shape of size 1; w: at which end of a capsule
layout(location = 1) in vec3 direction;  // normal
layout(location = 2) in vec4 row_x;      // pose of the instance, row by row
layout(location = 3) in vec4 row_y;
layout(location = 4) in vec4 row_z;
layout(location = 5) in vec4 scale;
layout(location = 6) in vec4 rgb_emission;
layout(location = 7) in ivec2 kind;      // segment, surface
uniform mat4 clip_from_world;
out vec3 normal;
flat out vec4 color;
flat out ivec2 identity;
out vec3 world;
#ifdef PATTERNS
out vec2 place;  // along, across
#endif

vec2 place_on_box(vec3 local) {
  vec3 side = abs(direction);
  if (side.x > 0.5) return scale.z > scale.y ? local.zy : local.yz;
  if (side.y > 0.5) return scale.x > scale.z ? local.xz : local.zx;
  return scale.y > scale.x ? local.yx : local.xy;
}

void main() {
  vec3 local = corner.xyz * scale.xyz + vec3(0, 0, corner.w * scale.w);
  vec3 n = direction / scale.xyz;
  vec4 from = vec4(local, 1);
  vec3 at = vec3(dot(row_x, from), dot(row_y, from), dot(row_z, from));
  normal = vec3(dot(row_x.xyz, n), dot(row_y.xyz, n), dot(row_z.xyz, n)) * inversesqrt(dot(n, n));
  world = at;
#ifdef PATTERNS
  if ((kind.y & 4) == 0) {
    place = place_on_box(local);
  } else {
    place = (kind.y & 8) == 0 ? local.xy : local.yx;
  }
  place *= scale.w;
  if ((kind.y & 16) != 0) place = place.yx;
#endif
  color = rgb_emission;
  identity = kind;
  gl_Position = clip_from_world * vec4(at, 1);
}
)";

constexpr const char* kColorHead = R"(
in vec3 normal;
in vec3 world;
flat in vec4 color;
flat in ivec2 identity;
uniform vec3 to_light[8];
uniform vec3 light_color[8];
uniform vec3 ambient;
layout(location = 0) out vec4 result;
)";

// The formulas of render/cpu/shade_body.h.
constexpr const char* kPatterns = R"(
in vec2 place;
uniform sampler2D wood_texels;
uniform vec2 wood_size;  // m

vec3 wood(vec2 at, vec2 footprint) {
  ivec2 size = textureSize(wood_texels, 0);
  vec2 texels_per_metre = vec2(size) / wood_size;
  vec2 texels = footprint * texels_per_metre;
  float larger = max(texels.x, texels.y);
  int level = 0;
  for (; larger > 2.0 && level < 7; ++level) larger *= 0.5;
  ivec2 texel = ivec2(floor(at * texels_per_metre / float(1 << level))) & ((size >> level) - 1);
  float brightness = texelFetch(wood_texels, texel, level).r;
  return 1.0 + (255.0 * brightness - 128.0) / 300.0 * vec3(0.90, 1.00, 1.10);
}

vec3 grid(vec2 at) {
  at += vec2(-0.009, 0.009);
  vec2 bright = max(1.0 - abs(at - round(at)) / 0.0195, 0.0);
  return vec3(1.0 + 0.46 * max(bright.x, bright.y));
}

vec3 pattern_at(vec2 at, vec2 footprint) {
  int pattern = identity.y & 3;
  if (pattern == 0) return vec3(1);
  return pattern == 1 ? wood(at, footprint) : grid(at);
}

uniform vec3 eye;

// Mirror image of the lights, of which `arriving` is left.
float gloss(float arriving) {
  if ((identity.y & 3) != 1) return 1.0;
  const float kStrength = 0.548;
  const float kWidth = 0.134;
  vec3 n = normalize(normal);
  vec3 to_eye = normalize(eye - world);
  float sum = 0.0;
  for (int i = 0; i < LIGHTS; ++i) {
    float facing = dot(n, to_light[i]);
    if (facing <= 0.0) continue;
    float along = dot(n, to_eye) + facing;
    float square = along * along;
    float lobe = square * kWidth / max(2.0 + 2.0 * dot(to_eye, to_light[i]) -
                                       square * (1.0 - kWidth), 1e-6);
    sum += lobe * lobe;
  }
  return 1.0 + kStrength * sum * arriving;
}

vec3 pattern() {
  vec2 by_x = dFdx(place);
  vec2 by_y = dFdy(place);
  vec2 footprint = max(abs(by_x), abs(by_y));
#ifdef SMOOTH
  vec3 sum = vec3(0);
  for (int i = 0; i < 4; ++i) {
    vec2 shift = vec2(i & 1, i >> 1) * 0.5 - 0.25;
    sum += pattern_at(place + shift.x * by_x + shift.y * by_y, 0.5 * footprint);
  }
  return 0.25 * sum;
#else
  return pattern_at(place, footprint);
#endif
}
)";

constexpr const char* kNoPattern = R"(
float gloss(float arriving) { return 1.0; }
vec3 pattern() { return vec3(1); }
)";

constexpr const char* kNoShadow = R"(
float arriving(int light) { return 1.0; }
)";

// The blockers' mean distance gives the width of the penumbra. Maps hold the sides that face away
// from the light, so that lit surfaces cannot shadow themselves.
constexpr const char* kShadow = R"(
uniform sampler2DArrayShadow shadow_map;
uniform sampler2DArray shadow_depth;
uniform mat4 light_from_world[8];
uniform int shadow_layer[8];    // or -1
uniform float shadow_width[8];  // of each map, m; it is as deep
uniform float shadow_softness;  // tangent of the cone's half angle

uniform vec2 spiral[16];        // places spread over the unit disc

float arriving(int light) {
  int layer = shadow_layer[light];
  if (layer < 0 || dot(normal, to_light[light]) <= 0.0) return 1.0;
  vec3 at = (light_from_world[light] * vec4(world, 1)).xyz * 0.5 + 0.5;
  const float kFarthestBlocker = 0.6;  // m; softer still is not drawn
  const float kBias = 0.0005;          // m
  float own = at.z - kBias / shadow_width[light];
  float search = shadow_softness * kFarthestBlocker / shadow_width[light];
  float sum = 0.0;
  float count = 0.0;
  for (int i = 0; i < 16; ++i) {
    float depth = texture(shadow_depth, vec3(at.xy + search * spiral[i], layer)).r;
    if (depth < min(own, 1.0)) {
      sum += own - depth;
      count += 1.0;
    }
  }
  if (count == 0.0) return 1.0;
  float radius = max(min(shadow_softness * sum / count, search),
                     0.7 / float(textureSize(shadow_depth, 0).x));
  float lit = 0.0;
  for (int i = 0; i < 16; ++i) {
    lit += texture(shadow_map, vec4(at.xy + radius * spiral[i], layer, min(own, 1.0)));
  }
  return lit / 16.0;
}
)";

constexpr const char* kColorMain = R"(
void main() {
  vec3 n = normalize(normal);
  vec3 light = ambient + color.a;
  float sum = 0.0;
  for (int i = 0; i < LIGHTS; ++i) {
    float amount = max(dot(n, to_light[i]), 0.0);
    float here = arriving(i);
    light += light_color[i] * (amount * here);
    sum += here;
  }
  result = vec4(color.rgb * light * pattern() * gloss(sum / max(float(LIGHTS), 1.0)), 1);
}
)";

constexpr const char* kDataShader = R"(
flat in ivec2 identity;
layout(location = 0) out float depth;
layout(location = 1) out int segment;
void main() {
  depth = 1.0 / gl_FragCoord.w;
  segment = identity.x;
}
)";

constexpr const char* kNothing = R"(
void main() {}
)";

GLuint compile(const Gl& gl, GLenum stage, std::initializer_list<const char*> parts) {
  std::string source = kVersion;
  for (const char* part : parts) source += part;
  const char* text = source.c_str();
  const GLuint shader = gl.CreateShader(stage);
  gl.ShaderSource(shader, 1, &text, nullptr);
  gl.CompileShader(shader);
  GLint ok = 0;
  gl.GetShaderiv(shader, GL_COMPILE_STATUS, &ok);
  if (ok == 0) {
    char log[400] = "";
    gl.GetShaderInfoLog(shader, sizeof log, nullptr, log);
    throw Error(Error::kUnavailable, std::string("egl renderer: shader refused: ") + log);
  }
  return shader;
}

GLuint link(const Gl& gl, GLuint vertices, GLuint fragments) {
  const GLuint program = gl.CreateProgram();
  gl.AttachShader(program, vertices);
  gl.AttachShader(program, fragments);
  gl.LinkProgram(program);
  gl.DeleteShader(vertices);
  gl.DeleteShader(fragments);
  GLint ok = 0;
  gl.GetProgramiv(program, GL_LINK_STATUS, &ok);
  if (ok == 0) {
    char log[400] = "";
    gl.GetProgramInfoLog(program, sizeof log, nullptr, log);
    throw Error(Error::kUnavailable, std::string("egl renderer: program refused: ") + log);
  }
  return program;
}

}  // namespace

GLuint make_color_program(const Gl& gl, const ColorFeatures& features) {
  std::string defines = "#define LIGHTS " + std::to_string(features.lights) + "\n";
  if (features.shadows) defines += "#define SHADOWS\n";
  if (features.patterns) defines += "#define PATTERNS\n";
  if (features.smooth) defines += "#define SMOOTH\n";
  const GLuint vertices = compile(gl, GL_VERTEX_SHADER, {defines.c_str(), kVertexShader});
  const GLuint fragments =
      compile(gl, GL_FRAGMENT_SHADER,
              {defines.c_str(), kColorHead, features.patterns ? kPatterns : kNoPattern,
               features.shadows ? kShadow : kNoShadow, kColorMain});
  return link(gl, vertices, fragments);
}

GLuint make_data_program(const Gl& gl) {
  const GLuint vertices = compile(gl, GL_VERTEX_SHADER, {kVertexShader});
  return link(gl, vertices, compile(gl, GL_FRAGMENT_SHADER, {kDataShader}));
}

GLuint make_depth_program(const Gl& gl) {
  const GLuint vertices = compile(gl, GL_VERTEX_SHADER, {kVertexShader});
  return link(gl, vertices, compile(gl, GL_FRAGMENT_SHADER, {kNothing}));
}

}  // namespace engram::gl

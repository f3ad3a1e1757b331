#include "core/image/scene_from_model.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <span>
#include <string>
#include <string_view>

#include "core/base/error.h"
#include "core/base/index.h"
#include "core/scene/mujoco_versions.h"

namespace engram {
namespace {

using Rgba = std::array<float, 4>;
using Rotation = Eigen::Matrix<float, 3, 3, Eigen::RowMajor>;
using Position = Eigen::Matrix<float, 3, 1>;

// Appends a pose given by a position and a quaternion of length 1.
void append_pose(const mjtNum* position, const mjtNum* quaternion, std::vector<float>& poses) {
  mjtNum rotation[9];
  mju_quat2Mat(rotation, quaternion);
  for (const mjtNum x : rotation) poses.push_back(static_cast<float>(x));
  for (int k = 0; k < 3; ++k) poses.push_back(static_cast<float>(position[k]));
}

bool contains_any(std::string_view text, std::initializer_list<std::string_view> words) {
  return std::any_of(words.begin(), words.end(), [text](std::string_view word) {
    return text.find(word) != std::string_view::npos;
  });
}

RenderPattern pattern_of(const mjModel& model, int material) {
  if (material < 0) return RenderPattern::kPlain;
  const std::string_view name = model.names + model.name_matadr[material];
  if (contains_any(name, {"wood"})) return RenderPattern::kWood;
  if (contains_any(name, {"grid", "floor", "tile"})) return RenderPattern::kGrid;
  return RenderPattern::kPlain;
}

// Mean colour of a material's texture; white without one.
std::array<float, 3> texture_color(const mjModel& model, int material) {
  const int texture = texture_of(model, material);
  if (texture < 0) return {1, 1, 1};
  const int pixels = model.tex_width[texture] * model.tex_height[texture];
  const mjtByte* rgb = texture_pixels(model, texture);
  std::array<double, 3> sum = {};
  for (int i = 0; i < pixels; ++i) {
    for (std::size_t k = 0; k < 3; ++k) sum[k] += rgb[at(3 * i) + k];
  }
  const double scale = 1.0 / (255.0 * std::max(pixels, 1));
  return {static_cast<float>(sum[0] * scale), static_cast<float>(sum[1] * scale),
          static_cast<float>(sum[2] * scale)};
}

// A geom's own colour wins over its material's unless it is the default, as in MuJoCo's renderer.
Rgba color_of(const mjModel& model, int geom) {
  const float* own = model.geom_rgba + 4 * geom;
  Rgba rgba = {own[0], own[1], own[2], own[3]};
  const int material = model.geom_matid[geom];
  if (material < 0) return rgba;
  if (rgba == Rgba{0.5F, 0.5F, 0.5F, 1}) {
    std::copy_n(model.mat_rgba + 4 * material, 4, rgba.begin());
  }
  const std::array<float, 3> texture = texture_color(model, material);
  for (std::size_t k = 0; k < 3; ++k) rgba[k] *= texture[k];
  return rgba;
}

// The triangles of a mesh's convex hull if the model has it, else the mesh's own.
std::span<const int> hull_faces(const mjModel& model, int mesh) {
  if (model.mesh_graphadr[mesh] < 0) {
    return {model.mesh_face + 3 * model.mesh_faceadr[mesh], at(3 * model.mesh_facenum[mesh])};
  }
  const int* graph = model.mesh_graph + model.mesh_graphadr[mesh];
  const int vertices = graph[0];
  const int faces = graph[1];
  // Two counts, then for each vertex its edges' address and its index, then edges, then faces.
  return {graph + 2 + 2 * vertices + vertices + 3 * faces, at(3 * faces)};
}

RenderMesh mesh_of(const mjModel& model, int mesh) {
  RenderMesh result;
  const int count = model.mesh_vertnum[mesh];
  const float* vertices = model.mesh_vert + 3 * model.mesh_vertadr[mesh];
  result.vertices.assign(vertices, vertices + 3 * count);
  const std::span<const int> faces = hull_faces(model, mesh);
  result.triangles.assign(faces.begin(), faces.end());

  // Counter-clockwise from outside, whatever the order was: the middle is inside.
  const auto point = [vertices](int index) {
    return Vec3(Eigen::Map<const Position>(vertices + 3 * index).cast<double>());
  };
  Vec3 middle = Vec3::Zero();
  for (int i = 0; i < count; ++i) middle += point(i) / count;
  for (std::size_t t = 0; t + 2 < result.triangles.size(); t += 3) {
    const Vec3 a = point(result.triangles[t]);
    const Vec3 b = point(result.triangles[t + 1]);
    const Vec3 c = point(result.triangles[t + 2]);
    if ((b - a).cross(c - a).dot(a - middle) < 0) {
      std::swap(result.triangles[t + 1], result.triangles[t + 2]);
    }
  }
  return result;
}

RenderShape shape_of(const mjModel& model, int geom) {
  switch (model.geom_type[geom]) {
    case mjGEOM_PLANE:
      return RenderShape::kPlane;
    case mjGEOM_SPHERE:
      return RenderShape::kSphere;
    case mjGEOM_CAPSULE:
      return RenderShape::kCapsule;
    case mjGEOM_ELLIPSOID:
      return RenderShape::kEllipsoid;
    case mjGEOM_CYLINDER:
      return RenderShape::kCylinder;
    case mjGEOM_BOX:
      return RenderShape::kBox;
    case mjGEOM_MESH:
      return RenderShape::kMesh;
    default:
      throw Error(Error::kInvalidArgument,
                  "scene_from_model: geom " + std::to_string(geom) + " is of type " +
                      std::to_string(model.geom_type[geom]) +
                      "; allowed are plane, sphere, capsule, ellipsoid, cylinder, box and mesh");
  }
}

// Groups of geoms, as the documents use them.
constexpr int kPeopleGroup = 1;  // not for the robot's sensors
constexpr int kLastVisibleGroup = 2;

bool is_shown(const mjModel& model, int geom, bool for_people) {
  const int group = model.geom_group[geom];
  return group <= kLastVisibleGroup && (for_people || group != kPeopleGroup);
}

void add_geom(const mjModel& model, int geom, std::vector<int>& mesh_index, ModelScene& result) {
  const Rgba rgba = color_of(model, geom);
  if (rgba[3] <= 0) return;

  RenderGeom out;
  out.shape = shape_of(model, geom);
  out.segment = geom + 1;
  const int material = model.geom_matid[geom];
  out.pattern = pattern_of(model, material);
  for (int k = 0; k < 3; ++k) out.size[k] = static_cast<float>(model.geom_size[3 * geom + k]);
  if (out.shape == RenderShape::kMesh) {
    const int mesh = model.geom_dataid[geom];
    int& index = mesh_index[at(mesh)];
    if (index < 0) {
      index = static_cast<int>(result.scene.meshes.size());
      result.scene.meshes.push_back(mesh_of(model, mesh));
    }
    out.mesh = index;
  }
  result.scene.geoms.push_back(out);
  result.model_geom.push_back(geom);
  result.geom_body.push_back(model.geom_bodyid[geom]);
  append_pose(model.geom_pos + 3 * geom, model.geom_quat + 4 * geom, result.geom_local);
  result.rgba.insert(result.rgba.end(), rgba.begin(), rgba.end());
  result.emission.push_back(material < 0 ? 0.0F : model.mat_emission[material]);
}

void add_camera(const mjModel& model, int camera, ModelScene& result) {
  RenderCamera out;
  out.name = model.names + model.name_camadr[camera];
  out.fovy = static_cast<float>(model.cam_fovy[camera] * std::numbers::pi / 180);
  const auto extent = static_cast<float>(model.stat.extent);
  out.near_clip = model.vis.map.znear * extent;
  out.far_clip = model.vis.map.zfar * extent;
  result.scene.cameras.push_back(out);
  result.camera_body.push_back(model.cam_bodyid[camera]);
  append_pose(model.cam_pos + 3 * camera, model.cam_quat + 4 * camera, result.camera_local);
}

void add_lights(const mjModel& model, RenderScene& scene) {
  std::copy_n(model.vis.headlight.ambient, 3, scene.ambient);
  for (int i = 0; i < model.nlight; ++i) {
    if (model.light_active[i] == 0) continue;
    for (int k = 0; k < 3; ++k) scene.ambient[k] += model.light_ambient[3 * i + k];
    if (!is_directional(model, i)) continue;
    RenderLight light;
    for (int k = 0; k < 3; ++k) {
      light.direction[k] = static_cast<float>(model.light_dir0[3 * i + k]);
      light.color[k] = model.light_diffuse[3 * i + k];
    }
    light.casts_shadow = model.light_castshadow[i] != 0;
    scene.lights.push_back(light);
  }
}

// World pose = body frame * local pose, for each row.
void pose_rows(std::span<const int> bodies_of, std::span<const float> local, const Frame* bodies,
               const std::uint8_t* wanted, float* out) {
  for (std::size_t i = 0; i < bodies_of.size(); ++i) {
    if (wanted != nullptr && wanted[i] == 0) continue;
    const Frame& body = bodies[bodies_of[i]];
    const Eigen::Map<const Rotation> rotation(&local[12 * i]);
    const Eigen::Map<const Position> position(&local[12 * i + 9]);
    Eigen::Map<Rotation> to_rotation(out + 12 * i);
    Eigen::Map<Position> to_position(out + 12 * i + 9);
    to_rotation.noalias() = (body.axes.lazyProduct(rotation.cast<double>())).cast<float>();
    to_position = (body.axes * position.cast<double>() + body.pos).cast<float>();
  }
}

}  // namespace

ModelScene scene_from_model(const mjModel& model, bool for_people) {
  ModelScene result;
  std::vector<int> mesh_index(at(static_cast<int>(model.nmesh)), -1);
  for (int i = 0; i < model.ngeom; ++i) {
    if (is_shown(model, i, for_people)) add_geom(model, i, mesh_index, result);
  }
  for (int i = 0; i < model.ncam; ++i) add_camera(model, i, result);
  add_lights(model, result.scene);
  return result;
}

void pose_geoms(const ModelScene& scene, const Frame* bodies, float* geom_pose,
                const std::uint8_t* visible) {
  pose_rows(scene.geom_body, scene.geom_local, bodies, visible, geom_pose);
}
void pose_cameras(const ModelScene& scene, const Frame* bodies, float* camera_pose) {
  pose_rows(scene.camera_body, scene.camera_local, bodies, nullptr, camera_pose);
}

}  // namespace engram

#include "mjcf/scene.h"

#include <algorithm>

#include "mjcf/cameras.h"
#include "mjcf/contact_pairs.h"
#include "mjcf/panda.h"
#include "mjcf/panda_collision.h"
#include "mjcf/panda_visual.h"
#include "mjcf/prop_body.h"
#include "mjcf/prop_limits.h"
#include "mjcf/scenery.h"

namespace engram::mjcf {
namespace {

void add_compiler(Element& root) {
  Element& compiler = add(root, "compiler");
  set(compiler, "angle", "radian");
  set(compiler, "eulerseq", "XYZ");  // fixed axes: roll, pitch, yaw
  set(compiler, "inertiafromgeom", "false");
}

void add_options(Element& root) {
  Element& option = add(root, "option");
  set(option, "timestep", 0.01);
  set(option, "gravity", {0, 0, -9.81});
  set(option, "integrator", "Euler");
  set(option, "collision", "predefined");
  set(option, "cone", "elliptic");
  set(option, "impratio", 10);
  set(option, "solver", "Newton");
}

void add_defaults(Element& root) {
  Element& defaults = add(root, "default");
  set_pair_defaults(add(defaults, "pair"));
  Element& geom = add(defaults, "geom");
  set(geom, "contype", 0);
  set(geom, "conaffinity", 0);
}

// Degrees of freedom of a document.
int dof_count(const std::vector<Prop>& props) {
  int count = static_cast<int>(kStartPose.size());
  for (const Prop& prop : props) count += prop.body_type == BodyType::kDynamic ? 6 : 0;
  return count;
}

// Buffers for all contacts that can exist at once, with four rows each.
void add_sizes(Element& root, const std::vector<Prop>& props) {
  const int contacts = max_contacts(props);
  const int limits = static_cast<int>(kStartPose.size());
  const int rows = 4 * contacts + limits;
  const int dofs = dof_count(props);
  Element& size = add(root, "size");
  set(size, "nconmax", contacts);
  set(size, "njmax", rows);
  set(size, "nstack", 20000 + 8 * dofs * dofs + 4 * rows * (dofs + 16));
}

// The solver stops at an improvement relative to (mean inertia) x (degrees of freedom). That
// product is kept the same, so that the solver stops alike with and without props.
void add_statistic(Element& root, const std::vector<Prop>& props) {
  constexpr double kSolverScale = 4.5;
  Element& statistic = add(root, "statistic");
  set(statistic, "meaninertia", kSolverScale / dof_count(props));
  set(statistic, "extent", 1);
  set(statistic, "center", {-0.2, 0, 0.2});
}

// A keyframe "start": the tasks' start pose, held by the drives.
void add_start_keyframe(Element& root, const std::vector<Prop>& props) {
  std::vector<double> qpos(kStartPose.begin(), kStartPose.end());
  for (const Prop& prop : props) {
    if (prop.body_type != BodyType::kDynamic) continue;
    qpos.insert(qpos.end(), prop.pos.begin(), prop.pos.end());
    qpos.insert(qpos.end(), prop.quat.begin(), prop.quat.end());
  }
  Element& key = add(add(root, "keyframe"), "key");
  set(key, "name", "start");
  set(key, "qpos", qpos);
  set(key, "ctrl", kStartPose);
}

void add_assets(Element& root, const std::vector<Prop>& props, bool visuals) {
  if (!visuals && std::ranges::none_of(props, has_mesh)) return;
  Element& assets = add(root, "asset");
  if (visuals) {
    add_materials(assets);
    add_panda_materials(assets);
    for (const Prop& prop : props) add_prop_materials(assets, prop);
  }
  for (const Prop& prop : props) add_prop_meshes(assets, prop);
}

}  // namespace

std::string compose(const Scene& scene, Detail detail) {
  const bool visuals = detail == Detail::kFull;
  const bool collisions = detail != Detail::kRobotDynamics;
  const bool with_props = detail == Detail::kFull || detail == Detail::kPhysics;
  const std::vector<Prop> props = with_props ? scene.props : std::vector<Prop>{};
  check_props(props);

  tinyxml2::XMLDocument document;
  Element& root = *document.NewElement("mujoco");
  document.InsertEndChild(&root);
  set(root, "model", "engram");

  add_compiler(root);
  add_options(root);
  add_sizes(root, props);
  add_statistic(root, props);
  add_defaults(root);
  if (visuals) add_visual_options(root);
  add_assets(root, props, visuals);

  Element& world = add(root, "worldbody");
  if (collisions) add_table_top(world, scene.table_ends);
  if (visuals) {
    add_surroundings(world);
    add_world_cameras(world, scene.render_view);
  }
  const auto is_carried = [&scene](Link link) {
    return scene.wrist_camera || link != Link::kCamera;
  };
  Element& hand = add_panda(world, is_carried, [&](Element& body, Link link) {
    if (collisions) add_collision_geoms(body, link);
    if (visuals) add_visual_geoms(body, link);
  });
  if (visuals) add_hand_camera(hand);
  add_tcp_site(hand);
  for (const Prop& prop : props) add_prop(world, prop, visuals);

  if (collisions) add_contact_pairs(root, props, scene.table_ends, is_carried);
  add_finger_tendon(root);
  add_drives(root);
  add_start_keyframe(root, props);

  tinyxml2::XMLPrinter printer;
  document.Print(&printer);
  return printer.CStr();
}

}  // namespace engram::mjcf

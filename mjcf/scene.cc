#include "mjcf/scene.h"

#include <algorithm>
#include <array>
#include <functional>
#include <initializer_list>

#include "mjcf/cameras.h"
#include "mjcf/carrier.h"
#include "mjcf/contact_pairs.h"
#include "mjcf/drawn_props.h"
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
  set(option, "timestep", kTimestep);
  set(option, "gravity", {0, 0, -kGravity});
  set(option, "integrator", "Euler");
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

// Keyframes of these names: this pose of the robot, held by the drives. Carriers need no control.
void add_keyframes(Element& root, std::initializer_list<const char*> names,
                   const std::vector<Prop>& props, const std::array<double, 9>& robot,
                   std::size_t carriers) {
  std::vector<double> qpos(robot.begin(), robot.end());
  for (const Prop& prop : props) {
    if (prop.body_type != BodyType::kDynamic) continue;
    qpos.insert(qpos.end(), prop.pos.begin(), prop.pos.end());
    qpos.insert(qpos.end(), prop.quat.begin(), prop.quat.end());
  }
  std::vector<double> ctrl(robot.begin(), robot.end());
  ctrl.resize(ctrl.size() + carriers, 0.0);
  Element& keyframe = add(root, "keyframe");
  for (const char* name : names) {
    Element& key = add(keyframe, "key");
    set(key, "name", name);
    set(key, "qpos", qpos);
    set(key, "ctrl", ctrl);
  }
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

// A document: what it contains, and for a drawn scene what holds the weight that engram leaves out.
struct Contents {
  std::vector<Prop> props;
  Detail detail = Detail::kFull;
  std::array<double, 9> qpos = kStartPose;
  bool carries_robot = false;
  std::vector<bool> carries_prop = {};  // of each prop; empty: of none

  bool carries(std::size_t prop) const { return prop < carries_prop.size() && carries_prop[prop]; }
};

// The robot's bodies; the hand is returned.
Element& add_robot(Element& world, const Contents& contents,
                   const std::function<bool(Link link)>& is_carried) {
  return add_panda(world, is_carried, [&](Element& body, Link link) {
    if (contents.detail != Detail::kRobotDynamics) add_collision_geoms(body, link);
    if (contents.detail == Detail::kFull) add_visual_geoms(body, link);
    if (contents.carries_robot) add_carrier_site(body, link_name(link), link_spec(link).com);
  });
}

// Actuators that carry the robot's links and props without weight; their number.
std::size_t add_carriers(Element& root, const Contents& contents,
                         const std::function<bool(Link link)>& is_carried) {
  if (!contents.carries_robot) return 0;
  Element& actuators = add(root, "actuator");
  std::size_t count = 0;
  for (int i = 0; i < kLinkCount; ++i) {
    const LinkSpec& link = link_spec(static_cast<Link>(i));
    if (!is_carried(static_cast<Link>(i))) continue;
    add_carrier(actuators, link.name, link.mass);
    ++count;
  }
  for (std::size_t i = 0; i < contents.props.size(); ++i) {
    if (!contents.carries(i)) continue;
    add_carrier(actuators, contents.props[i].name, contents.props[i].mass);
    ++count;
  }
  return count;
}

void add_props(Element& world, const Contents& contents) {
  for (std::size_t i = 0; i < contents.props.size(); ++i) {
    const Prop& prop = contents.props[i];
    Element& body = add_prop(world, prop, contents.detail == Detail::kFull);
    if (contents.carries(i)) add_carrier_site(body, prop.name, prop.center_of_mass);
  }
}

std::string print(const Scene& scene, const Contents& contents) {
  const bool visuals = contents.detail == Detail::kFull;
  const bool collisions = contents.detail != Detail::kRobotDynamics;
  const std::vector<Prop>& props = contents.props;
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
  if (contents.carries_robot) add_carrier_frame(world);
  const auto is_carried = [&scene](Link link) {
    return scene.wrist_camera || link != Link::kCamera;
  };
  Element& hand = add_robot(world, contents, is_carried);
  if (visuals) add_hand_camera(hand);
  add_tcp_site(hand);
  add_props(world, contents);

  if (collisions) add_contact_pairs(root, props, scene.table_ends, is_carried);
  add_finger_tendon(root);
  add_drives(root);
  const std::size_t carriers = add_carriers(root, contents, is_carried);
  if (contents.carries_robot) {  // testspeed begins with "test"
    add_keyframes(root, {"start", "test"}, props, contents.qpos, carriers);
  } else {
    add_keyframes(root, {"start"}, props, contents.qpos, carriers);
  }

  tinyxml2::XMLPrinter printer;
  document.Print(&printer);
  return printer.CStr();
}

}  // namespace

std::string compose(const Scene& scene, Detail detail) {
  const bool with_props = detail == Detail::kFull || detail == Detail::kPhysics;
  return print(scene, {.props = with_props ? scene.props : std::vector<Prop>{}, .detail = detail});
}

std::string compose_drawn(const Scene& scene, const DrawnScene& drawn) {
  Contents contents{.props = drawn_props(scene.props, drawn), .qpos = drawn.qpos};
  contents.carries_robot = true;
  for (std::size_t i = 0; i < contents.props.size(); ++i) {
    contents.carries_prop.push_back(drawn.props[i].hidden &&
                                    contents.props[i].body_type == BodyType::kDynamic);
  }
  return print(scene, contents);
}

}  // namespace engram::mjcf

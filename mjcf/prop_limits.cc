#include "mjcf/prop_limits.h"

#include <algorithm>
#include <string>

#include "core/base/error.h"
#include "mjcf/prop_body.h"
#include "mjcf/table_contact.h"

namespace engram::mjcf {
namespace {

// Upper bound of the contacts of one prop with the table and its neighbours. Its geoms are not all
// in contact at once.
int max_contacts(const Prop& prop) {
  const int geoms = static_cast<int>(collision_geom_names(prop).size());
  if (prop.body_type == BodyType::kKinematic) return 4 * geoms;
  return std::min(8 * geoms, table_contact_count(prop) + 8);
}

// True if all moments of inertia are above MuJoCo's least: the matrix less that much is positive
// definite.
bool has_enough_inertia(const Prop& prop) {
  constexpr double kMinInertia = 2e-14;  // kg m^2
  const auto& [xx, yy, zz, xy, xz, yz] = prop.inertia;
  const double a = xx - kMinInertia;
  const double b = yy - kMinInertia;
  const double c = zz - kMinInertia;
  const double minor = a * b - xy * xy;
  return a > 0 && minor > 0 && c * minor - yz * (a * yz - xy * xz) + xz * (xy * yz - b * xz) > 0;
}

[[noreturn]] void refuse(const std::string& what) { throw Error(Error::kInvalidArgument, what); }

}  // namespace

int max_contacts(const std::vector<Prop>& props) {
  int contacts = 64;  // of the robot
  for (const Prop& prop : props) contacts += max_contacts(prop);
  return contacts;
}

void check_props(const std::vector<Prop>& props) {
  constexpr std::size_t kMaxProps = 64;  // the objects observation has a bit for each
  constexpr int kMaxContacts = 5000;     // MuJoCo's buffers grow with their square
  if (props.size() > kMaxProps) {
    refuse(std::to_string(props.size()) + " props given, at most " + std::to_string(kMaxProps) +
           " allowed");
  }
  for (const Prop& prop : props) {
    if (prop.body_type != BodyType::kDynamic || has_enough_inertia(prop)) continue;
    refuse("prop '" + prop.name +
           "': too small or too light to move, moments of inertia of 2e-14 kg m^2 or more needed "
           "(a cube with sides of 0.7 mm has them); a body that is kinematic or visual has none");
  }
  const int contacts = max_contacts(props);
  if (contacts > kMaxContacts) {
    refuse("props with up to " + std::to_string(contacts) + " contacts at once given, at most " +
           std::to_string(kMaxContacts) + " allowed; fewer geoms that collide needed");
  }
}

}  // namespace engram::mjcf

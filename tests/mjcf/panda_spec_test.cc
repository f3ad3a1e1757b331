#include "mjcf/panda_spec.h"

#include <catch2/catch.hpp>
#include <string>

namespace engram::mjcf {
namespace {

TEST_CASE("Parents come before their children", "[mjcf][panda]") {
  CHECK(link_spec(Link::kLink0).parent == kWorldParent);
  for (int i = 1; i < kLinkCount; ++i) {
    const LinkSpec& link = link_spec(static_cast<Link>(i));
    CHECK(link.parent >= 0);
    CHECK(link.parent < i);
    CHECK(link.mass > 0);
  }
  CHECK(std::string(link_name(Link::kCamera)) == "camera_link");
}

TEST_CASE("The start pose is within the joints' limits", "[mjcf][panda]") {
  REQUIRE(joint_specs().size() == kStartPose.size());
  for (std::size_t i = 0; i < kStartPose.size(); ++i) {
    CHECK(kStartPose[i] >= joint_specs()[i].lower);
    CHECK(kStartPose[i] <= joint_specs()[i].upper);
    CHECK(is_finger(joint_specs()[i].link) == (i >= 7));
  }
}

}  // namespace
}  // namespace engram::mjcf

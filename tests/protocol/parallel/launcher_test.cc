#include "protocol/parallel/launcher.h"

#include <catch2/catch.hpp>
#include <vector>

namespace engram {
namespace {

bool launched(const std::vector<Ancestor>& ancestors) { return is_launched(ancestors); }

TEST_CASE("Launcher: its own child, and that of its scripts", "[work]") {
  CHECK(launched({{"mpirun", false}}));
  CHECK(launched({{"slurmstepd", false}, {"systemd", false}}));
  CHECK(launched({{"hydra_pmi_proxy", true}}));
  CHECK(launched({{"bash", true}, {"orted", false}}));
  CHECK(launched({{"sh", true}, {"timeout", true}, {"prted", false}}));
}

TEST_CASE("Launcher: other programs that it has started have ranks of their own", "[work]") {
  CHECK_FALSE(launched({}));
  CHECK_FALSE(launched({{"python3", true}, {"mpirun", true}}));
  CHECK_FALSE(launched({{"sh", true}, {"python3", true}, {"mpirun", true}}));
  CHECK_FALSE(launched({{"bash", true}, {"sshd", false}}));
}

TEST_CASE("Launcher: an interactive shell has not been started for this", "[work]") {
  CHECK_FALSE(launched({{"bash", false}, {"slurmstepd", false}}));
}

TEST_CASE("Launcher: this test has a parent, which is none", "[work]") {
  std::string parent;
  CHECK_FALSE(is_launched(parent));
  CHECK_FALSE(parent.empty());
}

}  // namespace
}  // namespace engram

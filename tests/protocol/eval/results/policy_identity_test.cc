#include "protocol/eval/results/policy_identity.h"

#include <catch2/catch.hpp>

#include "protocol/io/files.h"
#include "tests/temporary_folder.h"

namespace engram {
namespace {

const Json kFirst = JsonTable{{"checkpoint", "a"}, {"server", "x"}};
const Json kRestarted = JsonTable{{"checkpoint", "a"}, {"server", "y"}};
const Json kOther = JsonTable{{"checkpoint", "b"}};
const Json kSilent = JsonTable{{"server", "z"}};

TEST_CASE("A run keeps what its policy tells first, and has one checkpoint", "[results]") {
  const test::TemporaryFolder folder;
  const auto file = folder.path() / "policy.json";
  {
    PolicyIdentity identity(ResultFolder::open(folder.path()));
    identity.take({});
    CHECK_FALSE(std::filesystem::exists(file));
    identity.take(kFirst);
    identity.take(kRestarted);
    identity.take(kSilent);
    CHECK((identity.document() == kFirst));
    CHECK_THROWS_WITH(identity.take(kOther),
                      R"(the policy tells checkpoint "b", and told "a" before in this run; )"
                      "one run has one policy");
    CHECK((parse_json(*read_file(file)) == kFirst));
  }
  PolicyIdentity resumed(ResultFolder::open(folder.path()));
  CHECK((resumed.document() == kFirst));
  CHECK_THROWS_AS(resumed.take(kOther), Error);
  resumed.take(kRestarted);

  PolicyIdentity nowhere(std::nullopt);
  nowhere.take(kOther);
  CHECK((nowhere.document() == kOther));
}

TEST_CASE("A damaged file tells nothing", "[results]") {
  const test::TemporaryFolder folder;
  const auto file = folder.path() / "policy.json";
  CHECK(is_null(PolicyIdentity::in(OpenFolder(folder.path()))));
  for (const char* text : {"", "{", "[7]"}) {
    write_file(file, text);
    CHECK(is_null(checkpoint_of(PolicyIdentity::in(OpenFolder(folder.path())))));
  }
}

TEST_CASE("Checkpoints differ where both are told", "[results]") {
  CHECK(has_other_checkpoint(kFirst, kOther));
  CHECK_FALSE(has_other_checkpoint(kFirst, kRestarted));
  CHECK_FALSE(has_other_checkpoint(kFirst, kSilent));
  CHECK_FALSE(has_other_checkpoint(kSilent, {}));
  CHECK(checkpoint_text(JsonTable{{"checkpoint", std::string(500, 'x')}}).size() == 103);
}

}  // namespace
}  // namespace engram

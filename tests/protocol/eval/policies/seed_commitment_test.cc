#include "protocol/eval/policies/seed_commitment.h"

#include <fcntl.h>
#include <unistd.h>

#include <array>
#include <catch2/catch.hpp>
#include <set>

#include "core/base/error.h"
#include "core/base/sha256.h"
#include "protocol/io/files.h"
#include "tests/temporary_folder.h"

namespace engram {
namespace {

const std::string kSecret = "0123456789abcdef0123456789abcdef\n";

TEST_CASE("A seal has the hash of its file and a seed that does not show the secret", "[seal]") {
  const SeedCommitment commitment(kSecret);
  CHECK(commitment.hash() == to_hex(sha256(kSecret)));
  CHECK(commitment.start_seed() == SeedCommitment(kSecret).start_seed());
  CHECK(commitment.start_seed() != leading_number(sha256(kSecret)));  // which the hash shows
  std::string other = kSecret;
  other[0] = '1';
  CHECK(SeedCommitment(other).start_seed() != commitment.start_seed());
}

TEST_CASE("A secret is one line that cannot be guessed", "[seal]") {
  const std::string fitting(32, 'a');
  std::vector<std::string> secrets = {"", "4242424242\n", fitting + "\n\n", fitting + "\r\n"};
  secrets.push_back(fitting.substr(1));
  secrets.emplace_back(1025, 'a');
  secrets.emplace_back(40, '\0');
  for (const std::string& secret : secrets) {
    CHECK_THROWS_WITH(SeedCommitment(secret),
                      Catch::Contains("one line of 32 to 1024 characters needed") &&
                          Catch::Contains("openssl rand -hex 32"));
  }
  CHECK_NOTHROW(SeedCommitment(fitting));
  CHECK_THROWS_WITH(SeedCommitment::of_hash("12"), Catch::Contains("64 hexadecimal digits needed"));
}

TEST_CASE("A seal of which the hash is known has no secret", "[seal]") {
  const SeedCommitment commitment = SeedCommitment::of_hash(SeedCommitment(kSecret).hash());
  CHECK_FALSE(commitment.has_secret());
  CHECK(commitment.hash() == SeedCommitment(kSecret).hash());
}

TEST_CASE("A secret comes from a file or an open descriptor, which is closed", "[seal]") {
  const test::TemporaryFolder folder;
  const std::filesystem::path file = folder.path() / "seed";
  CHECK_THROWS_WITH(SeedCommitment::read(file), Catch::Contains("does not exist"));
  write_file(file, kSecret);
  CHECK(SeedCommitment::read(file).secret() == kSecret);
  const int open = ::open(file.c_str(), O_RDONLY);
  CHECK(SeedCommitment::read("/dev/fd/" + std::to_string(open)).secret() == kSecret);
  CHECK(::fcntl(open, F_GETFD) == -1);
  std::array<int, 2> pipe{};
  REQUIRE(::pipe(pipe.data()) == 0);
  REQUIRE(::write(pipe[1], kSecret.data(), kSecret.size()) == static_cast<ssize_t>(kSecret.size()));
  ::close(pipe[1]);
  CHECK(SeedCommitment::read("/proc/self/fd/" + std::to_string(pipe[0])).secret() == kSecret);
  CHECK(::fcntl(pipe[0], F_GETFD) == -1);
}

TEST_CASE("Opaque numbers are the same in every run and differ among episodes", "[seal]") {
  std::set<std::int32_t> numbers;
  for (const char* id : {"RememberColor3-VLA-v0", "RememberColor5-VLA-v0"}) {
    for (std::uint64_t seed = 0; seed < 500; ++seed) {
      for (const std::string& key : {std::string(), kSecret}) {
        const std::int32_t number = opaque_number(key, id, seed);
        CHECK(number >= 0);
        CHECK(number == opaque_number(key, id, seed));
        numbers.insert(number);
      }
    }
  }
  CHECK(numbers.size() == 2000);
}

}  // namespace
}  // namespace engram

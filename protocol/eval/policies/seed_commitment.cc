#include "protocol/eval/policies/seed_commitment.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <optional>
#include <string_view>

#include "core/base/error.h"
#include "core/base/sha256.h"
#include "protocol/io/files.h"

namespace engram {
namespace {

constexpr std::size_t kShortest =
    32;  // characters: enough for 128 random bits as hexadecimal digits
constexpr std::size_t kLongest = 1024;
constexpr std::size_t kHashDigits = 64;
constexpr std::string_view kHowToMake = "; `openssl rand -hex 32` writes one";

bool is_printable(char c) { return c >= ' ' && c <= '~'; }

// The number of the inherited descriptor that a path names.
std::optional<int> descriptor_of(const std::string& path) {
  if (path == "-") return STDIN_FILENO;
  for (const std::string_view folder : {"/dev/fd/", "/proc/self/fd/"}) {
    if (!path.starts_with(folder)) continue;
    const char* const end = path.data() + path.size();
    int number = -1;
    const auto [last, error] = std::from_chars(path.data() + folder.size(), end, number);
    if (error == std::errc() && last == end && number >= 0) return number;
  }
  return path == "/dev/stdin" ? std::optional(STDIN_FILENO) : std::nullopt;
}

// Reads to the end, or until there are more characters than a secret may have.
std::string read_line(int descriptor, const std::string& shown) {
  std::string text;
  char piece[256];
  while (text.size() <= kLongest + 1) {
    const ssize_t got = ::read(descriptor, piece, sizeof piece);
    if (got == 0) break;
    if (got > 0) text.append(piece, static_cast<std::size_t>(got));
    if (got < 0 && errno != EINTR) {
      throw Error(Error::kIo, "'" + shown + "' cannot be read: " + std::strerror(errno));
    }
  }
  return text;
}

// Standard streams stay open, so that no other file takes their place.
void give_up(int descriptor) {
  if (descriptor > STDERR_FILENO) {
    ::close(descriptor);
    return;
  }
  const int nothing = ::open("/dev/null", O_RDWR | O_CLOEXEC);
  if (nothing < 0) return;
  ::dup2(nothing, descriptor);
  ::close(nothing);
}

}  // namespace

SeedCommitment::SeedCommitment(std::string secret)
    : secret_(std::move(secret)), hash_(to_hex(sha256(secret_))) {
  std::string_view line = secret_;
  if (line.ends_with('\n')) line.remove_suffix(1);
  const auto refuse = [](const std::string& what) {
    throw Error(Error::kInvalidArgument,
                "secret seed: " + what + ", one line of " + std::to_string(kShortest) + " to " +
                    std::to_string(kLongest) + " characters needed" + std::string(kHowToMake));
  };
  if (!std::ranges::all_of(line, is_printable)) refuse("characters that are not printable given");
  if (line.size() < kShortest || line.size() > kLongest) {
    refuse(std::to_string(line.size()) + " characters given");
  }
}

SeedCommitment SeedCommitment::of_hash(std::string hash) {
  const bool hexadecimal = hash.find_first_not_of("0123456789abcdef") == std::string::npos;
  if (hash.size() != kHashDigits || !hexadecimal) {
    throw Error(Error::kIo, "hash of the secret seed: '" + hash + "' given, " +
                                std::to_string(kHashDigits) + " hexadecimal digits needed");
  }
  SeedCommitment commitment;
  commitment.hash_ = std::move(hash);
  return commitment;
}

SeedCommitment SeedCommitment::read(const std::filesystem::path& file) {
  if (const std::optional<int> inherited = descriptor_of(file.string())) {
    const std::string text = read_line(*inherited, file.string());
    give_up(*inherited);
    return SeedCommitment(text);
  }
  const std::optional<std::string> text = read_input(file);
  if (!text) throw Error(Error::kIo, "'" + file.string() + "' does not exist");
  return SeedCommitment(*text);
}

std::uint64_t SeedCommitment::start_seed() const {
  return leading_number(sha256("engram start seed\n" + secret_));
}

std::int32_t opaque_number(const std::string& key, std::string_view env_id, std::uint64_t seed) {
  const std::string text =
      key + "\nengram episode " + std::string(env_id) + " " + std::to_string(seed);
  constexpr int kBits = 31;
  return static_cast<std::int32_t>(leading_number(sha256(text)) >> (64 - kBits));
}

}  // namespace engram

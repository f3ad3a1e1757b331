// Sealed evaluations: their seeds follow from a secret that stands in no arguments, environment
// or results before the run is over (docs/evaluation.md).
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

namespace engram {

class SeedCommitment {
 public:
  // Throws Error (kInvalidArgument) unless it is one line of 32 to 1,024 printable characters.
  explicit SeedCommitment(std::string secret);
  // A commitment of which the hash alone is known. Throws Error (kIo) if it is none.
  static SeedCommitment of_hash(std::string hash);
  // The secret in a file. "-", /dev/fd/N and /proc/self/fd/N are descriptors that this process has
  // inherited: they are closed afterwards, so that no other process inherits them. Throws Error:
  // kIo if it cannot be read, kInvalidArgument as above.
  static SeedCommitment read(const std::filesystem::path& file);

  // SHA-256 of the secret, as sha256sum prints it for the file.
  const std::string& hash() const { return hash_; }
  bool has_secret() const { return !secret_.empty(); }
  const std::string& secret() const { return secret_; }
  // Seed of the first episode. Says nothing about the secret.
  std::uint64_t start_seed() const;

 private:
  SeedCommitment() = default;

  std::string secret_;
  std::string hash_;
};

// The number by which policies know an episode: the same in every run, of no use to find its seed
// without the key. 0 to 2^31 - 1.
std::int32_t opaque_number(const std::string& key, std::string_view env_id, std::uint64_t seed);

}  // namespace engram

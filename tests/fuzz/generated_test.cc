// The fuzz targets on inputs that are made here, the same ones in every run: changed and mixed ones
// of their corpora. ENGRAM_GENERATED_INPUTS says how many for each, and has them counted.
#include <catch2/catch.hpp>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <random>
#include <string>
#include <vector>

#include "tests/build_paths.h"
#include "tests/fuzz/targets.h"
#include "tests/sanitizers.h"
#include "tests/temporary_folder.h"

namespace engram {
namespace {

using Bytes = std::vector<std::uint8_t>;

constexpr int kInputs = 150;  // of each target

std::vector<Bytes> corpus_of(const char* target) {
  std::vector<std::filesystem::path> paths;
  for (const auto& entry :
       std::filesystem::directory_iterator(std::filesystem::path(test::kData) / "fuzz" / target)) {
    paths.push_back(entry.path());
  }
  std::sort(paths.begin(), paths.end());
  std::vector<Bytes> corpus;
  for (const auto& path : paths) {
    const std::string text = test::read_file(path);
    corpus.emplace_back(text.begin(), text.end());
  }
  return corpus;
}

class Generator {
 public:
  explicit Generator(std::vector<Bytes> corpus) : corpus_(std::move(corpus)) {}

  Bytes next() {
    Bytes input = pick(8) == 0 ? random_bytes() : corpus_[pick(corpus_.size())];
    for (std::size_t changes = pick(6); changes > 0; --changes) change(input);
    return input;
  }

 private:
  std::size_t pick(std::size_t count) { return random_() % count; }
  std::uint8_t byte() { return static_cast<std::uint8_t>(random_()); }

  Bytes random_bytes() {
    Bytes bytes(pick(200));
    for (std::uint8_t& one : bytes) one = byte();
    return bytes;
  }
  void change(Bytes& input) {
    constexpr std::uint8_t kOdd[] = {0, 1, 0x1b, 0x7f, 0x80, 0xff, '-', '=', '"', '.'};
    const std::size_t at = pick(input.size() + 1);
    const auto place = input.begin() + static_cast<std::ptrdiff_t>(at);
    switch (pick(5)) {
      case 0:
        if (at < input.size()) input[at] = byte();
        break;
      case 1:
        input.insert(place, kOdd[pick(std::size(kOdd))]);
        break;
      case 2:
        input.erase(place, place + static_cast<std::ptrdiff_t>(pick(input.size() - at + 1)));
        break;
      case 3: {
        const Bytes& other = corpus_[pick(corpus_.size())];
        input.insert(place, other.begin(),
                     other.begin() + static_cast<std::ptrdiff_t>(pick(other.size() + 1)));
        break;
      }
      default: {
        const Bytes more = random_bytes();
        input.insert(place, more.begin(), more.end());
      }
    }
  }

  std::vector<Bytes> corpus_;
  std::mt19937 random_{20261123};
};

TEST_CASE("Fuzz targets: generated inputs", "[fuzz]") {
  // Batches of the C API's target, and their threads, last until the process ends.
  const test::ForgivenLeaks forgiven;
  const char* wanted = std::getenv("ENGRAM_GENERATED_INPUTS");
  const int inputs = wanted == nullptr ? kInputs : std::atoi(wanted);
  for (const fuzz::Target& target : fuzz::kTargets) {
    Generator generator(corpus_of(target.name));
    fuzz::tally = {};
    int failures = 0;
    for (int i = 0; i < inputs; ++i) {
      const Bytes input = generator.next();
      try {
        target.run(input);
      } catch (const std::exception& error) {
        ++failures;
        UNSCOPED_INFO("input " << i << ": " << error.what());
      }
    }
    INFO(target.name);
    CHECK(failures == 0);
    if (wanted == nullptr) continue;
    std::printf("%-16s %d inputs, %ld calls accepted, %ld refused\n", target.name, inputs,
                fuzz::tally.accepted, fuzz::tally.refused);
  }
}

}  // namespace
}  // namespace engram

// What an episode draws, and how users fix parts of it.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/column.h"
#include "core/base/constant.h"
#include "core/math/random.h"

namespace engram {

// One sampled quantity of an episode. Each has a random stream of its own, so fixing one does not
// change the others.
struct Draw {
  std::string name;
  int width = 1;         // number of values
  bool integer = false;  // whole numbers only
  double low = 0;        // least and greatest value, both included
  double high = 0;
  std::string unit;
  std::string description;
  bool distinct = false;  // no two of its values are equal
  // The constant that is the range of its values, [low, high], which resets may narrow; or empty.
  std::string constant = {};
};

// A user's choice: the quantity of that name takes these values.
struct Pin {
  std::string name;
  std::vector<double> values;
};

// Least and greatest value of a draw in one environment, within those of the batch.
struct Narrowing {
  int draw = 0;  // index, the engine's draw included
  double low = 0;
  double high = 0;
};

// Purposes of random streams that are not draws of a task begin here.
enum : std::uint32_t {
  kPurposeRobotNoise = 0x4000'0000,
  kPurposeBlindGuess = 0x4000'0001,
  kPurposeTokenOrder = 0x4001'0000,    // + how often something has come into view
  kPurposeRandomPolicy = 0x8000'0000,  // + elapsed
};

// Sets a task's random streams apart from those of others with the same seed, so that what is
// hidden in one task tells nothing about another. The key of a stream is the seed xor this.
std::uint64_t stream_salt(std::string_view id);

// Name of the engine's own draw, which every task has first.
inline constexpr const char* kRobotNoiseDraw = "robot_noise";

// The pins of every environment, and its narrower ranges, as columns.
class PinTable {
 public:
  PinTable() = default;
  // draws: the engine's and the task's, at most 64.
  PinTable(ColumnStore& store, std::vector<Draw> draws);

  const std::vector<Draw>& draws() const { return draws_; }

  // Throws Error, naming what is allowed, unless every pin names a draw, each draw once, and
  // number, type and size of its values fit that draw.
  void check(const std::vector<Pin>& pins) const;
  // What these values of range constants mean: [least, greatest], or one number. Throws Error,
  // naming what is allowed, unless every constant is the range of a draw and keeps within it.
  std::vector<Narrowing> narrowings(const ConstantTable& ranges) const;

  // Throws what these would throw for a saved row of the columns.
  void check_saved(std::span<const std::byte> row) const;
  // Replaces the pins of one environment; they must have been checked.
  void set(int env, const std::vector<Pin>& pins) const;

  // Replaces the narrower ranges of one environment.
  void narrow(int env, std::span<const Narrowing> narrowings) const;

  // The values that a draw is fixed to, or null.
  const double* values(int env, int draw) const;
  // The range of its values, [low, high], or null where nobody has narrowed it.
  const double* range(int env, int draw) const;

 private:
  int find(const std::string& name) const;
  void check_saved_ranges(std::span<const std::byte> row) const;

  std::vector<Draw> draws_;
  std::vector<int> offsets_;
  Column<std::uint64_t> pinned_;  // bit per draw
  Column<double> values_;
  Column<std::uint64_t> narrowed_;  // bit per draw
  Column<double> ranges_;           // (draws * 2)
};

// The episode that begins in one environment, as its task sees it. `draw` is an index of the task's
// own draws.
class Episode {
 public:
  // key: of its random streams.
  Episode(const PinTable& pins, int env, std::uint64_t key, std::uint64_t number)
      : pins_(pins), env_(env), key_(key), number_(number) {}

  int env() const { return env_; }

  // Values that the user has fixed, or null.
  const double* pinned(int draw) const { return pins_.values(env_, draw + 1); }

  RandomStream stream(int draw) const { return {key_, number_, static_cast<std::uint32_t>(draw)}; }
  RandomStream engine_stream(std::uint32_t purpose) const { return {key_, number_, purpose}; }

  // Narrows least and greatest value of a draw to what the user has said of its range.
  template <class T>
  void narrow(int draw, T& low, T& high) const {
    if (const double* range = pins_.range(env_, draw + 1)) {
      low = static_cast<T>(range[0]);
      high = static_cast<T>(range[1]);
    }
  }
  // The pinned value, or one drawn uniformly from low..high, or from the narrower range.
  int integer(int draw, int low, int high) const;
  // The same from [low, high).
  double real(int draw, double low, double high) const;

 private:
  const PinTable& pins_;
  int env_;
  std::uint64_t key_;
  std::uint64_t number_;
};

}  // namespace engram

// Random variables of an episode, and the pins and ranges by which users fix or narrow them.
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

// A sampled quantity of an episode. Each has a random stream of its own, so fixing one does not
// change the others.
struct RandomVariable {
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

// Least and greatest value of a random variable in one environment, within those of the batch.
struct NarrowedRange {
  int variable = 0;  // index, the engine's variable included
  double low = 0;
  double high = 0;
};

// Purposes of random streams that are no variables of a task begin here.
enum : std::uint32_t {
  kPurposeRobotNoise = 0x4000'0000,
  kPurposeBlindGuess = 0x4000'0001,
  kPurposeChoiceOrder = 0x4000'0002,
  kPurposeTokenOrder = 0x4001'0000,  // + how often something has come into view
  kPurposeProbePast = 0x4002'0000,
  kPurposeProbeResampling = 0x4002'0001,
  kPurposeProbeOthers = 0x4002'0002,
  kPurposePerturbation = 0x4003'0000,  // + the axis
  kPurposeImageNoise = 0x4004'0000,
  kPurposeRandomPolicy = 0x8000'0000,  // + elapsed
  kPurposeActionNoise = 0xc000'0000,   // + elapsed
};

// Sets a task's random streams apart from those of others with the same seed, so that the hidden
// quantity of one task reveals nothing about another. The key of a stream is the seed xor this.
std::uint64_t stream_salt(std::string_view id);

// Salt of the streams of random and blind policies with that seed; 0 for the seed 0.
constexpr std::uint64_t policy_salt(std::uint64_t policy_seed) {
  return policy_seed * 0x9e3779b97f4a7c15u;  // odd: different seeds have different salts
}

// Name of the engine's own variable, which every task has first.
inline constexpr const char* kRobotNoiseVariable = "robot_noise";

// The pins of every environment, and its narrower ranges, as columns.
class PinTable {
 public:
  PinTable() = default;
  // variables: the engine's and the task's, at most 64.
  PinTable(ColumnStore& store, std::vector<RandomVariable> variables);

  const std::vector<RandomVariable>& variables() const { return variables_; }

  // Throws Error, naming what is allowed, unless every pin names a variable, each variable once,
  // and number, type and size of its values fit it.
  void check(const std::vector<Pin>& pins) const;
  // Reads values of range constants: [least, greatest], or one number. Throws Error, naming what is
  // allowed, unless every constant is the range of a variable and keeps within it.
  std::vector<NarrowedRange> narrowed_ranges(const ConstantTable& ranges) const;

  // Throws the errors of both for a saved row of the columns.
  void check_saved(std::span<const std::byte> row) const;
  // Replaces the pins of one environment; they must have been checked.
  void set(int env, const std::vector<Pin>& pins) const;

  // Replaces the narrower ranges of one environment.
  void narrow(int env, std::span<const NarrowedRange> ranges) const;

  // The values that a variable is fixed to, or null.
  const double* values(int env, int variable) const;
  // The range of its values, [low, high], or null where it is not narrowed.
  const double* range(int env, int variable) const;

 private:
  int find(const std::string& name) const;
  void check_saved_ranges(std::span<const std::byte> row) const;

  std::vector<RandomVariable> variables_;
  std::vector<int> offsets_;
  Column<std::uint64_t> pinned_;  // bit per variable
  Column<double> values_;
  Column<std::uint64_t> narrowed_;  // bit per variable
  Column<double> ranges_;           // (variables * 2)
};

// The episode that begins in one environment, as its task sees it. `variable` is an index of the
// task's own variables.
class Episode {
 public:
  // key: of its random streams.
  Episode(const PinTable& pins, int env, std::uint64_t key, std::uint64_t number)
      : pins_(pins), env_(env), key_(key), number_(number) {}

  int env() const { return env_; }

  // Values that the user has fixed, or null.
  const double* pinned(int variable) const { return pins_.values(env_, variable + 1); }

  RandomStream stream(int variable) const {
    return {key_, number_, static_cast<std::uint32_t>(variable)};
  }
  RandomStream engine_stream(std::uint32_t purpose) const { return {key_, number_, purpose}; }

  // Narrows least and greatest value of a variable to the user's range.
  template <class T>
  void narrow(int variable, T& low, T& high) const {
    if (const double* range = pins_.range(env_, variable + 1)) {
      low = static_cast<T>(range[0]);
      high = static_cast<T>(range[1]);
    }
  }
  // The pinned value, or one drawn uniformly from low..high, or from the narrower range.
  int integer(int variable, int low, int high) const;
  // The pinned value, or one drawn uniformly from [low, high).
  double real(int variable, double low, double high) const;

 private:
  const PinTable& pins_;
  int env_;
  std::uint64_t key_;
  std::uint64_t number_;
};

}  // namespace engram

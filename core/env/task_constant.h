// Constants of a task that users may change when a batch is made: the class constants that the
// original's documentation names for that.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/base/constant.h"

namespace engram {

// Constants that every task has.
inline constexpr const char* kHorizonConstant = "max_episode_steps";
inline constexpr const char* kNoiseConstant = "robot_init_qpos_noise";

// One of them, as this task has it.
struct TaskConstant {
  // What its value is.
  enum class Kind {
    kInteger,
    kReal,
    kIntegerRange,  // [least, greatest], both included; drawn anew in every episode
    kRealRange,
    kReals,  // a fixed number of them
    kName,
    kNames,  // no two alike
  };

  std::string name;
  Kind kind = Kind::kReal;
  Constant value;
  double low = 0;  // least and greatest number, both included; of names: how many there may be
  double high = 0;
  std::vector<std::string> names = {};  // what names may be
  std::string unit;
  std::string description;
};

// The value of a number; nothing for anything else.
std::optional<double> as_number(const Constant& constant);
// A value as messages show it.
std::string in_words(const Constant& constant);

}  // namespace engram

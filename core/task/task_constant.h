// Constants of a task: the class constants of the original benchmark, and those that users may
// change when a batch is made.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/base/constant.h"

namespace engram {

// Constants that every task has.
inline constexpr const char* kHorizonConstant = "max_episode_steps";
inline constexpr const char* kNoiseConstant = "robot_init_qpos_noise";
inline constexpr const char* kRobotConstant = "robot_uids";

// One constant, as this task has it.
struct TaskConstant {
  // Type of the values that users may choose.
  enum class Kind {
    kFixed,  // cannot be changed; a value of any type
    kInteger,
    kReal,
    kIntegerRange,  // [least, greatest], both included; drawn anew in every episode
    kRealRange,
    kReals,  // a fixed number of them
    kName,
    kNames,   // no two alike
    kColors,  // likewise: names, or [red, green, blue] from 0 to 1
  };

  std::string name;
  Kind kind = Kind::kFixed;
  Constant value;
  double low = 0;  // least and greatest number, both included; of names: how many there may be
  double high = 0;
  std::vector<std::string> names = {};  // those that may be chosen
  std::string unit = {};
  std::string description = {};
  bool published = true;  // a class constant of the original
  bool chosen = false;    // by the user
  bool changed = false;   // the user has chosen another value than the task's own
  // The class constant, where the original writes the value in another form.
  std::optional<Constant> published_value = std::nullopt;

  bool changeable() const { return kind != Kind::kFixed; }
  // The value in the form of the class constant.
  const Constant& published_form() const { return published_value ? *published_value : value; }
};

// Name and value of the class constants, in order.
ConstantTable published_constants(const std::vector<TaskConstant>& constants);
// Name and value of those that the user has changed, in order.
ConstantTable changed_constants(const std::vector<TaskConstant>& constants);

// The value of a number; nothing for anything else.
std::optional<double> as_number(const Constant& constant);
// A value as messages show it.
std::string in_words(const Constant& constant);

}  // namespace engram

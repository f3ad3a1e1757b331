// The description of a custom task: facts, scene, draws, columns.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/base/constant.h"
#include "core/base/field.h"
#include "core/task/task.h"
#include "mjcf/prop.h"

namespace engram::tasks {

// A constant that users may change, or a fixed one.
struct CustomConstant {
  std::string name;
  TaskConstant::Kind kind =
      TaskConstant::Kind::kFixed;  // or kInteger, kReal, a range of them, kName
  Constant value;
  double low = 0;
  double high = 0;
  std::string unit = {};
  std::string text = {};
  std::vector<std::string> names = {};  // those of kName
};

// A random variable of its episodes.
struct CustomDraw {
  enum class Kind {
    kInteger,  // `width` numbers of low..high
    kReal,
    kOrder,   // 0, ..., width - 1 in any order
    kChoice,  // `width` different ones of 0, ..., high
    kPlaces,  // points x, y of an area, all at least `min_distance` apart; width: 2 for each
  };

  std::string name;
  Kind kind = Kind::kInteger;
  int width = 1;
  double low = 0;
  double high = 0;
  std::array<double, 2> area_low{};  // m: x, y
  std::array<double, 2> area_high{};
  double min_distance = 0;  // m
  std::string unit = {};
  std::string text = {};
  std::string constant = {};            // whose range it is; or empty
  std::vector<std::string> names = {};  // of whole numbers from low on, for words; or empty

  bool is_real() const { return kind == Kind::kReal || kind == Kind::kPlaces; }
};

// A column of its memory or of its infos.
struct CustomColumn {
  Field field;
  std::optional<std::pair<int, int>> limits;  // least and greatest value, of int32 and bool
};

// Words for its episodes. {name} stands for a draw's value.
struct CustomWords {
  std::vector<std::string> subtasks;  // the plan; empty: it has no words
  std::string memory;                 // what has to be remembered
  std::string unknown = "right";      // for the hidden draw until the cue has been shown
};

// The list of answers that it may be asked for.
struct CustomChoices {
  std::string question;
  std::vector<std::string> items;  // empty: there is no list
  int count = 1;                   // items of an answer, all different
};

struct CustomDescription {
  int candidates = 1;
  double guess_rate = 0;
  std::string answer;
  double answer_rate = 0;
  Termination termination = Termination::kNever;
  bool frozen_cue = false;
  double success_reward = 1;
  int oracle_dim = 0;
  std::string hidden;
  std::vector<std::pair<std::string, std::string>> phases;
  bool table_ends = false;
  std::vector<mjcf::Prop> props;
  std::vector<CustomDraw> draws;
  std::vector<CustomColumn> memory;
  std::vector<CustomColumn> infos;
  std::vector<Field> state_fields;
  CustomWords words;
  CustomChoices choices;
  bool moves_before_physics = false;
  bool has_oracle = false;
  bool has_blind = false;
  bool has_sweep = false;
};

}  // namespace engram::tasks

// The first answer that a robot gives in an episode: the moment at which it commits to one of the
// candidates (TaskInfo::answer says how).
#pragma once

#include <cstdint>

#include "core/base/column.h"

namespace engram {

// Name of the task option under which a wrong first answer fails the episode.
inline constexpr const char* kStrictOption = "strict";

class Answers {
 public:
  // Adds the outputs.
  void bind(ColumnStore& outputs) {
    answered_ = outputs.add<std::uint8_t>("answered", 1, "", "the robot has given an answer");
    first_ = outputs.add<std::int32_t>("first_answer", 1, "", "which, 0 before there is one");
    correct_ = outputs.add<std::uint8_t>("first_answer_correct", 1, "", "it was the right one");
  }

  // The robot commits to `answer`; of several in an episode the first one counts.
  void give(int env, int answer, bool correct) const {
    if (answered_[env] != 0) return;
    answered_[env] = 1;
    first_[env] = answer;
    correct_[env] = correct ? 1 : 0;
  }

  bool given(int env) const { return answered_[env] != 0; }
  bool wrong(int env) const { return given(env) && correct_[env] == 0; }

 private:
  Column<std::uint8_t> answered_;
  Column<std::int32_t> first_;
  Column<std::uint8_t> correct_;
};

}  // namespace engram

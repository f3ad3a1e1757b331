// What an environment says of its first answer.
#pragma once

#include "tests/env_helpers.h"

namespace engram::test {

struct FirstAnswer {
  bool given = false;
  int number = 0;
  bool correct = false;

  friend bool operator==(const FirstAnswer&, const FirstAnswer&) = default;
};

inline FirstAnswer first_answer(const Batch& batch) {
  return {*row<std::uint8_t>(batch.output("answered"), 0) != 0,
          *row<std::int32_t>(batch.output("first_answer"), 0),
          *row<std::uint8_t>(batch.output("first_answer_correct"), 0) != 0};
}

}  // namespace engram::test

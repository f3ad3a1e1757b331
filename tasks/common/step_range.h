// Numbers of control steps that episodes draw.
#pragma once

#include <string>
#include <utility>

#include "core/base/constant.h"
#include "core/env/episode.h"

namespace engram::tasks {

// Inclusive range of a number of control steps.
struct StepRange {
  int low = 1;
  int high = 1;

  Constant constant() const { return ConstantList{low, high}; }
  // A draw from this range, for TaskInfo::draws; `index` is its place there. constant: the name of
  // the range, where resets may narrow it.
  RandomVariable draw(std::string name, std::string description, std::string constant = {}) const {
    return {.name = std::move(name),
            .integer = true,
            .low = static_cast<double>(low),
            .high = static_cast<double>(high),
            .unit = "control steps",
            .description = std::move(description),
            .constant = std::move(constant)};
  }
  int sample(const Episode& episode, int index) const { return episode.integer(index, low, high); }
};

}  // namespace engram::tasks

// Forms in which users write constants, beside the one in which a task keeps them.
#pragma once

#include <optional>

#include "core/task/task_constant.h"
#include "mjcf/prop.h"

namespace engram::tasks {

// A user's value in the form in which the constant is kept: a list of names where it was written as
// the class constant is, a table {"0": "cube"} or numbers of names [0, 2], and names of colours, or
// [red, green, blue], where it was written with arrays of red, green, blue and alpha. Whatever has
// no such form stays as it is.
Constant kept_form(const TaskConstant& about, const Constant& given);

// A colour in the kept form: its name where it has one.
Constant kept_color(const mjcf::Rgba& color);
// Colour of a name, or of red, green and blue from 0 to 1; nothing if it is neither.
std::optional<mjcf::Rgba> as_color(const Constant& kept);

// Tests values for equality; numbers are equal in single precision, as arrays of colours have it.
bool is_same_value(const Constant& one, const Constant& other);

}  // namespace engram::tasks

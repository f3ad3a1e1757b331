// Numbers for people to read.
#pragma once

#include <string>

namespace engram {

// With that many digits behind the point.
std::string decimal(double value, int digits);

}  // namespace engram

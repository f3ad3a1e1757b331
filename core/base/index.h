// Whole numbers as indices of containers.
#pragma once

#include <cstddef>

namespace engram {

constexpr std::size_t at(int index) { return static_cast<std::size_t>(index); }

}  // namespace engram

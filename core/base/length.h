// The check that every door to a batch makes.
#pragma once

#include <cstddef>

namespace engram {

// Throws Error, saying both numbers, unless they are equal.
void require_length(const char* what, std::size_t given, std::size_t needed);

}  // namespace engram

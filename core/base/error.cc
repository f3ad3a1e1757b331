#include "core/base/error.h"

namespace engram {

void require_length(const char* what, std::size_t given, std::size_t needed) {
  if (given == needed) return;
  throw Error(Error::kInvalidArgument, std::string(what) + ": " + std::to_string(given) +
                                           " values given, " + std::to_string(needed) + " needed");
}

}  // namespace engram

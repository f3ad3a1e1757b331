#include "tasks/family.h"

namespace engram {

std::string_view split_name(Split split) noexcept {
  switch (split) {
    case Split::kShort:
      return "short";
    case Split::kMedium:
      return "medium";
    case Split::kLong:
      return "long";
    case Split::kExtended:
      return "extended";
    case Split::kRl:
      return "rl";
  }
  return "";
}

}  // namespace engram

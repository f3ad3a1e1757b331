#include "tasks/family_content.h"

#include <map>
#include <mutex>

#include "core/threads/process_mutex.h"

namespace engram {
namespace {

using FamilyContents = std::map<const Family*, std::string>;

// Never destroyed, as families are not. Used under ProcessLock::kVariants.
FamilyContents& family_contents() {
  static auto* const contents = new FamilyContents;
  return *contents;
}

}  // namespace

void set_content(const Family& family, const std::string& sha256) {
  const std::scoped_lock lock(process_mutex(ProcessLock::kVariants));
  family_contents()[&family] = sha256;
}

std::string content_of(const Family& family) {
  const std::scoped_lock lock(process_mutex(ProcessLock::kVariants));
  const auto found = family_contents().find(&family);
  return found == family_contents().end() ? "" : found->second;
}

}  // namespace engram

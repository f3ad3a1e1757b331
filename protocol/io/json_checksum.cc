#include "protocol/io/json_checksum.h"

#include "core/base/sha256.h"

namespace engram {
namespace {

constexpr const char* kChecksum = "checksum";

}  // namespace

std::string document_checksum(const JsonTable& document) {
  constexpr std::size_t kDigits = 16;
  return to_hex(sha256(to_line(document))).substr(0, kDigits);
}

void add_checksum(JsonTable& document) {
  document.emplace_back(kChecksum, document_checksum(document));
}

bool has_valid_checksum(const Json& document) {
  const auto* entries = std::get_if<JsonTable>(&document.value);
  if (entries == nullptr || entries->empty() || entries->back().first != kChecksum) return false;
  const JsonTable rest(entries->begin(), entries->end() - 1);
  return entries->back().second == Json(document_checksum(rest));
}

}  // namespace engram

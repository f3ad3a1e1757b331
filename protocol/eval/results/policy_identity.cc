#include "protocol/eval/results/policy_identity.h"

#include <utility>

#include "protocol/io/json_values.h"
#include "protocol/io/printable.h"

namespace engram {
namespace {

constexpr const char* kIdentityFile = "policy.json";
constexpr const char* kCheckpoint = "checkpoint";
constexpr std::size_t kMaxText = 100;

}  // namespace

PolicyIdentity::PolicyIdentity(std::optional<ResultFolder> folder) : folder_(std::move(folder)) {
  if (folder_) told_ = in(folder_->files());
}

void PolicyIdentity::take(const Json& told) {
  const std::lock_guard lock(mutex_);
  if (has_other_checkpoint(told_, told)) {
    throw Error(Error::kUnavailable, "the policy tells checkpoint " + checkpoint_text(told) +
                                         ", and told " + checkpoint_text(told_) +
                                         " before in this run; one run has one policy");
  }
  if (!is_null(told_) || is_null(told)) return;
  told_ = told;
  if (folder_) folder_->files().write_file(kIdentityFile, to_text(told_));
}

Json PolicyIdentity::document() const {
  const std::lock_guard lock(mutex_);
  return told_;
}

Json PolicyIdentity::in(const OpenFolder& folder) {
  const std::optional<std::string> text = folder.read_file(kIdentityFile);
  return text ? parse_json(*text).value_or(Json()) : Json();
}

Json checkpoint_of(const Json& told) { return value_or_null(told, kCheckpoint); }

bool has_other_checkpoint(const Json& a, const Json& b) {
  const Json one = checkpoint_of(a);
  const Json other = checkpoint_of(b);
  return !is_null(one) && !is_null(other) && one != other;
}

std::string checkpoint_text(const Json& told) {
  const std::string text = printable(to_line(checkpoint_of(told)));
  return text.size() > kMaxText ? text.substr(0, kMaxText) + "..." : text;
}

}  // namespace engram

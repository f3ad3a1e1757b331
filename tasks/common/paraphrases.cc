#include "tasks/common/paraphrases.h"

#include <algorithm>
#include <optional>

#include "tasks/common/procedure_paraphrases.h"
#include "tasks/common/recall_paraphrases.h"

namespace engram {
namespace {

// A text around the place of a number, "{angle_deg}"; without one, `head` is all of it.
struct Template {
  std::string_view head;
  std::string_view place;
  std::string_view tail;
};

Template split(std::string_view text) {
  const std::size_t open = text.find('{');
  if (open == std::string_view::npos) return {text, {}, {}};
  const std::size_t end = text.find('}', open) + 1;
  return {text.substr(0, open), text.substr(open, end - open), text.substr(end)};
}

bool is_number(std::string_view text) {
  if (text.starts_with('-')) text.remove_prefix(1);
  return !text.empty() && std::ranges::all_of(text, [](char c) { return c >= '0' && c <= '9'; });
}

// What stands in a text at the template's place, "" if it has none; nothing if it is another text.
std::optional<std::string_view> match(std::string_view form, std::string_view text) {
  const auto [head, place, tail] = split(form);
  if (place.empty()) return text == form ? std::optional(std::string_view()) : std::nullopt;
  if (text.size() < head.size() + tail.size() || !text.starts_with(head) || !text.ends_with(tail)) {
    return std::nullopt;
  }
  text.remove_prefix(head.size());
  text.remove_suffix(tail.size());
  return is_number(text) || text == place ? std::optional(text) : std::nullopt;
}

std::string fill_in(std::string_view form, std::string_view value) {
  const auto [head, place, tail] = split(form);
  std::string text(head);
  if (!place.empty()) text += value;
  return text.append(tail);
}

}  // namespace

std::vector<std::string> paraphrases(std::string_view instruction) {
  for (const auto table : {recall_paraphrases(), procedure_paraphrases()}) {
    for (const ParaphraseSet& set : table) {
      const auto value = match(set.instruction, instruction);
      if (!value) continue;
      std::vector<std::string> texts;
      for (const std::string_view other : set.others) texts.push_back(fill_in(other, *value));
      return texts;
    }
  }
  return {};
}

}  // namespace engram

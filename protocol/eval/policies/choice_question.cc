#include "protocol/eval/policies/choice_question.h"

#include <algorithm>
#include <charconv>
#include <numeric>

#include "core/base/error.h"
#include "core/base/join.h"
#include "protocol/io/printable.h"

namespace engram {
namespace {

// A number in digits, -1 for other texts.
int index_in(std::string_view text) {
  int index = -1;
  const char* const end = text.data() + text.size();
  const auto [rest, error] = std::from_chars(text.data(), end, index);
  return error == std::errc() && rest == end ? index : -1;
}

}  // namespace

void ChoiceAnswer::set(std::span<const int> indices) {
  try {
    question_.form.check(indices, static_cast<int>(question_.choices.size()));
  } catch (const Error& error) {
    throw Error(Error::kInvalidArgument, std::string("policy: ") + error.what());
  }
  indices_.assign(indices.begin(), indices.end());
}

void ChoiceAnswer::set(std::span<const std::string> texts) {
  std::vector<int> indices;
  for (const std::string& text : texts) {
    const auto found = std::ranges::find(question_.choices, text);
    const bool known = found != question_.choices.end();
    const int index = known ? static_cast<int>(found - question_.choices.begin()) : index_in(text);
    if (index < 0) {
      constexpr std::size_t kMax = 200;  // bytes of a text that are shown
      throw Error(Error::kInvalidArgument, "policy: choice '" + printable(text.substr(0, kMax)) +
                                               "' given, " + join(question_.choices) +
                                               ", or an index, allowed");
    }
    indices.push_back(index);
  }
  set(indices);
}

std::span<const int> ChoiceAnswer::indices() const {
  if (indices_.empty()) throw Error(Error::kInvalidArgument, "policy: no choice given");
  return indices_;
}

std::vector<int> choice_order(const ChoiceForm& form, std::string_view id, std::uint64_t seed,
                              int number, std::size_t items) {
  std::vector<int> order(items);
  std::iota(order.begin(), order.end(), 0);
  if (form.ordered) return order;
  RandomStream random(seed ^ stream_salt(id), static_cast<std::uint64_t>(number),
                      kPurposeChoiceOrder);
  random.permutation(order);
  return order;
}

}  // namespace engram

#include "protocol/make/benchmark_csv.h"

#include <algorithm>
#include <array>
#include <cctype>

namespace engram {
namespace {

// Families whose published demonstrations come from learned policies, but for the long tasks. All
// others come from motion planning.
constexpr std::array<std::string_view, 6> kLearned = {"ShellGame", "Remember", "FindImposter",
                                                      "Intercept", "Rotate",   "TakeItBack"};

std::string_view data_source(const RegistryEntry& entry) {
  const bool is_long = entry.id.find("-Long-") != std::string_view::npos;
  const bool learned = !is_long && std::ranges::any_of(kLearned, [&](std::string_view family) {
    return entry.family.starts_with(family);
  });
  return learned ? "PPO" : "Motion Planning";
}

// "Short", as the original writes it.
std::string title_case(std::string_view word) {
  std::string title(word);
  title.front() = static_cast<char>(std::toupper(static_cast<unsigned char>(title.front())));
  return title;
}

std::string csv_text(std::string_view text) {
  std::string result = "\"";
  for (const char letter : text) {
    if (letter == '"') result += letter;
    result += letter;
  }
  return result + "\"";
}

}  // namespace

std::string benchmark_csv(std::span<const RegistryEntry* const> entries) {
  std::string table =
      "id;Name;Max Length;Memory Type;Horizon Split;Data Source;language_instruction\n";
  int number = 0;
  for (const RegistryEntry& entry : registry()) {
    if (!entry.canonical) continue;
    ++number;
    const auto is_it = [&entry](const RegistryEntry* other) { return other->id == entry.id; };
    if (std::ranges::none_of(entries, is_it)) continue;
    table += std::to_string(number) + ";" + std::string(entry.id) + ";" +
             std::to_string(entry.horizon) + ";" + std::string(entry.memory_type) + ";" +
             title_case(split_name(entry.split)) + ";" + std::string(data_source(entry)) + ";" +
             csv_text(entry.instruction) + "\n";
  }
  return table;
}

}  // namespace engram

#include "apps/task_files.h"

#include <algorithm>
#include <string_view>

#include "apps/task_process.h"
#include "protocol/make/task_library.h"

namespace engram::apps {
namespace {

constexpr std::string_view kPython = ".py";

// Where the id begins in a word such as my_tasks.py:LampOrder-v0; npos for any other word, such as
// the my_policy.py:load of other options.
std::size_t id_in(std::string_view word) {
  const std::size_t colon = word.rfind(':');
  if (colon == std::string_view::npos || word.starts_with('-')) return std::string_view::npos;
  const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
  const auto is_part = [&](char c) {
    return is_digit(c) || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '-' ||
           c == '_' || c == '.';
  };
  const std::string_view id = word.substr(colon + 1);
  const std::size_t version = id.rfind("-v");
  const bool is_id = version != std::string_view::npos && version > 0 && version + 2 < id.size() &&
                     std::ranges::all_of(id, is_part) &&
                     std::ranges::all_of(id.substr(version + 2), is_digit);
  return is_id && word.substr(0, colon).ends_with(kPython) ? colon + 1 : std::string_view::npos;
}

// True for `check`, which loads files by itself.
bool is_check(const std::vector<std::string>& words) {
  std::size_t command = 0;
  while (command < words.size() && words[command].starts_with('-')) {
    const bool has_value = words[command] == "--tasks" || words[command] == "--variants";
    command += has_value ? 2 : 1;
  }
  return command < words.size() && words[command] == "check";
}

}  // namespace

void load_task_file(const std::filesystem::path& file) {
  if (file.extension() == kPython) {
    load_python_tasks(file);
  } else {
    load_tasks(file);
  }
}

std::vector<std::string> with_task_files(const std::vector<std::string>& words) {
  if (is_check(words)) return words;
  std::vector<std::string> options;
  std::vector<std::string> others;
  for (const std::string& word : words) {
    const std::size_t id = id_in(word);
    if (id == std::string::npos) {
      others.push_back(word);
      continue;
    }
    const std::string option = "--tasks=" + word.substr(0, id - 1);
    if (std::ranges::find(options, option) == options.end()) options.push_back(option);
    others.push_back(word.substr(id));
  }
  options.insert(options.end(), others.begin(), others.end());
  return options;
}

}  // namespace engram::apps

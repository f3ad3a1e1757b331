#include "protocol/parallel/run_header.h"

#include <algorithm>
#include <limits>

#include "core/base/error.h"
#include "core/base/join.h"
#include "protocol/io/json_values.h"

namespace engram {
namespace {

constexpr const char* kOption = "--shard";
constexpr const char* kOut = "--out";

std::string quoted(const std::string& word) {
  constexpr std::string_view kPlain =
      "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-+=./:,@%";
  if (!word.empty() && word.find_first_not_of(kPlain) == std::string::npos) return word;
  std::string text = "'";
  for (const char letter : word)
    text += letter == '\'' ? std::string("'\\''") : std::string{letter};
  return text + "'";
}

RunHeader read(const Json& document) {
  constexpr auto kMax = static_cast<std::uint64_t>(std::numeric_limits<int>::max());
  RunHeader header;
  header.kind = text(part(document, "kind"));
  if (const Json& shard = part(document, "shard"); !is_null(shard)) {
    header.shard = parse_shard("shard", text(shard));
  }
  for (const Json& word : list(part(document, "command"))) header.command.push_back(text(word));
  header.run = part(document, "run");
  for (const Json& task : list(part(document, "tasks"))) {
    const JsonList& values = list(task);
    if (values.size() != 3) throw Error(Error::kIo, "tasks");
    header.tasks.push_back({text(values[0]),
                            {static_cast<int>(whole_number(values[1], kMax)),
                             static_cast<int>(whole_number(values[2], kMax))}});
  }
  return header;
}

}  // namespace

JsonTable RunHeader::document() const {
  JsonList all;
  for (const Task& task : tasks) {
    all.emplace_back(JsonList{task.name, task.load.episodes, task.load.horizon});
  }
  return {{"kind", kind},
          {"shard", shard ? Json(to_text(*shard)) : Json()},
          {"command", to_list(command)},
          {"run", run},
          {"tasks", all}};
}

RunHeader RunHeader::of(const Json& document, const std::filesystem::path& file) {
  try {
    return read(document);
  } catch (const Error& error) {
    throw Error(Error::kIo,
                "'" + file.string() + "' is of no run of this engram (" + error.what() + ")");
  }
}

std::vector<TaskLoad> RunHeader::loads() const {
  std::vector<TaskLoad> loads;
  for (const Task& task : tasks) loads.push_back(task.load);
  return loads;
}

std::string RunHeader::command_of(const Shard& other) const {
  std::vector<std::string> words = command;
  const std::string with_value = std::string(kOption) + "=";
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (words[i].starts_with(with_value)) words[i] = with_value + to_text(other);
    if (words[i] == kOption && i + 1 < words.size()) words[i + 1] = to_text(other);
  }
  return shell_line(words);
}

std::string RunHeader::command_of_whole(const std::string& out) const {
  std::vector<std::string> words;
  for (std::size_t i = 0; i < command.size(); ++i) {
    const bool named = command[i] == kOption || command[i] == kOut;
    const bool with_value = command[i].starts_with(std::string(kOption) + "=") ||
                            command[i].starts_with(std::string(kOut) + "=");
    if (named) ++i;  // its value
    if (!named && !with_value) words.push_back(command[i]);
  }
  words.insert(words.end(), {kOut, out});
  return shell_line(words);
}

std::string shell_line(const std::vector<std::string>& words) { return join(words, quoted, " "); }

}  // namespace engram

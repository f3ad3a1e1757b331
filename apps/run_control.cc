#include "apps/run_control.h"

#include <fmt/format.h>

#include <fstream>
#include <iterator>

#include "apps/options.h"
#include "apps/output.h"
#include "protocol/io/html.h"
#include "protocol/parallel/run_header.h"

namespace engram::apps {

unsigned parse_time_limit(const std::string& text) {
  constexpr unsigned kMax = 366 * 24 * 3600;
  constexpr std::string_view kUnits = "smh";
  constexpr unsigned kSeconds[] = {1, 60, 3600};
  const std::size_t unit = text.empty() ? std::string_view::npos : kUnits.find(text.back());
  const bool named = unit != std::string_view::npos;
  const std::string digits = named ? text.substr(0, text.size() - 1) : text;
  const unsigned factor = named ? kSeconds[unit] : 1;
  try {
    return factor * static_cast<unsigned>(parse_unsigned("--time-limit", digits, 1, kMax / factor));
  } catch (const Error&) {
    throw Error(Error::kInvalidArgument,
                "--time-limit: '" + text +
                    "' given, a whole number of seconds (90, 90s), minutes (55m) or hours (2h), a "
                    "year at most, allowed");
  }
}

void add_run_control(const Command& command, RunControl& control) {
  command
      .add_option(
          "--shard",
          [&control](const std::string& text) { control.shard = parse_shard("--shard", text); },
          "Plays share I of N alone, into DIR/shard-I-of-N of --out; the same command goes on "
          "after "
          "an interruption, `engram merge` makes one result of all N")
      .type_name("I/N");
  command
      .add_option(
          "--time-limit",
          [&control](const std::string& text) { control.time_limit = parse_time_limit(text); },
          "Ends like Ctrl-C this long after its start: 90s, 55m, 2h")
      .type_name("TIME");
  command
      .add_option(
          "--mpi",
          [&control](const std::string& text) {
            control.mpi = require_option<MpiMode>("--mpi", text);
          },
          "Joins the ranks of mpirun or srun: where a launcher has started this process, always, "
          "or never")
      .type_name("auto|on|off")
      .default_str("auto");
}

void require_folder(const RunControl& control, const std::string& out) {
  if (!control.shard || !out.empty()) return;
  throw Error(Error::kInvalidArgument,
              "--shard: given without --out, for its folder; --out DIR needed");
}

void print_shard(const Shard& shard, const std::filesystem::path& folder, std::size_t episodes,
                 bool json) {
  if (json) {
    print(engram::to_text(
        JsonTable{{"shard", to_text(shard)}, {"out", folder.string()}, {"episodes", episodes}}));
    return;
  }
  print(fmt::format("shard {}: {} in '{}'; once all shards are finished: {}\n", to_text(shard),
                    counted(episodes, "episode"), folder.string(),
                    shell_line({"engram", "merge", folder.parent_path().string()})));
}

std::vector<std::string> words_of_command() {
  std::ifstream file("/proc/self/cmdline", std::ios::binary);
  const std::string all((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  std::vector<std::string> words;
  for (std::size_t begin = 0; begin < all.size();) {
    const std::size_t end = std::min(all.find('\0', begin), all.size());
    words.push_back(all.substr(begin, end - begin));
    begin = end + 1;
  }
  if (!words.empty()) words.front() = "engram";
  return words;
}

}  // namespace engram::apps

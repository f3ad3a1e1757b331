// Results as tables for papers, spreadsheets and leaderboards.
#pragma once

#include <array>
#include <string>
#include <string_view>

#include "core/base/names.h"
#include "protocol/io/json.h"

namespace engram {

enum class TableFormat {
  kMarkdown,
  kLatex,
  kCsv,       // a line per task
  kEpisodes,  // comma-separated, a line per episode
  kVlaEval,   // an entry of the leaderboard of vla-evaluation-harness
};
inline constexpr std::array kTableFormatNames = {"md", "latex", "csv", "episodes", "vla-eval"};
constexpr const auto& names_of(TableFormat) { return kTableFormatNames; }

// tasks: documents of one policy.
std::string result_table(TableFormat format, const JsonList& tasks);

// Comma-separated values: a line per task, and a line per episode.
std::string summary_csv(const JsonList& tasks);
std::string episodes_csv(const JsonList& tasks);

}  // namespace engram
